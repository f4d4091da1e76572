"""ClientConnection without a node: clients that leave or do not read."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.ground.errors import ProtocolError
from pyros1.node.services.client_connection import ClientConnection


class Timer:
    def cancel(self) -> None: ...


class ManualLoop:
    """Keeps what is waited for; the test says when it happens."""

    def __init__(self) -> None:
        self.readable: dict[Any, Callable[[int], None]] = {}
        self.timers = 0

    def register(self, sock: Any, mask: int, callback: Callable[[int], None]) -> None:
        self.readable[sock] = callback

    def unregister(self, sock: Any) -> None:
        del self.readable[sock]

    def call_soon(self, function: Callable[..., object], *args: Any) -> None:
        function(*args)

    def call_later(self, delay: float, function: Callable[..., object], *args: Any) -> Timer:
        self.timers += 1
        return Timer()


class Ends:
    """A link of a provider, and its client."""

    def __init__(self, persistent: str = "1") -> None:
        self.client, self.sock = socket.socketpair()
        self.sock.setblocking(False)
        self.loop = ManualLoop()
        self.closed: list[Exception | None] = []
        self.link = ClientConnection(
            self.loop,  # type: ignore[arg-type]
            self.sock,
            {"persistent": persistent},
            b"",
            lambda data, start, end, header: b"",
            lambda job: "no worker is free",
            lambda count: False,
            lambda link, error: self.closed.append(error),
        )


@pytest.fixture(params=["1"])
def ends(request: pytest.FixtureRequest) -> Iterator[Ends]:
    ends = Ends(request.param)
    yield ends
    ends.client.close()
    ends.sock.close()


def test_a_client_that_does_not_read_the_providers_header(ends: Ends) -> None:
    with contextlib.suppress(BlockingIOError):
        while True:
            ends.sock.send(bytes(1 << 16))
    ends.client.recv(1 << 16)
    ends.link.begin(bytes(1 << 22))
    (error,) = ends.closed
    assert isinstance(error, (ProtocolError, BlockingIOError)) and ends.sock.fileno() == -1


def test_a_client_that_is_gone_before_the_providers_header(ends: Ends) -> None:
    ends.client.close()
    ends.link.begin(b"header")
    (error,) = ends.closed
    assert isinstance(error, BrokenPipeError) and ends.sock.fileno() == -1


def test_a_link_that_is_ended_before_it_begins_waits_for_nothing(ends: Ends) -> None:
    ends.link.end()
    ends.link.begin(b"header")
    assert ends.client.recv(100) == b"header"
    assert ends.closed == [None] and not ends.loop.readable


def test_a_client_that_leaves_while_its_request_is_waited_for(ends: Ends) -> None:
    ends.link.begin(b"header")
    on_readable = ends.loop.readable[ends.sock]
    on_readable(1)  # nothing has come after all
    assert not ends.closed and ends.sock in ends.loop.readable
    ends.client.close()  # with bytes that it has not read: not an orderly end
    on_readable(1)
    (error,) = ends.closed
    assert isinstance(error, ConnectionResetError) and not ends.loop.readable and ends.sock.fileno() == -1


@pytest.mark.parametrize("ends", ["0", "1"], indirect=True)
def test_one_time_limit_for_a_request_that_comes_in_parts(ends: Ends) -> None:
    ends.link.begin(b"header")
    for part in (b"\x02\0", b"\0\0", b"a"):
        ends.client.send(part)
        ends.loop.readable[ends.sock](1)
    assert ends.loop.timers == 1 and not ends.closed
