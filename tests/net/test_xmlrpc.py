"""XmlRpcServer, XmlRpcClient and RpcCaller against each other and against broken peers (M01, M04, M05, M39, M41)."""

from __future__ import annotations

import errno
import os
import socket
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any
from xmlrpc.client import Fault, MultiCall, ServerProxy

import pytest

from pyros1.ground.errors import DeadlineError, Error, ProtocolError, UnreachableError, XmlRpcFault
from pyros1.net.loop import Loop
from pyros1.net.rpc_caller import RpcCaller
from pyros1.net.xmlrpc_client import XmlRpcClient
from pyros1.net.xmlrpc_server import ServerLimits, XmlRpcServer, make_unknown_method_fault
from pyros1.wire.http import HttpLimits, build_request, build_response
from pyros1.wire.http_head import date_field
from pyros1.wire.xmlrpc import dumps_call, dumps_response

LIMITS = ServerLimits(
    http=HttpLimits(head=1000, body=2_000_000),
    max_connections=4,
    max_buffered=1_500_000,
    request_timeout_s=0.3,
    idle_timeout_s=30.0,
)


@pytest.fixture
def errors() -> list[BaseException]:
    return []


@pytest.fixture
def loop(errors: list[BaseException]) -> Iterator[Loop]:
    loop = Loop("test", errors.append)
    loop.start()
    yield loop
    loop.stop()


def dispatch(method: str, params: Sequence[Any]) -> Any:
    if method == "echo":
        return list(params)
    if method == "fail":
        raise ValueError("oh")
    if method == "null":
        return None
    raise make_unknown_method_fault(method)


@pytest.fixture
def server(loop: Loop) -> Iterator[XmlRpcServer]:
    server = XmlRpcServer(loop, dispatch, bind_host="127.0.0.1", advertised_host="localhost", limits=LIMITS)
    yield server
    server.close()


@pytest.fixture
def client(server: XmlRpcServer) -> Iterator[XmlRpcClient]:
    client = XmlRpcClient(server.uri, timeout=20)
    yield client
    client.close()


class Peer:
    """A server that does what the test says with each connection."""

    def __init__(self, *behaviours: Callable[[socket.socket], object]) -> None:
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.uri = f"http://127.0.0.1:{self.listener.getsockname()[1]}/"
        self.behaviours = behaviours
        self.thread = threading.Thread(target=self._serve)
        self.thread.start()

    def _serve(self) -> None:
        for behaviour in self.behaviours:
            sock, _ = self.listener.accept()
            with sock:
                sock.settimeout(5)
                behaviour(sock)

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *_: object) -> None:
        self.thread.join(5)
        self.listener.close()


def read_request(sock: socket.socket) -> bytes:
    data = b""
    while not data.endswith(b"</methodCall>"):
        data += sock.recv(65536)
    return data


def answer(value: object) -> Callable[[socket.socket], object]:
    def behave(sock: socket.socket) -> None:
        read_request(sock)
        sock.sendall(build_response(200, dumps_response(value)))

    return behave


def until_closed(sock: socket.socket) -> None:
    while sock.recv(65536):
        pass


def raw(server: XmlRpcServer, data: bytes) -> bytes:
    """What the server says before it closes the connection."""
    with socket.create_connection(("127.0.0.1", server.port), timeout=20) as sock:
        sock.sendall(data)
        got = b""
        while True:
            try:
                more = sock.recv(65536)
            except ConnectionResetError:
                return got
            if not more:
                return got
            got += more


# ---- server and blocking client


def test_calls_on_one_kept_connection(server: XmlRpcServer, client: XmlRpcClient) -> None:
    for i in range(5):
        assert client.call("echo", i, {"a": [True]}) == [i, {"a": [True]}]
    assert server.num_connections == 1


def test_m05_unknown_methods_and_failures_are_faults(client: XmlRpcClient, errors: list[BaseException]) -> None:
    with pytest.raises(XmlRpcFault, match='method "nope" is not supported'):
        client.call("nope")
    assert errors == []
    with pytest.raises(XmlRpcFault, match="ValueError: oh"):
        client.call("fail")
    assert [str(error) for error in errors] == ["oh"]
    with pytest.raises(XmlRpcFault, match="None"):
        client.call("null")
    assert client.call("echo") == []


