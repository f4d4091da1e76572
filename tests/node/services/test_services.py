"""services: calls, what handlers may return, and everything that can go wrong in between.

Feature: idle service clients need no threads -- a node that spins may call its own services
"""

from __future__ import annotations

import contextlib
import itertools
import os
import socket
import threading
from typing import Any

import pytest

from pyros1.ground.errors import (
    MessageError,
    NodeError,
    NodeShutdownError,
    SerializationError,
    ServiceError,
    ServiceUnavailableError,
    WaitTimeoutError,
)
from pyros1.msgs.roscpp.srv import GetLoggers, SetLoggerLevel
from pyros1.msgs.rospy_tutorials.srv import AddTwoInts, AddTwoIntsRequest, AddTwoIntsResponse
from pyros1.msgs.sensor_msgs.srv import SetCameraInfo
from pyros1.msgs.std_srvs.srv import Empty, SetBool, SetBoolResponse, Trigger, TriggerResponse
from pyros1.net.spin_wait import SpinWait
from pyros1.node.same_host import host_key
from pyros1.node.services.provider_connection import ProviderConnection
from pyros1.wire.header import encode_header

from ...bodies import encode_frame
from ...parts import context_of, tcpros_port

pytestmark = pytest.mark.parametrize("transport", ["local", "tcp"] if host_key() else ["tcp"], indirect=True)


@pytest.fixture(autouse=True)
def _both_ways(transport: str) -> None:
    """Calls between nodes of one machine and user, and those of all others."""


@pytest.fixture
def server(make_node: Any) -> Any:
    return make_node("server")


@pytest.fixture
def caller(make_node: Any) -> Any:
    return make_node("caller")


def add(request: Any) -> Any:
    return request.a + request.b


# Calls and conversions ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("persistent", [False, True])
def test_calls_p20(server: Any, caller: Any, persistent: bool) -> None:
    server.advertise_service("add", AddTwoInts, add)
    with caller.service("add", AddTwoInts, persistent=persistent) as client:
        assert client(1, 2).sum == 3
        assert client(a=4, b=5) == AddTwoIntsResponse(9)
        assert client(AddTwoIntsRequest(-1, -2)).sum == -3
        assert client.call(AddTwoIntsRequest(1 << 40, 1), timeout=5).sum == (1 << 40) + 1


@pytest.mark.parametrize(
    "value",
    [
        SetBoolResponse(True, "yes"),
        (True, "yes"),
        [True, "yes"],
        {"success": True, "message": "yes"},
    ],
)
def test_what_handlers_may_return_p19(server: Any, caller: Any, value: Any) -> None:
    server.advertise_service("s", SetBool, lambda request: value)
    assert caller.service("s", "std_srvs/SetBool")(True) == SetBoolResponse(True, "yes")


def test_a_single_value_is_wrapped_p19(server: Any, caller: Any) -> None:
    server.advertise_service("add", AddTwoInts, add)
    assert caller.service("add", AddTwoInts)(2, 3).sum == 5


@pytest.mark.parametrize("value", [[], {}, (), Empty._response_class()])
def test_empty_responses_p19(server: Any, caller: Any, value: Any) -> None:
    server.advertise_service("s", Empty, lambda request: value)
    assert caller.service("s", Empty)() == Empty._response_class()


def test_none_is_an_error_even_for_empty_responses_p19_t27(server: Any, caller: Any) -> None:
    server.advertise_service("s", Empty, lambda request: None)
    with pytest.raises(ServiceError, match=r"service cannot process request.*returned None"):
        caller.service("s", Empty)()


@pytest.mark.parametrize("value", [(1, 2, 3), {"nonsense": 1}, ("x", 5), object()])
def test_what_does_not_fit_the_response_is_told_to_the_caller(server: Any, caller: Any, value: Any) -> None:
    server.advertise_service("s", SetBool, lambda request: value)
    client = caller.service("s", SetBool, persistent=True)
    for _ in range(2):
        with pytest.raises(ServiceError, match="error processing request"):
            client(True)
    client.close()


def test_handlers_errors_reach_the_caller_and_both_logs_t27(server: Any, caller: Any, watch_log: Any) -> None:
    log = watch_log(server)

    def broken(request: Any) -> Any:
        raise ValueError("no such thing: ä")

    server.advertise_service("s", Trigger, broken)
    with pytest.raises(ServiceError, match=r"service \[/s\] responded with an error.*no such thing: ä"):
        caller.service("s", Trigger)()
    assert "in broken" in log.saw("error processing a request of /s", "ValueError")


@pytest.mark.parametrize("end", [SystemExit(3), KeyboardInterrupt()])
def test_a_handler_that_exits_is_an_error_for_the_caller_and_logged(
    server: Any, caller: Any, watch_log: Any, end: BaseException
) -> None:
    def handler(_request: Any) -> None:
        raise end

    log = watch_log(server)
    server.advertise_service("/s", Trigger, handler)
    with pytest.raises(ServiceError, match=f"error processing request: {type(end).__name__}"):
        caller.service("/s", Trigger).call(Trigger._request_class(), timeout=10)
    log.saw("handler of /s", "node.shutdown()", type(end).__name__)


def test_requests_carry_the_callers_header(server: Any, caller: Any) -> None:
    seen: list[Any] = []
    server.advertise_service("s", Empty, lambda request: seen.append(request._connection_header) or {})
    caller.service("s", Empty, headers={"token": "abc"})()
    assert seen[0]["callerid"] == "/caller"
    assert (seen[0]["token"], seen[0]["persistent"]) == ("abc", "0")


