"""server: peers that are silent, slow, wrong or hostile harm nobody.

Feature: hostile peers do no harm -- timeouts and limits everywhere
"""

from __future__ import annotations

import socket
import struct
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import NodeError
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.net.hosts import parse_uri
from pyros1.net.loop import Loop, TimerHandle
from pyros1.node import same_host
from pyros1.node.same_host import host_key
from pyros1.wire.header import MAX_HEADER_SIZE, encode_header

from ..bodies import encode
from ..parts import context_of, tcpros_port


@pytest.fixture
def node(make_node: Any) -> Any:
    node = make_node("talker")
    node.advertise("t", Float64, latch=True).publish(1.5)
    node.advertise_service("flip", "std_srvs/SetBool", lambda request: (not request.data, ""))
    return node


WANTED = {"topic": "/t", "md5sum": Float64._md5sum, "type": "std_msgs/Float64", "callerid": "/raw"}


def assert_serves(node: Any, raw_peer: Any) -> None:
    peer = raw_peer(node).greet(**WANTED)
    assert peer.answer()["type"] == "std_msgs/Float64"
    assert peer.frame() == encode(Float64(1.5))


def test_one_port_serves_topics_and_services_t04_o15(
    node: Any, raw_peer: Any, call_node: Any, service_port: Any
) -> None:
    assert_serves(node, raw_peer)
    port = service_port(node.master.lookup_service("/flip"))
    assert call_node(node, "requestTopic", "/me", "/t", [["TCPROS"]])[2][2] == port
    peer = raw_peer(node).greet(service="/flip", md5sum="*", callerid="/raw")
    answer = peer.answer()
    assert (answer["type"], answer["service"], answer["callerid"]) == ("std_srvs/SetBool", "/flip", "/talker")
    peer.sock.sendall(b"\x01\0\0\0\x01")
    assert peer.take(10) == b"\x01\x05\0\0\0" + b"\0" + b"\0\0\0\0"


def test_both_ports_listen_where_the_host_name_says_n21(node: Any) -> None:
    """The nodes of tests have ROS_HOSTNAME=localhost."""
    for port in (parse_uri(node.uri)[1], tcpros_port(node)):
        socket.create_connection(("127.0.0.1", port), timeout=5).close()
        with pytest.raises(OSError):
            socket.create_connection(("127.0.0.2", port), timeout=1)