def test_m04_m05_multicall_with_the_standard_library(server: XmlRpcServer) -> None:
    with ServerProxy(server.uri) as proxy:
        calls = MultiCall(proxy)
        calls.echo(1)
        calls.nope()
        calls.echo("é")
        results = calls()
        assert results[0] == [1]
        with pytest.raises(Fault, match="nope"):
            results[1]
        assert results[2] == ["é"]
        multicall = proxy.system.multicall
        assert multicall([]) == []
        for wrong in (3, [3], [{"params": []}], [{"methodName": "echo", "params": 1}]):
            try:
                assert multicall(wrong)[0]["faultCode"] == 1
            except Fault as fault:
                assert fault.faultCode == 1
        nested = multicall([{"methodName": "system.multicall", "params": [[]]}])
        assert nested[0]["faultCode"] == 1


def test_m01_only_two_paths_and_only_post(server: XmlRpcServer) -> None:
    body = dumps_call("echo", [1])
    end = b"GET / HTTP/1.1\r\nConnection: close\r\n\r\n"
    for path in ("/", "/RPC2"):
        assert raw(server, build_request("h", path, body) + end).startswith(b"HTTP/1.1 200 ")
    assert raw(server, build_request("h", "/other", body) + end).startswith(b"HTTP/1.1 404 ")
    assert raw(server, end).startswith(b"HTTP/1.1 501 ")
    old = raw(server, b"POST / HTTP/1.0\r\nContent-Length: %d\r\n\r\n" % len(body) + body)
    assert old.endswith(dumps_response([1]))


def test_pipelined_requests_are_answered_in_order(server: XmlRpcServer) -> None:
    data = b"".join(build_request("h", "/", dumps_call("echo", [i])) for i in range(20))
    got = raw(server, data + b"GET / HTTP/1.1\r\nConnection: close\r\n\r\n")
    places = [got.index(dumps_response([i])) for i in range(20)]
    assert places == sorted(places)


def test_every_answer_has_a_date_and_it_is_made_once_per_second(
    server: XmlRpcServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[tuple[int, ...]] = []
    clock = iter([784111777.0, 784111777.2, 784111777.999, 784111778.0])

    def field(when: time.struct_time) -> bytes:
        made.append(when[3:6])
        return date_field(when)

    monkeypatch.setattr("pyros1.net.xmlrpc_server.time", lambda: next(clock))
    monkeypatch.setattr("pyros1.net.xmlrpc_server.date_field", field)
    calls = b"".join(build_request("h", "/", dumps_call("echo", [i])) for i in range(2))
    got = raw(server, calls + b"GET / HTTP/1.1\r\n\r\n" + b"nonsense\r\n\r\n")
    assert [head.split(b" ", 2)[1] for head in got.split(b"HTTP/1.1")[1:]] == [b"200", b"200", b"501", b"400"]
    dates = [line for line in got.splitlines() if line.startswith(b"Date")]
    assert dates == [b"Date: Sun, 06 Nov 1994 08:49:37 GMT"] * 3 + [b"Date: Sun, 06 Nov 1994 08:49:38 GMT"]
    assert made == [(8, 49, 37), (8, 49, 38)]


def test_large_answers_to_a_slow_reader_do_not_hold_up_others(server: XmlRpcServer, client: XmlRpcClient) -> None:
    text = "x" * 1_000_000
    request = build_request("h", "/", dumps_call("echo", [text]))
    with socket.create_connection(("127.0.0.1", server.port), timeout=20) as slow:
        slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 65536)
        slow.sendall(request)
        assert client.call("echo", 1) == [1]
        wanted = len(build_response(200, dumps_response([text]), date=date_field(time.gmtime(0))))
        got = 0
        while got < wanted:
            got += len(slow.recv(1 << 20))
        assert got == wanted


@pytest.mark.parametrize(
    ("data", "status"),
    [
        (b"nonsense\r\n\r\n", b"400"),
        (b"POST / HTTP/1.1\r\n\r\n", b"411"),
        (b"POST / HTTP/1.1\r\nContent-Length: 3000000\r\n\r\n", b"413"),
        (b"A" * 2000, b"431"),
    ],
)
def test_broken_requests_are_answered_and_closed(server: XmlRpcServer, data: bytes, status: bytes) -> None:
    assert raw(server, data).split(b" ", 2)[1] == status