def test_responses_carry_the_providers_header(server: Any, caller: Any) -> None:
    server.advertise_service("s", Empty, lambda request: {})
    with caller.service("s", Empty, persistent=True) as kept:
        headers = [client()._connection_header for client in (caller.service("s", Empty), kept, kept)]
    for header in headers:
        assert (header["callerid"], header["type"], header["md5sum"]) == ("/server", Empty._type, Empty._md5sum)


def test_bad_requests_never_leave(server: Any, caller: Any) -> None:
    server.advertise_service("add", AddTwoInts, add)
    client = caller.service("add", AddTwoInts)
    with pytest.raises(SerializationError, match="a"):
        client("x", 1)
    with pytest.raises(
        MessageError, match=r"/add.*takes rospy_tutorials/AddTwoIntsRequest, not std_srvs/SetBoolRequest"
    ):
        client.call(SetBool._request_class(True))
    with pytest.raises(TypeError):
        client(1)


def test_large_requests_and_responses(server: Any, caller: Any) -> None:
    server.advertise_service("s", SetLoggerLevel, lambda request: {})
    server.advertise_service("t", SetBool, lambda request: (True, "x" * 3_000_000))
    caller.service("s", SetLoggerLevel)("y" * 3_000_000, "z")
    assert len(caller.service("t", SetBool)(True).message) == 3_000_000


# Connections ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("can_peek", [True, False])
def test_each_call_has_its_connection_unless_persistent_t29_t30(
    server: Any, caller: Any, monkeypatch: pytest.MonkeyPatch, can_peek: bool
) -> None:
    if not can_peek:  # as on Windows
        monkeypatch.setattr("pyros1.node.services.provider_connection.DONTWAIT", 0)
    seen: list[int] = []
    service = server.advertise_service("s", Empty, lambda request: seen.append(id(request._connection_header)) or {})
    accepted: list[Any] = []
    accept = service.accept
    service.accept = lambda *args: (accepted.append(args[1]), accept(*args))[1]
    client = caller.service("s", Empty)
    client()
    client()
    assert [header["persistent"] for header in accepted] == ["0", "0"]
    with caller.service("s", Empty, persistent=True) as kept:
        for _ in range(5):
            kept()
    assert [header["persistent"] for header in accepted] == ["0", "0", "1"]


def test_several_calls_at_once_t35(server: Any, caller: Any, in_thread: Any) -> None:
    together = threading.Barrier(5)
    server.advertise_service("s", Empty, lambda request: (together.wait(10) and {}) or {})
    client = caller.service("s", Empty)
    for call in [in_thread(client) for _ in range(5)]:
        call.join()


def test_a_persistent_client_may_be_shared_by_threads(server: Any, caller: Any, in_thread: Any) -> None:
    server.advertise_service("add", AddTwoInts, add)
    with caller.service("add", AddTwoInts, persistent=True) as client:
        calls = [in_thread(lambda n=n: [client(n, i).sum for i in range(50)]) for n in range(4)]
        for n, call in enumerate(calls):
            assert call.join() == [n + i for i in range(50)]


