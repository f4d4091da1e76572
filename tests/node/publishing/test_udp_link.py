"""UdpLink without a node: hosts that are looked up late or not at all, and sends that the system refuses."""

from __future__ import annotations

import errno
import socket
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.node.publishing.udp_link import UdpLink
from pyros1.node.strand import Strand

MAX_SIZE = 1500


class Ends:
    """A link whose host name is resolved when the test says so, and the subscriber's socket."""

    def __init__(self) -> None:
        self.subscriber = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.subscriber.bind(("127.0.0.1", 0))
        self.subscriber.settimeout(5)
        self.resolved: Callable[[list[str], OSError | None], None] = lambda *_: None
        self.closed: list[UdpLink] = []
        loop: Any = SimpleNamespace(resolver=SimpleNamespace(resolve=self._resolve))
        header = {"callerid": "/listener", "topic": "/t"}
        address = ("listener", self.subscriber.getsockname()[1])
        self.link = UdpLink(loop, Strand(lambda job: job()), header, header, address, MAX_SIZE, 7, self.closed.append)

    def _resolve(self, host: str, on_resolved: Callable[[list[str], OSError | None], None]) -> None:
        assert host == "listener"
        self.resolved = on_resolved

    def received(self) -> bytes:
        """Return what is in the next datagram, which is one of connection 7."""
        datagram = self.subscriber.recv(MAX_SIZE)
        assert datagram[:4] == b"\7\0\0\0"
        return datagram[8:]


@pytest.fixture
def ends() -> Iterator[Ends]:
    ends = Ends()
    yield ends
    ends.link.close()
    ends.subscriber.close()


def test_of_messages_before_the_address_is_known_the_last_one_is_sent(ends: Ends) -> None:
    assert ends.link.topic_response("talker")[2] == 0, "no port yet"
    for data in (b"one", b"two", b"three"):
        ends.link.send(data)
    assert (ends.link.messages, ends.link.dropped) == (3, 2)
    ends.resolved(["127.0.0.1"], None)
    assert ends.received() == b"three"
    assert (ends.link.dropped, ends.link.bytes_sent) == (2, 5)
    ends.link.send([b"fo", b"ur"])
    assert ends.received() == b"four"
    assert f"to [127.0.0.1:{ends.subscriber.getsockname()[1]} on socket " in ends.link.address


@pytest.mark.parametrize(("addresses", "error"), [([], None), ([], OSError("no such host"))])
def test_without_an_address_the_link_ends(ends: Ends, addresses: list[str], error: OSError | None) -> None:
    ends.link.send(b"one")
    ends.resolved(addresses, error)
    assert ends.closed == [ends.link] and not ends.link.connected
    ends.link.send(b"two")
    assert ends.link.messages == 1, "nothing is sent any more"


def test_with_an_address_that_the_system_refuses_the_link_ends(ends: Ends) -> None:
    ends.resolved(["255.255.255.255"], None)  # a broadcast needs an option that is not set
    assert ends.closed == [ends.link]


def test_an_address_that_comes_after_the_end_opens_no_socket(ends: Ends, monkeypatch: pytest.MonkeyPatch) -> None:
    ends.link.close()
    made: list[socket.socket] = []

    def keep(*args: Any) -> socket.socket:
        made.append(SOCKET(*args))
        return made[0]

    SOCKET = socket.socket
    monkeypatch.setattr("pyros1.node.publishing.udp_link.socket.socket", keep)
    ends.resolved(["127.0.0.1"], None)
    assert [sock.fileno() for sock in made] == [-1]
    ends.link.close()
    assert ends.closed == [ends.link], "it ends once"


class Refusing:
    """A socket that raises an error for each datagram."""

    def __init__(self, error: OSError) -> None:
        self.error = error
        self.closed = False

    def send(self, data: bytes) -> int:
        raise self.error

    def connect(self, address: Any) -> None: ...
    def setblocking(self, flag: bool) -> None: ...
    def getsockname(self) -> tuple[str, int]:
        return "127.0.0.1", 1

    def fileno(self) -> int:
        return 3

    def close(self) -> None:
        self.closed = True


@pytest.mark.parametrize("early", [True, False])
def test_what_the_system_does_not_take_is_dropped(ends: Ends, monkeypatch: pytest.MonkeyPatch, early: bool) -> None:
    full = Refusing(BlockingIOError(errno.EAGAIN, "full"))
    monkeypatch.setattr("pyros1.node.publishing.udp_link.socket.socket", lambda *_: full)
    if early:
        ends.link.send(b"one")
    ends.resolved(["127.0.0.1"], None)
    if not early:
        ends.link.send(b"one")
    assert (ends.link.dropped, ends.link.bytes_sent, ends.link.connected) == (1, 0, True)


@pytest.mark.parametrize("early", [True, False])
def test_a_link_ends_when_nobody_listens(ends: Ends, monkeypatch: pytest.MonkeyPatch, early: bool) -> None:
    gone = Refusing(ConnectionRefusedError(errno.ECONNREFUSED, "nobody there"))
    monkeypatch.setattr("pyros1.node.publishing.udp_link.socket.socket", lambda *_: gone)
    if early:
        ends.link.send(b"one")
    ends.resolved(["127.0.0.1"], None)
    if not early:
        ends.link.send(b"one")
    assert ends.closed == [ends.link] and gone.closed