def test_bad_xml_is_a_fault(server: XmlRpcServer, client: XmlRpcClient) -> None:
    end = b"GET / HTTP/1.1\r\nConnection: close\r\n\r\n"
    assert b"<fault>" in raw(server, build_request("h", "/", b"<!DOCTYPE a>") + end)
    assert client.call("echo") == []


def test_a_slow_request_is_cut_off(server: XmlRpcServer) -> None:
    began = time.monotonic()
    assert raw(server, b"POST / HTTP/1.1\r\nContent-Le") == b""
    assert time.monotonic() - began < 15
    assert server.num_connections == 0


def test_pages_of_web_sites_are_refused(server: XmlRpcServer) -> None:
    """A page that is open in a browser here can send requests here, but not without this field."""
    body = dumps_call("echo", [1])
    request = b"POST / HTTP/1.1\r\nContent-Length: %d\r\nConnection: close\r\n%s\r\n"
    assert raw(server, request % (len(body), b"") + body).startswith(b"HTTP/1.1 200 ")
    for origin in (b"Origin: http://evil.example\r\n", b"origin: null\r\n"):
        assert raw(server, request % (len(body), origin) + body).startswith(b"HTTP/1.1 403 ")


def test_too_many_connections_make_room_for_new_ones(server: XmlRpcServer, client: XmlRpcClient) -> None:
    begun = [socket.create_connection(("127.0.0.1", server.port), timeout=20) for _ in range(12)]
    for sock in begun:
        sock.sendall(b"POST / HT")
    for i in range(3):
        assert client.call("echo", i) == [i]
    assert server.num_connections <= LIMITS.max_connections
    for sock in begun:
        sock.close()


def test_the_connection_that_has_been_quiet_longest_makes_room(server: XmlRpcServer) -> None:
    def ask(sock: socket.socket) -> bytes:
        sock.sendall(build_request("h", "/", dumps_call("echo", [])))
        return sock.recv(4096)

    def connected() -> socket.socket:
        return socket.create_connection(("127.0.0.1", server.port), timeout=20)

    kept = [connected() for _ in range(LIMITS.max_connections)]
    assert all(map(ask, [*kept, *kept[:2]]))
    newest = connected()
    assert ask(newest)
    assert kept[2].recv(1) == b"", "closed: the first two have asked again since"
    assert all(map(ask, (kept[0], kept[1], kept[3])))
    for sock in (*kept, newest):
        sock.close()


