"""Publishers on this machine whose greeting lacks something, and sockets that cannot be opened."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from typing import Any

import pytest

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node import same_host
from pyros1.wire.header import encode_header
from pyros1.wire.local import LOCAL_PROTOCOL

from ...bodies import encode_frame

FIELDS = {"callerid": "/fake", "topic": "/t", "type": "std_msgs/Float64", "md5sum": Float64._md5sum}


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.dialogue.MIN_BACKOFF", 0.01)
    monkeypatch.setattr("pyros1.node.subscribing.dialogue.MAX_BACKOFF", 0.02)


@pytest.fixture
def publisher(fake_node: Any) -> Iterator[socket.socket]:
    """A publisher's listening socket for programs of this machine."""
    if not same_host.host_key():
        pytest.skip("no shared memory on this system")
    listener, name = same_host.listen()
    listener.settimeout(5)
    fake = fake_node("/fake")
    fake.answers["requestTopic"] = [1, "ready", [LOCAL_PROTOCOL, name]]
    fake.publish("/t")
    yield listener
    listener.close()


@pytest.mark.parametrize(
    ("token", "is_socket", "reason"),
    [
        (None, True, "no token in its connection header"),
        ("00" * 16, False, "no descriptor came with the publisher's header"),
    ],
    ids=["no token", "no socket"],
)
def test_a_greeting_without_what_shared_memory_needs(
    make_node: Any,
    environ: dict[str, str],
    publisher: socket.socket,
    watch_log: Any,
    token: str | None,
    is_socket: bool,
    reason: str,
) -> None:
    listener = make_node("listener", environ={**environ, "PYROS1_TRANSPORTS": "local,tcp"})
    log = watch_log(listener)
    subscriber = listener.subscribe("t", Float64, print)
    sock, _ = publisher.accept()
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    nothing = os.open(os.devnull, os.O_RDONLY)
    header = encode_header(FIELDS | ({} if token is None else {"token": token}))
    with sock, near, far:
        socket.send_fds(sock, [header], [far.fileno() if is_socket else nothing])
        os.close(nothing)
        log.saw(reason)
        assert not subscriber.num_connections
        sock.settimeout(5)
        while sock.recv(1000):  # the listener's header, then the end
            pass


def test_a_listener_that_can_open_no_socket_for_datagrams_says_so(
    make_node: Any, watch_log: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)

    def fail(*_: object) -> socket.socket:
        raise OSError(24, "Too many open files")

    monkeypatch.setattr("pyros1.node.subscribing.udp_source.datagram_socket", fail)
    publisher, listener = make_node("talker").advertise("t", Float64), make_node("listener")
    log = watch_log(listener)
    listener.subscribe("t", Float64, print, transports=("udp", "tcp"))
    log.saw("cannot open a UDP socket for /t: Too many open files")
    assert publisher.wait_for_subscribers(timeout=20), "over TCP"


def test_a_publisher_that_sends_too_much_with_its_header_is_asked_again(
    make_node: Any, fake_node: Any, collect: Any
) -> None:
    fake, got = fake_node("/fake"), collect()
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, got)
    sock, _ = fake.accept()
    sock.sendall(encode_header(FIELDS) + b"\xff\xff\xff\xff")  # the length of a message
    fake.accept_subscriber().sendall(encode_frame(Float64(3)))
    got.wait(1)
    assert got.data == [3]


def test_a_node_of_the_process_that_does_not_publish_yet_is_asked_again(make_node: Any, collect: Any) -> None:
    """As after an update of the master that is older than what the node does."""
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    talker.master.register_publisher("/t", "std_msgs/Float64", talker.uri)
    subscriber = listener.subscribe("t", Float64, got)
    assert not subscriber.wait_for_publishers(timeout=0.05)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(4)
    assert got.wait(1) and got.data == [4]