def test_both_ends_of_a_link_notice_that_a_machine_is_gone_t37(
    make_node: Any, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
    watched = collect()
    for place in ("publishing.publisher_links.enable_keepalive", "subscribing.connector.set_nodelay_and_keepalive"):
        monkeypatch.setattr(f"pyros1.node.{place}", watched)
    publisher = make_node("talker").advertise("t", Float64)
    make_node("listener").subscribe("t", Float64, print)
    assert publisher.wait_for_subscribers(timeout=20)
    one, other = watched.wait(2)
    assert one.getsockname() == other.getpeername() and one.getpeername() == other.getsockname()


def test_a_header_with_topic_and_service_asks_for_the_topic_t04(node: Any, raw_peer: Any) -> None:
    assert raw_peer(node).greet(**WANTED, service="/flip").answer()["topic"] == "/t"


def test_any_md5_is_answered_with_the_real_type_t09(node: Any, raw_peer: Any) -> None:
    answer = raw_peer(node).greet(**{**WANTED, "md5sum": "*", "type": "*"}).answer()
    assert answer["type"] == "std_msgs/Float64"
    assert answer["md5sum"] == Float64._md5sum
    assert answer["message_definition"] == Float64._full_text
    assert answer["latching"] == "1"


def test_silent_peers_delay_nobody(node: Any, raw_peer: Any) -> None:
    for _ in range(50):
        raw_peer(node)
    assert_serves(node, raw_peer)


def test_silent_and_dripping_peers_are_closed_at_the_deadline(
    node: Any, raw_peer: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as patch:
        patch.setattr("pyros1.node.server.HEADER_TIMEOUT", 0.1)
        silent, dripping = raw_peer(node), raw_peer(node)
        dripping.sock.sendall(encode_header(WANTED)[:-1])
        assert silent.closed() and dripping.closed()
    assert_serves(node, raw_peer)


def test_a_complete_header_ends_the_deadline(node: Any, raw_peer: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """It would close the link."""
    timers: list[TimerHandle] = []
    call_later = Loop.call_later

    def keep(loop: Loop, delay: float, function: Any, *args: Any) -> TimerHandle:
        timer = call_later(loop, delay, function, *args)
        if delay == 1234.0:
            timers.append(timer)
        return timer

    monkeypatch.setattr("pyros1.node.server.HEADER_TIMEOUT", 1234.0)
    monkeypatch.setattr(Loop, "call_later", keep)
    assert_serves(node, raw_peer)
    assert raw_peer(node).greet(topic="/unknown").answer()["error"]
    assert [timer.cancelled for timer in timers] == [True, True]


def test_the_oldest_unfinished_greeting_makes_room(node: Any, raw_peer: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.server.MAX_HANDSHAKES", 3)
    peers = [raw_peer(node) for _ in range(4)]
    assert peers[0].closed()
    assert peers[3].greet(**WANTED).answer()["topic"] == "/t"
    assert peers[1].greet(**WANTED).answer()["topic"] == "/t"


def test_a_header_may_come_byte_by_byte(node: Any, raw_peer: Any) -> None:
    peer = raw_peer(node)
    peer.sock.setsockopt(6, 1, 1)  # TCP_NODELAY
    for byte in encode_header(WANTED):
        peer.sock.sendall(bytes([byte]))
    assert peer.answer()["topic"] == "/t"


@pytest.mark.parametrize(
    ("data", "reason"),
    [
        (b"GET / HTTP/1.1\r\n\r\n", "this is an HTTP request"),
        (b"POST /RPC2 HTTP/1.1\r\n", "this is an HTTP request"),
        (b"GETS", "exceeds the limit"),
        (b"\xff\xff\xff\xff", "exceeds the limit"),
        ((MAX_HEADER_SIZE + 1).to_bytes(4, "little"), "exceeds the limit"),
        (b"\x08\0\0\0\x04\0\0\0abcd", "no '='"),
        (b"\x08\0\0\0\xff\0\0\0a=cd", "runs past the end"),
        (b"\x04\0\0\0\0\0\0\0", "no '='"),
        (b"\x02\0\0\0ab", "stray bytes"),
        (b"\0\0\0\0", "no topic or service name detected"),
    ],
)
def test_garbage_is_refused_with_a_reason_t02_t08(
    node: Any, raw_peer: Any, watch_log: Any, data: bytes, reason: str
) -> None:
    log = watch_log(node)
    peer = raw_peer(node)
    peer.sock.sendall(data)
    assert reason in peer.answer()["error"]
    assert peer.closed()
    log.saw("refused a connection from 127.0.0.1", reason)
    assert_serves(node, raw_peer)


def test_who_comes_too_late_is_closed_without_a_word(node: Any, raw_peer: Any, capfd: Any) -> None:
    """An error would be logged by that peer, though all that happened is that this node ended."""
    closed = []
    node.on_shutdown(lambda: closed.append(raw_peer(node).greet(**{**WANTED, "topic": "/late"}).closed()))
    node.shutdown()
    node.log.info("after the end")
    assert closed == [True]
    err = capfd.readouterr()
    assert "refused a connection" not in err.err and "publish() on /rosout" not in err.err


def test_neither_topic_nor_service_t04(node: Any, raw_peer: Any) -> None:
    assert raw_peer(node).greet(callerid="/raw", md5sum="*").answer() == {"error": "no topic or service name detected"}


def test_unknown_topic_t13(node: Any, raw_peer: Any) -> None:
    error = raw_peer(node).greet(**{**WANTED, "topic": "/other"}).answer()["error"]
    assert error == "[/talker] is not a publisher of [/other]. Topics are [/rosout, /t]"


def test_unknown_service_t33(node: Any, raw_peer: Any, watch_log: Any) -> None:
    log = watch_log(node)
    error = raw_peer(node).greet(service="/other", md5sum="*", callerid="/raw").answer()["error"]
    assert "[/talker] is not a provider of [/other]" in error
    log.saw("refused", "/raw", "/other")


@pytest.mark.parametrize("missing", ["md5sum", "callerid"])
def test_missing_fields_t12(node: Any, raw_peer: Any, missing: str) -> None:
    for header in (WANTED, {"service": "/flip", "md5sum": "*", "callerid": "/raw"}):
        peer = raw_peer(node).greet(**{key: value for key, value in header.items() if key != missing})
        assert peer.answer()["error"] == f"Missing required '{missing}' field"
        assert peer.closed()


def test_a_peer_that_closes_at_once(node: Any, raw_peer: Any) -> None:
    for data in (b"", b"\x01", encode_header(WANTED)):
        peer = raw_peer(node)
        peer.sock.sendall(data)
        peer.close()
    assert_serves(node, raw_peer)


def test_names_from_peers_cannot_break_the_log(node: Any, raw_peer: Any, watch_log: Any) -> None:
    log = watch_log(node)
    raw_peer(node).greet(topic="%s%d\udcff", md5sum="*", callerid="%n").answer()
    log.saw("refused", "%s%d")


@pytest.mark.slow
def test_a_long_definition_is_answered_whole(make_node: Any, raw_peer: Any) -> None:
    from pyros1.msgs import from_definition

    text = "float64 data\n" + "".join(f"float64 constant_with_a_long_name_{n}\n" for n in range(20_000))
    big = from_definition("big_msgs/Big", text)
    node = make_node("talker")
    node.advertise("t", big)
    peer = raw_peer(node, receive_buffer=4096).greet(topic="/t", md5sum="*", callerid="/raw")
    assert peer.answer()["message_definition"] == big._full_text


def test_nothing_is_accepted_after_shutdown(node: Any, raw_peer: Any) -> None:
    port = tcpros_port(node)
    idle = raw_peer(port)
    node.shutdown()
    assert idle.closed()
    with pytest.raises(OSError):
        raw_peer(port)


@pytest.mark.skipif(not host_key(), reason="no shared memory on this system")
@pytest.mark.parametrize("answer", [False, OSError("no credentials")], ids=["another user", "unknown user"])
def test_a_socket_of_this_machine_is_for_programs_of_this_user(
    make_node: Any, environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, answer: Any
) -> None:
    node = make_node("local", environ={**environ, "PYROS1_TRANSPORTS": "local,tcp"})
    context = context_of(node)
    name = context.loop.run(context.local_socket_name, timeout=5)

    def is_same_user(sock: socket.socket) -> bool:
        if isinstance(answer, OSError):
            raise answer
        return bool(answer)

    monkeypatch.setattr("pyros1.node.server.is_same_user", is_same_user)
    with same_host.connect(name) as sock:
        sock.settimeout(5)
        assert sock.recv(100) == b""


def test_a_system_that_opens_no_more_sockets_is_logged(
    make_node: Any, environ: dict[str, str], watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    node = make_node("local", environ={**environ, "PYROS1_TRANSPORTS": "local,tcp"})
    log, context = watch_log(node), context_of(node)

    def fail(name: str) -> None:
        raise OSError(24, "Too many open files")

    monkeypatch.setattr("pyros1.node.server.listen", fail)
    assert context.loop.run(context.local_socket_name, timeout=5) == ""
    log.saw("cannot open a socket for programs on this machine: Too many open files")


def test_a_peer_that_is_gone_before_its_header_is_whole(node: Any, raw_peer: Any, watch_log: Any) -> None:
    log = watch_log(node)
    peer = raw_peer(node)
    peer.sock.sendall(b"\x10\0\0")
    peer.sock.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # so that it resets
    peer.close()
    assert_serves(node, raw_peer)
    assert not log.texts


def test_a_node_whose_other_port_is_in_use_leaves_nothing_open(
    make_node: Any, free_ports: Callable[[int], list[int]]
) -> None:
    used, free = free_ports(2)
    with socket.create_server(("127.0.0.1", used)), pytest.raises(NodeError, match=r"cannot listen on .*in use"):
        make_node("unlucky", ports=(used, free))
    socket.create_server(("127.0.0.1", free)).close()