def test_half_of_the_files_are_left_for_other_things(loop: Loop, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.sysconf", {"SC_OPEN_MAX": 6}.__getitem__)
    server = XmlRpcServer(loop, dispatch, bind_host="127.0.0.1", advertised_host="localhost")
    monkeypatch.undo()
    clients = [XmlRpcClient(server.uri, timeout=20) for _ in range(5)]
    for client in clients:
        client.call("echo")
    assert server.num_connections == 3
    for client in clients:
        client.close()
    server.close()


def test_incomplete_requests_together_are_bounded(server: XmlRpcServer, client: XmlRpcClient) -> None:
    head = b"POST / HTTP/1.1\r\nContent-Length: 1900000\r\n\r\n"
    assert raw(server, head + b"x" * 1_899_999) == b""
    assert client.call("echo", 1) == [1]


def test_a_closed_kept_connection_is_replaced() -> None:
    with Peer(answer(1), answer(2)) as peer:
        client = XmlRpcClient(peer.uri, timeout=20)
        assert client.call("m") == 1
        assert client.call("m") == 2
        client.close()


def test_client_errors() -> None:
    with pytest.raises(ProtocolError):
        XmlRpcClient("rosrpc://h:1")
    with socket.create_server(("127.0.0.1", 0)) as unused:
        port = unused.getsockname()[1]
    with pytest.raises(UnreachableError, match=f"127.0.0.1:{port}"):
        XmlRpcClient(f"http://127.0.0.1:{port}/").call("m")
    broken: list[tuple[Callable[[socket.socket], object], type[Error]]] = [
        (lambda sock: None, UnreachableError),
        (lambda sock: (read_request(sock), sock.sendall(b"what?\r\n\r\n")), ProtocolError),
        (lambda sock: (read_request(sock), sock.sendall(build_response(404, b"no"))), ProtocolError),
        (lambda sock: (read_request(sock), sock.sendall(build_response(200, b"<a/>"))), ProtocolError),
        (lambda sock: (read_request(sock), sock.sendall(build_response(200, b"<a/>")[:-1])), ProtocolError),
        (until_closed, DeadlineError),
    ]
    for behaviour, error in broken:
        with Peer(behaviour) as peer:
            client = XmlRpcClient(peer.uri, timeout=0.2 if error is DeadlineError else 5)
            with pytest.raises(error):
                client.call("m")
            client.close()


@pytest.mark.parametrize(
    "host", ["a" * 70_000, ".".join(["a" * 63] * 100), "a" * 64, "1" * 70_000, "[" + ":" * 70_000 + "]"]
)
def test_the_longest_host_names_are_errors(host: str) -> None:
    """CVE-2019-13566."""
    with pytest.raises((ProtocolError, UnreachableError)) as caught:
        XmlRpcClient(f"http://{host}:1/", timeout=20).call("m")
    assert len(str(caught.value)) < 100_000


def test_close_interrupts_a_pending_call() -> None:
    arrived = threading.Event()

    def behave(sock: socket.socket) -> None:
        read_request(sock)
        arrived.set()
        until_closed(sock)

    with Peer(behave) as peer:
        client = XmlRpcClient(peer.uri, timeout=30)

        def close() -> None:
            arrived.wait(5)
            client.close()

        closer = threading.Thread(target=close)
        closer.start()
        with pytest.raises(UnreachableError, match="closed"):
            client.call("m")
        closer.join()


def test_threads_share_a_client(client: XmlRpcClient) -> None:
    results: list[Any] = []

    def work(number: int) -> None:
        results.extend(client.call("echo", number)[0] == number for _ in range(30))

    threads = [threading.Thread(target=work, args=(i,)) for i in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == [True] * 120


# ---- caller on the loop


class Results:
    """Collects what a caller reports."""

    def __init__(self) -> None:
        self.items: list[tuple[Any, Error | None]] = []
        self._arrived = threading.Semaphore(0)

    def done(self, value: Any, error: Error | None) -> None:
        self.items.append((value, error))
        self._arrived.release()

    def wait(self, count: int) -> None:
        for _ in range(count):
            assert self._arrived.acquire(timeout=10)


@pytest.fixture
def caller(loop: Loop) -> Iterator[RpcCaller]:
    caller = RpcCaller(loop, timeout=20)
    yield caller
    caller.close()


def test_m39_calls_to_one_uri_keep_their_order(server: XmlRpcServer, caller: RpcCaller) -> None:
    results = Results()
    for i in range(100):
        caller.call(server.uri, "echo", [i], results.done)
    results.wait(100)
    assert results.items == [([i], None) for i in range(100)]
    assert server.num_connections == 1


def test_m39_a_silent_peer_delays_nobody_else(server: XmlRpcServer, caller: RpcCaller) -> None:
    silent, quick = Results(), Results()
    with Peer(until_closed) as peer:
        caller.call(peer.uri, "m", [], silent.done, timeout=60)
        for i in range(20):
            caller.call(server.uri, "echo", [i], quick.done)
        quick.wait(20)
        assert silent.items == []
        caller.close()
        silent.wait(1)
        assert isinstance(silent.items[0][1], UnreachableError)


def test_a_call_after_one_that_was_too_late_is_made(caller: RpcCaller) -> None:
    results = Results()
    with Peer(until_closed, answer(7)) as peer:
        caller.call(peer.uri, "m", [], results.done, timeout=0.1)
        caller.call(peer.uri, "m", [], results.done)
        results.wait(2)
    assert isinstance(results.items[0][1], DeadlineError)
    assert results.items[1] == (7, None)


def test_caller_replaces_a_closed_kept_connection(caller: RpcCaller) -> None:
    results = Results()
    with Peer(answer(1), answer(2)) as peer:
        for expected in (1, 2):
            caller.call(peer.uri, "m", [], results.done)
            results.wait(1)
            assert results.items[-1] == (expected, None)


def test_calls_that_follow_a_closed_caller_end_one_after_the_other(caller: RpcCaller, loop: Loop) -> None:
    """However many there are, as when the master ends while many notices for a silent node wait."""
    ended, errors, remaining = threading.Event(), [], [3000]

    def on_done(value: Any, error: Error | None) -> None:
        errors.append(error)
        remaining[0] -= 1
        if remaining[0]:
            caller.call("http://127.0.0.1:1/", "getPid", ["/x"], on_done)
        else:
            ended.set()

    caller.close()
    loop.run(caller.call, "http://127.0.0.1:1/", "getPid", ["/x"], on_done)
    assert ended.wait(10) and {type(error) for error in errors} == {UnreachableError}


def test_caller_errors(server: XmlRpcServer, caller: RpcCaller) -> None:
    results = Results()
    with socket.create_server(("127.0.0.1", 0)) as unused:
        port = unused.getsockname()[1]
    caller.call(f"http://127.0.0.1:{port}/", "m", [], results.done)
    results.wait(1)
    caller.call("what", "m", [], results.done)
    results.wait(1)
    caller.call(server.uri, "nope", [], results.done)
    results.wait(1)
    with Peer(lambda sock: (read_request(sock), sock.sendall(build_response(500, b"")))) as peer:
        caller.call(peer.uri, "m", [], results.done)
        results.wait(1)
    kinds = [type(error) for _, error in results.items]
    assert kinds == [UnreachableError, ProtocolError, XmlRpcFault, ProtocolError]


def test_names_that_cannot_be_resolved_are_errors(
    caller: RpcCaller, loop: Loop, monkeypatch: pytest.MonkeyPatch
) -> None:
    def look_up(host: str) -> list[str]:
        raise OSError("no such host")

    monkeypatch.setattr("pyros1.net.resolve.resolve_host", look_up)
    results = Results()
    for _ in range(2):
        caller.call("http://nowhere:1/", "m", [], results.done)
    results.wait(2)
    assert all(isinstance(error, UnreachableError) and "nowhere" in str(error) for _, error in results.items)


def test_a_name_with_several_addresses_tries_them_all(
    server: XmlRpcServer, caller: RpcCaller, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.net.resolve.resolve_host", lambda host: ["127.0.0.2", "127.0.0.1"])
    results = Results()
    caller.call(f"http://somewhere:{server.port}/", "echo", [3], results.done)
    results.wait(1)
    assert results.items == [([3], None)]


class NoFiles:
    """Sockets cannot be made until there is room."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.room = threading.Event()
        real = socket.socket

        def make(*args: Any, **options: Any) -> socket.socket:
            if threading.current_thread().name == "test" and not self.room.is_set():
                raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))
            return real(*args, **options)

        monkeypatch.setattr("pyros1.net.connect.socket.socket", make)


def test_a_call_waits_until_files_can_be_opened(
    server: XmlRpcServer, caller: RpcCaller, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.net.rpc_caller.RETRY_DELAY", 0.01)
    results = Results()
    files = NoFiles(monkeypatch)
    asked: list[int] = []
    caller.make_room = lambda: (asked.append(1), len(asked) > 2 and files.room.set())
    for i in range(3):
        caller.call(server.uri, "echo", [i], results.done)
    results.wait(3)
    assert results.items == [([i], None) for i in range(3)]
    assert len(asked) == 3


def test_kept_connections_are_closed_when_no_more_files_can_be_opened(
    server: XmlRpcServer, caller: RpcCaller, monkeypatch: pytest.MonkeyPatch
) -> None:
    results, other = Results(), Results()
    caller.call(server.uri, "echo", [1], results.done)
    results.wait(1)
    NoFiles(monkeypatch)
    with Peer() as peer:
        caller.call(peer.uri, "m", [], other.done, timeout=0.3)
        other.wait(1)
    value, error = other.items[0]
    assert value is None and isinstance(error, UnreachableError) and "Too many open files" in str(error)
    until = time.monotonic() + 20
    while server.num_connections:  # until it notices that the kept one was given up
        assert time.monotonic() < until
        time.sleep(0.01)


def test_close_gives_up_what_is_pending(loop: Loop) -> None:
    caller = RpcCaller(loop)
    results = Results()
    with Peer(until_closed) as peer:
        for _ in range(3):
            caller.call(peer.uri, "m", [], results.done)
        caller.close()
        results.wait(3)
    caller.call(peer.uri, "m", [], results.done)
    results.wait(1)
    assert all(isinstance(error, UnreachableError) for _, error in results.items)