def test_too_many_calls_are_refused(server: Any, caller: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.services.server.MAX_CALLS", 3)
    inside, leave = threading.Semaphore(0), threading.Event()

    def wait(request: Any) -> Any:
        inside.release()
        leave.wait(10)
        return {}

    server.advertise_service("s", Empty, wait)
    client = caller.service("s", Empty)
    calls = [in_thread(client) for _ in range(3)]
    for _ in range(3):
        assert inside.acquire(timeout=20)
    try:
        with pytest.raises(ServiceError, match="too many simultaneous calls to /s"):
            client()
    finally:
        leave.set()
    for call in calls:
        call.join()
    client()


def test_probe_t31(server: Any, raw_peer: Any, watch_log: Any) -> None:
    server.advertise_service("s", SetBool, lambda request: (True, ""))
    log = watch_log(server)
    peer = raw_peer(server).greet(service="/s", md5sum="*", callerid="/raw", probe="1")
    answer = peer.answer()
    assert answer["type"] == "std_srvs/SetBool" and answer["md5sum"] == SetBool._md5sum
    assert (answer["request_type"], answer["response_type"]) == ("std_srvs/SetBoolRequest", "std_srvs/SetBoolResponse")
    assert peer.closed()
    assert not log.items, "a probe is no error (O13)"


def test_md5_mismatch_is_refused_and_both_sides_say_why_t33(server: Any, caller: Any, watch_log: Any) -> None:
    log = watch_log(server)
    server.advertise_service("s", SetBool, lambda request: (True, ""))
    with pytest.raises(ServiceError, match=rf"md5sums do not match: \[{Trigger._md5sum}\] vs. \[{SetBool._md5sum}\]"):
        caller.service("s", Trigger)()
    log.saw("refused", "/caller", "/s", "md5sums do not match")


def test_malformed_requests_are_answered_with_an_error(server: Any, raw_peer: Any) -> None:
    server.advertise_service("s", SetBool, lambda request: (True, ""))
    peer = raw_peer(server).greet(service="/s", md5sum="*", callerid="/raw", persistent="1")
    peer.answer()
    peer.sock.sendall(b"\0\0\0\0")
    assert peer.take(1) == b"\0"
    assert b"std_srvs/SetBoolRequest" in peer.frame()
    peer.sock.sendall(b"\x01\0\0\0\x01")
    assert peer.take(1) == b"\x01"


def test_bytes_behind_a_request(server: Any, raw_peer: Any, watch_log: Any) -> None:
    """They are ignored, as in stock ROS, with one warning."""
    log = watch_log(server)
    server.advertise_service("s", SetBool, lambda request: (request.data, ""))
    peer = raw_peer(server).greet(service="/s", md5sum="*", callerid="/raw", persistent="1")
    peer.answer()
    for body in (b"\x01\x02", b"\x00\x02\x03", b"\x01\x02\x03"):
        peer.sock.sendall(len(body).to_bytes(4, "little") + body)
        assert peer.take(1) == b"\x01"
        assert peer.frame()[:1] == body[:1]
    log.saw("/s", "/raw", "1 surplus byte at its end")
    assert len([line for line in log.texts if "at its end" in line]) == 1


def test_callers_with_many_names_do_not_fill_the_log(server: Any, raw_peer: Any, watch_log: Any) -> None:
    log = watch_log(server)
    server.advertise_service("s", SetBool, lambda request: (request.data, ""))
    for number in range(5):
        peer = raw_peer(server).greet(service="/s", md5sum="*", callerid=f"/raw{number}")
        peer.answer()
        peer.sock.sendall(b"\x02\0\0\0\x01\x02")
        assert peer.take(1) == b"\x01"
    log.saw("/s", "/raw0", "1 surplus byte at its end")
    assert len([line for line in log.texts if "at its end" in line]) == 1


def test_a_hostile_request_length_ends_the_connection(server: Any, raw_peer: Any, watch_log: Any) -> None:
    log = watch_log(server)
    server.advertise_service("s", SetBool, lambda request: (True, ""))
    peer = raw_peer(server).greet(service="/s", md5sum="*", callerid="/raw")
    peer.answer()
    peer.sock.sendall(b"\xff\xff\xff\xff")
    assert peer.closed()
    log.saw("/s", "/raw", "limit")


# Providers come and go ------------------------------------------------------------------------------------------------


def test_unavailable(caller: Any) -> None:
    with pytest.raises(ServiceUnavailableError, match=r"service \[/nothing\] unavailable"):
        caller.service("nothing", Empty)()


def test_a_provider_that_cannot_be_reached(caller: Any, fake_node: Any, closed_port: int) -> None:
    uri = f"rosrpc://localhost:{closed_port}"
    fake = fake_node("/fake")
    fake.master.register_service("/s", uri, fake.uri)
    with pytest.raises(ServiceUnavailableError, match=rf"/s.*{uri}"):
        caller.service("s", Empty)()


@pytest.mark.parametrize("answer", [b"", b"\xff\xff\xff\xff", b"\x04\0\0\0\0\0\0\0", b"\0\0\0\0"])
def test_a_provider_that_answers_nonsense(caller: Any, fake_node: Any, in_thread: Any, answer: bytes) -> None:
    fake = fake_node("/fake")
    fake.master.register_service("/s", f"rosrpc://localhost:{fake.port}", fake.uri)
    call = in_thread(caller.service("s", Empty))
    sock, header = fake.accept()
    assert header["service"] == "/s" and header["md5sum"] == Empty._md5sum
    sock.sendall(answer)
    sock.close()
    with pytest.raises(ServiceError, match="/s"):
        call.join()


def test_a_response_over_the_limit(caller: Any, fake_node: Any, in_thread: Any) -> None:
    from pyros1.wire.header import encode_header

    fake = fake_node("/fake")
    fake.master.register_service("/s", f"rosrpc://localhost:{fake.port}", fake.uri)
    call = in_thread(caller.service("s", Empty))
    sock, _ = fake.accept()
    sock.sendall(encode_header({"md5sum": Empty._md5sum}) + b"\x01\xff\xff\xff\xff")  # no type: as roscpp (T24)
    with pytest.raises(ServiceError, match="limit"):
        call.join()


def test_bytes_behind_a_response(caller: Any, fake_node: Any, in_thread: Any, watch_log: Any) -> None:
    """They are ignored, as in stock ROS, with a warning."""
    log, fake = watch_log(caller), fake_node("/fake")
    fake.master.register_service("/s", f"rosrpc://localhost:{fake.port}", fake.uri)
    call = in_thread(caller.service("s", Trigger))
    sock, _ = fake.accept()
    response = Trigger._response_class(True, "yes")
    body = encode_frame(response)[4:] + b"zz"
    sock.sendall(encode_header({"md5sum": Trigger._md5sum}) + b"\x01" + len(body).to_bytes(4, "little") + body)
    assert call.join() == response
    log.saw("/s", "2 surplus bytes at its end")


def test_a_provider_that_does_not_check_the_md5(caller: Any, fake_node: Any, in_thread: Any, watch_log: Any) -> None:
    """Its responses come, as in rospy, with a warning."""
    log, fake = watch_log(caller), fake_node("/fake")
    fake.master.register_service("/s", f"rosrpc://localhost:{fake.port}", fake.uri)
    call = in_thread(caller.service("s", SetBool), True)
    sock, _ = fake.accept()
    sock.sendall(encode_header({"md5sum": Empty._md5sum}) + b"\x01\x05\0\0\0\1\0\0\0\0")
    assert call.join().success is True
    log.saw(f"service /s has md5sum [{Empty._md5sum}]", f"[{SetBool._md5sum}]: its responses may be wrong")


def test_what_comes_behind_a_response_is_not_the_next_one(caller: Any, fake_node: Any, in_thread: Any) -> None:
    """A persistent client connects again."""
    fake = fake_node("/fake")
    fake.master.register_service("/s", f"rosrpc://localhost:{fake.port}", fake.uri)
    for answers in (b"\x01\0\0\0\0" * 2, b"\0\x02\0\0\0no"):
        call = in_thread((client := caller.service("s", Empty, persistent=True)) if answers[0] else client)
        sock, _ = fake.accept()
        sock.sendall(encode_header({"md5sum": Empty._md5sum}) + answers)
        if answers[0]:
            call.join()
    with pytest.raises(ServiceError, match="an error: no"):
        call.join()
    client.close()


@pytest.mark.parametrize("uri", ["http://localhost:1/", "rosrpc://localhost:99999", "rosrpc://a b:1"])
def test_a_provider_with_a_wrong_address_is_not_available(caller: Any, uri: str) -> None:
    caller.master.register_service("/s", uri, caller.uri)
    with pytest.raises(ServiceUnavailableError, match=r"\[/s\] is registered with a wrong address: .*URI"):
        caller.service("s", Empty)()


def test_the_provider_dies_during_a_call(caller: Any, fake_node: Any, in_thread: Any) -> None:
    from pyros1.wire.header import encode_header

    fake = fake_node("/fake")
    fake.master.register_service("/s", f"rosrpc://localhost:{fake.port}", fake.uri)
    client = caller.service("s", Empty, persistent=True)
    for _ in range(2):  # the second call makes a new connection
        call = in_thread(client)
        sock, _ = fake.accept()
        sock.sendall(encode_header({"md5sum": Empty._md5sum, "type": "std_srvs/Empty"}) + b"\x01\x00")
        sock.close()
        with pytest.raises(ServiceError, match="/s"):
            call.join()
    client.close()


def test_a_call_gives_up_at_its_timeout(server: Any, caller: Any) -> None:
    leave = threading.Event()
    server.advertise_service("s", Empty, lambda request: (leave.wait(10) and {}) or {})
    for persistent in (False, True):
        with (
            caller.service("s", Empty, persistent=persistent) as client,
            pytest.raises(WaitTimeoutError, match="/s"),
        ):
            client.call(Empty._request_class(), timeout=0.05)
    leave.set()


def test_shutdown_interrupts_a_call(server: Any, caller: Any, in_thread: Any) -> None:
    inside, leave = threading.Event(), threading.Event()

    def wait(request: Any) -> Any:
        inside.set()
        leave.wait(20)
        return {}

    server.advertise_service("s", Empty, wait)
    call = in_thread(caller.service("s", Empty))
    assert inside.wait(5)
    caller.shutdown()
    try:
        with pytest.raises(NodeShutdownError):
            call.join(5)
    finally:
        leave.set()


def test_close_interrupts_a_call(server: Any, caller: Any, in_thread: Any) -> None:
    inside, leave = threading.Event(), threading.Event()

    def wait(request: Any) -> Any:
        inside.set()
        leave.wait(20)
        return {}

    server.advertise_service("s", Empty, wait)
    client = caller.service("s", Empty)
    call = in_thread(client)
    assert inside.wait(5)
    client.close()
    try:
        with pytest.raises(ServiceError):
            call.join(5)
    finally:
        leave.set()


def test_the_servers_shutdown_ends_calls_under_way(server: Any, caller: Any, in_thread: Any) -> None:
    with caller.service("s", Empty, persistent=True) as client:
        server.advertise_service("s", Empty, lambda request: {})
        client()
        server.shutdown()
        with pytest.raises(ServiceError):
            client()


def test_a_replaced_provider_o03(make_node: Any, server: Any, caller: Any) -> None:
    first = server.advertise_service("s", Trigger, lambda request: (True, "first"))
    once, kept = caller.service("s", Trigger), caller.service("s", Trigger, persistent=True)
    assert once().message == kept().message == "first"
    other = make_node("other")
    other.advertise_service("s", Trigger, lambda request: (True, "second"))
    assert once().message == "second"
    assert kept().message == "first", "a persistent client is bound to its provider"
    first.shutdown()  # does not unregister the other one (M18, O02)
    assert once().message == "second"
    with pytest.raises(ServiceError):
        kept()
    assert kept().message == "second"
    kept.close()


def test_a_call_that_comes_after_the_end_is_not_served(
    server: Any, raw_peer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also if the loop, which waits for it, is too busy to end the connection first."""
    monkeypatch.setattr("pyros1.node.services.server.MAX_EARLY_CALLS", 0)
    calls: list[Any] = []
    service = server.advertise_service("s", SetBool, lambda request: calls.append(request) or (True, ""))
    peer = raw_peer(server).greet(service="/s", md5sum="*", callerid="/p", persistent="1")
    peer.answer()
    busy, leave = threading.Event(), threading.Event()
    context_of(server).loop.call_soon(lambda: busy.set() or leave.wait(10))
    assert busy.wait(10)
    service.close()
    peer.sock.sendall(b"\x01\0\0\0\x01")
    leave.set()
    assert peer.sock.recv(1) == b"" and not calls


def test_shutdown_of_a_service_unregisters_it(server: Any, caller: Any) -> None:
    with server.advertise_service("s", Empty, lambda request: {}):
        caller.service("s", Empty)()
        with pytest.raises(NodeError, match="this node already provides service /s"):
            server.advertise_service("s", Empty, lambda request: {})
    with pytest.raises(ServiceUnavailableError):
        caller.service("s", Empty)()
    server.advertise_service("s", Empty, lambda request: {}).shutdown("not needed")


def test_nothing_starts_after_shutdown(make_node: Any) -> None:
    node = make_node("a")
    client = node.service("s", Empty)
    node.shutdown()
    with pytest.raises(NodeShutdownError):
        node.advertise_service("s", Empty, lambda request: {})
    with pytest.raises(NodeShutdownError):
        client()
    with pytest.raises(NodeShutdownError):
        node.wait_for_service("s")


# Waiting --------------------------------------------------------------------------------------------------------------


def test_wait_for_service(make_node: Any, server: Any, caller: Any, in_thread: Any) -> None:
    waiting = in_thread(caller.wait_for_service, "s", 10.0)
    server.advertise_service("s", Empty, lambda request: {})
    waiting.join()
    caller.service("s", Empty).wait(5.0)


def test_wait_for_service_gives_up_p21(caller: Any, fake_node: Any, closed_port: int) -> None:
    with pytest.raises(WaitTimeoutError, match="timeout exceeded while waiting for service /s"):
        caller.wait_for_service("s", 0.05)
    fake = fake_node("/fake")
    fake.master.register_service("/s", f"rosrpc://localhost:{closed_port}", fake.uri)
    with pytest.raises(WaitTimeoutError, match=r"/s: it is registered at .*, but cannot be reached"):
        caller.wait_for_service("s", 0.05)


def test_wait_for_service_ends_with_the_node(caller: Any, in_thread: Any) -> None:
    waiting = in_thread(caller.wait_for_service, "s")
    caller.shutdown()
    with pytest.raises(NodeShutdownError):
        waiting.join()


# Nodes that spin ------------------------------------------------------------------------------------------------------


def test_a_node_that_spins_handles_requests_when_it_spins(make_node: Any, caller: Any, in_thread: Any) -> None:
    node = make_node("spinner", callbacks="spin")
    threads: list[Any] = []
    node.advertise_service("s", Empty, lambda request: threads.append(threading.current_thread()) or {})
    call = in_thread(caller.service("s", Empty))
    while not threads:
        assert call.thread.is_alive()
        node.spin_once(5.0)
    call.join()
    assert threads == [threading.current_thread()]


def test_a_node_that_ends_without_spinning_answers_with_an_error(make_node: Any, caller: Any, in_thread: Any) -> None:
    node = make_node("spinner", callbacks="spin")
    node.advertise_service("s", Empty, lambda request: {})
    call = in_thread(caller.service("s", Empty))
    assert context_of(node).callback_queue.wait(5)
    node.shutdown()
    with pytest.raises(ServiceError):
        call.join()


def test_a_handler_may_call_another_service_of_its_node(make_node: Any, caller: Any) -> None:
    node = make_node("both")
    node.advertise_service("inner", AddTwoInts, add)
    inner = node.service("inner", AddTwoInts)
    node.advertise_service("outer", AddTwoInts, lambda request: inner(request.a, request.b).sum * 2)
    assert caller.service("outer", AddTwoInts)(1, 2).sum == 6


def threads_of(node: Any) -> list[str]:
    return [thread.name for thread in threading.enumerate() if thread.name.startswith(f"{node.name}:service")]


def test_idle_and_slow_clients_cost_no_threads_and_hinder_nobody(
    server: Any, caller: Any, raw_peer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.services.server.MAX_CALLS", 20)
    monkeypatch.setattr("pyros1.node.services.client_connection.LINGER_TIME", 0.001)
    server.advertise_service("popular", SetBool, lambda request: (request.data, ""))
    server.advertise_service("other", Empty, lambda request: {})
    peers = [raw_peer(server).greet(service="/popular", md5sum="*", callerid="/p", persistent="1") for _ in range(40)]
    for number, peer in enumerate(peers):
        assert peer.answer()["service"] == "/popular"
        peer.sock.sendall(b"\x01\0\0\0\x01" if number % 2 else b"\x01\0")  # a call, or the beginning of one
        if number % 2:
            assert peer.take(10)[0] == 1
    assert len(threads_of(server)) <= 22  # those that have answered may not be free yet for the next call
    caller.service("other", Empty)()
    with caller.service("popular", SetBool, persistent=True) as client:
        assert client(True).success
    for number, peer in enumerate(peers):  # whoever waited long is served as before
        peer.sock.sendall(b"\x01\0\0\0\x01" if number % 2 else b"\0\0\x01")
        assert peer.take(10)[0] == 1


def test_calls_of_one_service_leave_room_for_the_others(
    server: Any, caller: Any, in_thread: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.services.server.MAX_CALLS", 1)
    inside, leave = threading.Event(), threading.Event()
    server.advertise_service("slow", Empty, lambda request: inside.set() or (leave.wait(10) and {}) or {})
    server.advertise_service("other", Empty, lambda request: {})
    call = in_thread(caller.service("slow", Empty))
    assert inside.wait(5)
    try:
        caller.service("other", Empty)()
        with pytest.raises(ServiceError, match="too many simultaneous calls to /slow"):
            caller.service("slow", Empty)()
    finally:
        leave.set()
    call.join()


@pytest.mark.parametrize("linger", [0.001, 5.0])
def test_requests_that_come_together_are_all_answered(
    server: Any, raw_peer: Any, monkeypatch: pytest.MonkeyPatch, linger: float
) -> None:
    monkeypatch.setattr("pyros1.node.services.client_connection.LINGER_TIME", linger)
    server.advertise_service("s", SetBool, lambda request: (request.data, ""))
    peer = raw_peer(server)
    header = {"service": "/s", "md5sum": "*", "callerid": "/raw", "persistent": "1"}
    peer.sock.sendall(encode_header(header) + b"\x01\0\0\0\x01" * 3 + b"\x01\0")
    peer.answer()
    assert [peer.take(10)[5] for _ in range(3)] == [1, 1, 1]
    peer.sock.sendall(b"\0\0\0")
    assert peer.take(10)[5] == 0
    server.shutdown()
    assert peer.closed()


@pytest.mark.parametrize("persistent", [False, True])
def test_a_node_that_spins_may_call_itself(make_node: Any, persistent: bool) -> None:
    node = make_node("spinner", callbacks="spin")
    threads: list[Any] = []

    def add_here(request: Any) -> int:
        threads.append(threading.current_thread())
        assert request._connection_header["callerid"] == "/spinner"
        return add(request)

    node.advertise_service("add", AddTwoInts, add_here)
    node.advertise_service("twice", AddTwoInts, lambda request: 2 * client(request.a, request.b).sum)
    with node.service("add", AddTwoInts, persistent=persistent) as client:
        assert client(1, 2).sum == 3, "before it spins"
        node.spin_once()
        response = client.call(AddTwoIntsRequest(3, 4), timeout=5)
        assert (response.sum, response._connection_header["callerid"]) == (7, "/spinner")
        assert node.service("twice", AddTwoInts)(1, 2).sum == 6, "from a handler"
    assert set(threads) == {threading.current_thread()}


def test_a_self_call_that_fails_says_so(make_node: Any, watch_log: Any) -> None:
    node = make_node("spinner", callbacks="spin")
    log = watch_log(node)
    node.advertise_service("bad", Empty, lambda request: 1 // 0)
    with pytest.raises(ServiceError, match="division"):
        node.service("bad", Empty)()
    log.saw("ZeroDivisionError")
    with pytest.raises(ServiceError, match="md5sums do not match"):
        node.service("bad", Trigger)()


def test_a_self_call_of_another_thread_waits_for_the_one_that_spins(make_node: Any, in_thread: Any) -> None:
    node = make_node("spinner", callbacks="spin")
    threads: list[Any] = []
    node.advertise_service("s", Empty, lambda request: threads.append(threading.current_thread()) or {})
    call = in_thread(node.service("s", Empty))
    while not threads:
        assert call.thread.is_alive()
        node.spin_once(5.0)
    call.join()
    assert threads == [threading.current_thread()]


def test_a_call_waits_for_another_threads_call_no_longer_than_its_timeout(make_node: Any, in_thread: Any) -> None:
    """It is not sent after its time: the provider would carry it out, although the caller has been told otherwise."""
    entered, leave, handled = threading.Event(), threading.Event(), []

    def handle(request: Any) -> dict[str, Any]:
        handled.append(request)
        entered.set()
        assert leave.wait(10)
        return {}

    make_node("provider").advertise_service("s", Empty, handle)
    with make_node("client").service("s", Empty, persistent=True) as client:
        call = in_thread(client)
        try:
            assert entered.wait(10)
            other = in_thread(lambda: client.call(Empty._request_class(), timeout=0.05))
            with pytest.raises(WaitTimeoutError, match="another thread"):
                other.join(5)
        finally:
            leave.set()
        call.join()
        client()
    assert len(handled) == 2


def test_a_call_that_was_refused_when_its_service_ended_is_not_handled_later(make_node: Any, in_thread: Any) -> None:
    """The client may have called another provider meanwhile."""
    node, handled = make_node("spinner", callbacks="spin"), []
    service = node.advertise_service("s", Empty, lambda request: handled.append(request) or {})
    call = in_thread(make_node("client").service("s", Empty))
    assert context_of(node).callback_queue.wait(10)
    service.shutdown()
    with pytest.raises(ServiceError, match="shutting down"):
        call.join()
    assert node.spin_once() == 1 and handled == []


def test_a_self_call_goes_to_whoever_the_master_names(make_node: Any) -> None:
    node = make_node("spinner", callbacks="spin")
    node.advertise_service("s", Trigger, lambda request: (True, "first"))
    make_node("other").advertise_service("s", Trigger, lambda request: (True, "second"))
    assert node.service("s", Trigger)().message == "second"


def test_a_call_that_nobody_spins_for_is_told(
    make_node: Any, caller: Any, in_thread: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.services.server.SPIN_WARNING_DELAY", 0.0)
    node = make_node("spinner", callbacks="spin")
    log = watch_log(node)
    node.advertise_service("s", Empty, lambda request: {})
    call = in_thread(caller.service("s", Empty))
    log.saw("a call to /s by /caller is waiting for this program to spin")
    node.spin_once(5.0)
    call.join()


def test_a_call_that_waits_a_moment_for_its_program_to_spin_is_not_logged(
    make_node: Any, caller: Any, in_thread: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks = threading.Semaphore(0)
    now = itertools.chain([100.0, 100.2, 104.9, 104.9], itertools.repeat(104.9))

    def clock() -> float:
        looks.release()
        return next(now)

    monkeypatch.setattr("pyros1.node.services.server.monotonic", clock)
    node = make_node("spinner", callbacks="spin")
    log = watch_log(node)
    node.advertise_service("s", Empty, lambda request: {})
    call = in_thread(caller.service("s", Empty))
    for _ in range(4):  # the fourth look comes after the third had its effect
        assert looks.acquire(timeout=10)
    node.spin_once(5.0)
    call.join()
    assert not [text for text in log.texts if "waiting for this program to spin" in text]


def test_types_by_name(server: Any, caller: Any) -> None:
    server.advertise_service("~s", "std_srvs/Trigger", lambda request: (True, ""))
    assert caller.service("/server/s", "std_srvs/Trigger")().success
    assert caller.service("/server/get_loggers", GetLoggers)().loggers
    with pytest.raises(MessageError, match="std_srvs/NoSuch"):
        caller.service("s", "std_srvs/NoSuch")


def test_a_request_that_trickles_in_is_given_up(make_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """A client that sends byte after byte keeps no thread for longer than REQUEST_TIMEOUT."""
    monkeypatch.setattr("pyros1.node.services.client_connection.REQUEST_TIMEOUT", 0.2)
    server = make_node("server")
    server.advertise_service("s", SetBool, lambda request: (True, ""))
    header = {"callerid": "/slow", "service": "/s", "md5sum": "*", "persistent": "1"}
    with socket.create_connection(("localhost", tcpros_port(server))) as peer:
        peer.sendall(encode_header(header))
        peer.settimeout(0.01)
        request = (1000).to_bytes(4, "little") + bytes(900)
        sent, ended = 0, False
        while not ended and sent < len(request):
            try:
                peer.sendall(request[sent : sent + 1])
                sent += 1
                ended = not peer.recv(4096)
            except TimeoutError:
                pass  # still open
            except ConnectionError:
                ended = True
    assert ended


def test_a_request_that_arrives_steadily_may_take_longer(make_node: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    has_begun, has_looked = threading.Event(), threading.Event()

    class Deadline:
        """Passes if no bytes arrive while it is looked at a hundred times."""

        def __init__(self, seconds: float) -> None:
            self.looks = self.bytes = 0
            has_begun.set()

        def add_bytes(self, count: int) -> None:
            self.bytes += count

        def remaining(self) -> float:
            self.looks += 1
            if self.bytes:
                has_looked.set()
            return 0.01 if self.bytes or self.looks < 100 else 0.0

    monkeypatch.setattr("pyros1.node.services.client_connection.TransferDeadline", Deadline)
    monkeypatch.setattr("pyros1.node.services.client_connection.REQUEST_TIMEOUT", 0.01)
    server = make_node("server")
    server.advertise_service("s", SetCameraInfo, lambda request: (True, request.camera_info.distortion_model))
    request = SetCameraInfo._request_class()
    request.camera_info.distortion_model = "x" * 1000
    body = encode_frame(request)
    with socket.create_connection(("localhost", tcpros_port(server))) as peer:
        peer.settimeout(20)
        peer.sendall(encode_header({"callerid": "/slow", "service": "/s", "md5sum": "*"}) + body[:100])
        assert has_begun.wait(20)
        peer.sendall(body[100:500])
        assert has_looked.wait(20)
        peer.sendall(body[500:])
        with peer.makefile("rb") as response:
            assert request.camera_info.distortion_model.encode() in response.read()


def test_a_client_that_does_not_take_its_response_is_given_up(
    make_node: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """And the log says so."""
    monkeypatch.setattr("pyros1.node.services.client_connection.REQUEST_TIMEOUT", 0.05)
    server = make_node("server")
    log = watch_log(server)
    server.advertise_service("s", Trigger, lambda request: (True, "x" * 20_000_000))
    with socket.create_connection(("localhost", tcpros_port(server))) as peer:
        peer.sendall(encode_header({"callerid": "/slow", "service": "/s", "md5sum": "*"}) + bytes(4))
        log.saw("a call to /s by /slow failed", "the client did not read its response within 0.05 s")


def test_a_program_that_echoes_is_no_service(caller: Any) -> None:
    """It has the port of a service that died: what it sends back would be taken for a response."""
    with socket.create_server(("127.0.0.1", 0)) as listener:

        def echo() -> None:
            sock, _ = listener.accept()
            with sock:
                while data := sock.recv(4096):
                    sock.sendall(data)

        thread = threading.Thread(target=echo)
        thread.start()
        port = listener.getsockname()[1]
        caller.master.register_service("/flip", f"rosrpc://127.0.0.1:{port}", caller.uri)
        with pytest.raises(ServiceError, match="only sends back what it receives: another program is using its port"):
            caller.service("/flip", SetBool).call(SetBool._request_class(True), timeout=10)
        thread.join(10)


def test_a_provider_that_does_not_greet_is_named(caller: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its node is stopped, or a web server has its port, which waits for a line of text."""
    monkeypatch.setattr("pyros1.node.services.provider_connection.SILENCE_TIMEOUT", 0.0)
    log = watch_log(caller)
    with socket.create_server(("127.0.0.1", 0)) as listener:
        place = f"rosrpc://127.0.0.1:{listener.getsockname()[1]}"
        caller.master.register_service("/flip", place, caller.uri)
        with pytest.raises(WaitTimeoutError):
            caller.service("/flip", SetBool).call(SetBool._request_class(True), timeout=0.7)
    wanted = ("/flip is waiting for", place, "another program")
    assert [text for text in log.texts if all(each in text for each in wanted)]
    assert len(log.texts) == 1


@pytest.mark.parametrize("together", [True, False])
def test_a_response_that_nobody_asked_for_answers_no_later_call(
    caller: Any, fake_node: Any, in_thread: Any, together: bool
) -> None:
    """Else each later call of a persistent client would get the response of the one before."""
    fake = fake_node("/fake")
    fake.master.register_service("/s", f"rosrpc://localhost:{fake.port}", fake.uri)
    with caller.service("s", Trigger, persistent=True) as client:
        for text in ("first", "second"):  # the second call makes a new connection
            call = in_thread(client)
            sock, _ = fake.accept()
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            sock.sendall(encode_header({"md5sum": Trigger._md5sum}))
            assert sock.recv(4) == bytes(4)  # the request
            response = b"\x01" + encode_frame(Trigger._response_class(True, text))
            sock.sendall(response * (1 + together))
            assert call.join().message == text
            if not together:
                sock.sendall(response)


def test_a_handler_that_raises_what_is_no_exception(server: Any, caller: Any, watch_log: Any) -> None:
    """As asyncio.CancelledError: the caller must not wait for ever, nor the thread be lost."""

    class Cancelled(BaseException):
        pass

    def handler(_request: Any) -> None:
        raise Cancelled

    log = watch_log(server)
    server.advertise_service("/s", Trigger, handler)
    with pytest.raises(ServiceError, match="error processing request: Cancelled"):
        caller.service("/s", Trigger).call(Trigger._request_class(), timeout=10)
    log.saw("error processing a request of /s", "Cancelled")


def test_a_program_that_is_interrupted_while_it_answers(make_node: Any, caller: Any, in_thread: Any) -> None:
    node = make_node("spinning", callbacks="spin")

    def handler(_request: Any) -> None:
        raise KeyboardInterrupt

    node.advertise_service("/s", Trigger, handler)
    call = in_thread(lambda: caller.service("/s", Trigger).call(Trigger._request_class(), timeout=10))
    with pytest.raises(KeyboardInterrupt):
        node.spin_once(10.0)
    with pytest.raises(ServiceError, match="its program was interrupted"):
        call.join()


def test_close_just_before_a_call(server: Any, caller: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """By another thread, when the call has found the connection, but not begun to use it."""
    server.advertise_service("s", Empty, lambda request: {})
    client = caller.service("s", Empty, persistent=True)
    client()

    def closes(call: Any, deadline: Any) -> None:
        client.close()

    monkeypatch.setattr(ProviderConnection, "deadline", property(lambda call: None, closes), raising=False)
    with pytest.raises(ServiceError, match="call to service"):
        client()


def test_a_signal_handler_that_interrupts_a_call_has_a_connection_of_its_own(
    server: Any, caller: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Or each would get the response of the other."""
    server.advertise_service("add", AddTwoInts, add)
    sums: list[int] = []
    receive_response = ProviderConnection.receive_response

    def handler() -> None:
        monkeypatch.setattr(ProviderConnection, "receive_response", receive_response)
        sums.append(client(3, 4).sum)

    def interrupted(call: ProviderConnection) -> tuple[bool, bytes]:
        handler()
        return receive_response(call)

    with caller.service("add", AddTwoInts, persistent=True) as client:
        monkeypatch.setattr(ProviderConnection, "receive_response", interrupted)
        assert client(1, 2).sum == 3
        assert client(5, 6).sum == 11
    assert sums == [7]


def test_calls_with_connections_of_their_own_wait_as_one_series(
    server: Any, caller: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Only a series shows whether polling for a response is worth it."""
    made: list[int] = []
    server.advertise_service("add", AddTwoInts, add)
    client = caller.service("add", AddTwoInts)
    monkeypatch.setattr("pyros1.node.services.provider_connection.SpinWait", lambda: made.append(1) or SpinWait())
    assert [client(number, 1).sum for number in range(3)] == [1, 2, 3]
    assert not made


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
@pytest.mark.parametrize("persistent", [False, True])
def test_a_forked_process_makes_calls_of_its_own(server: Any, caller: Any, persistent: bool) -> None:
    server.advertise_service("add", AddTwoInts, add)
    with caller.service("add", AddTwoInts, persistent=persistent) as client:
        client(1, 2)
        child = os.fork()
        if not child:
            code = 1
            with contextlib.suppress(BaseException):
                code = 0 if client(5, 6).sum == 11 else 2
            os._exit(code)
        assert os.waitpid(child, 0)[1] == 0
        assert client(3, 4).sum == 7


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
def test_a_forked_process_that_closes_its_client_leaves_the_connection_to_its_parent(server: Any, caller: Any) -> None:
    server.advertise_service("add", AddTwoInts, add)
    with caller.service("add", AddTwoInts, persistent=True) as client:
        client(1, 2)
        child = os.fork()
        if not child:
            client.close()
            os._exit(0)
        os.waitpid(child, 0)
        assert client(3, 4).sum == 7


def test_a_node_without_a_free_worker_says_so(server: Any, caller: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    server.advertise_service("s", Trigger, lambda _: (True, ""))
    with monkeypatch.context() as patch:
        patch.setattr("pyros1.node.services.workers.Workers.submit", lambda self, job: False)
        with pytest.raises(ServiceError, match="too many simultaneous calls to services of /server, try again later"):
            caller.service("s", Trigger)()
    assert caller.service("s", Trigger)().success


def test_a_response_of_the_same_type_that_others_made(server: Any, caller: Any) -> None:
    assert TriggerResponse._md5sum == SetBoolResponse._md5sum
    server.advertise_service("s", SetBool, lambda request: TriggerResponse(True, "made by others"))
    assert caller.service("s", SetBool)(True).message == "made by others"


def test_a_service_is_shut_down_once(server: Any, watch_log: Any) -> None:
    log, service = watch_log(server), server.advertise_service("s", Trigger, lambda _: (True, ""))
    service.shutdown("no longer needed")
    service.shutdown("again")
    assert [text for text in log.texts if "shuts down" in text] == ["service /s shuts down: no longer needed"]
