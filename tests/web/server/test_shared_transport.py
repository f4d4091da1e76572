"""A transport to which threads write: in order, whole, and never after the end."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Awaitable, Callable
from typing import Any

import pytest

from pyros1.web.server.shared_transport import SharedTransport

LARGE = bytes(range(256)) * 20_000
"""More than the system accepts at once."""


class Ends:
    """The two ends of a connection: ours in an event loop, and the other one as a socket."""

    def __init__(self, transport: asyncio.Transport, other: socket.socket) -> None:
        self.is_open = True
        self.loops = transport
        self.ours = SharedTransport(transport, asyncio.get_running_loop(), lambda: self.is_open)
        self.other = other

    async def receive(self, size: int) -> bytes:
        """Receive so many bytes at the other end, while the loop runs."""
        received = b""
        while len(received) < size:
            received += await asyncio.get_running_loop().sock_recv(self.other, size - len(received))
        return received

    def receive_now(self) -> bytes:
        """Receive what is there, before the loop does anything."""
        try:
            return self.other.recv(1 << 20)
        except BlockingIOError:
            return b""

    async def receive_rest(self) -> bytes:
        """Receive everything up to the end."""
        received = b""
        while data := await asyncio.get_running_loop().sock_recv(self.other, 1 << 20):
            received += data
        return received


def run(test: Callable[[Ends], Awaitable[None]]) -> None:
    async def with_ends() -> None:
        near, far = socket.socketpair()
        far.setblocking(False)
        with near, far:
            transport, _ = await asyncio.get_running_loop().connect_accepted_socket(asyncio.Protocol, near)
            ends = Ends(transport, far)
            try:
                await test(ends)
            finally:
                ends.ours.lose()
                if not transport.is_closing():
                    transport.abort()

    asyncio.run(with_ends())


def test_bytes_are_sent_at_once() -> None:
    async def test(ends: Ends) -> None:
        assert not ends.ours.send([b"a"])  # not shared yet
        ends.ours.share()
        assert ends.ours.send([b"a"]) and ends.ours.send([b"b", memoryview(b"c"), b"d"])
        assert ends.receive_now() == b"abcd"
        assert ends.ours.send([b"%d," % number for number in range(1_000)])  # more pieces than the system takes
        assert await ends.receive(3_890) == b"".join(b"%d," % number for number in range(1_000))

    run(test)


def test_what_the_system_does_not_accept_comes_before_everything_else() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        assert ends.ours.send([b"<", LARGE, b">"])
        assert 0 < ends.ours.get_write_buffer_size() < len(LARGE)
        assert ends.ours.send([b"not sent"]) is False
        ends.ours.write(b"the loop's")
        assert not ends.ours.send([b"not sent"])
        expected = b"<" + LARGE + b">the loop's"
        assert await ends.receive(len(expected)) == expected
        while ends.ours.get_write_buffer_size():
            await asyncio.sleep(0)
        assert ends.ours.send([b"again"])
        assert await ends.receive(5) == b"again"

    run(test)


def test_the_loop_sends_the_rest_by_itself() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        assert ends.ours.send([LARGE])
        assert await ends.receive(len(LARGE)) == LARGE

    run(test)


def test_nothing_is_sent_while_the_loop_has_unsent_bytes() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        ends.ours.writelines([b"<", LARGE, b"", b">"])
        start = ends.receive_now()  # the system would accept more
        assert not ends.ours.send([b"not sent"])
        assert 0 < ends.ours.get_write_buffer_size() < len(LARGE)
        assert not ends.ours.send([b"not sent"])
        assert start + await ends.receive(len(LARGE) + 2 - len(start)) == b"<" + LARGE + b">"

    run(test)


def test_what_was_written_before_it_is_shared_comes_first() -> None:
    """Such as the response that opens a WebSocket."""

    async def test(ends: Ends) -> None:
        ends.ours.write(LARGE)
        ends.ours.share()
        start = ends.receive_now()  # the system would accept more
        assert not ends.ours.send([b"not sent"])
        assert start + await ends.receive(len(LARGE) - len(start)) == LARGE
        while ends.ours.get_write_buffer_size():
            await asyncio.sleep(0)
        assert ends.ours.send([b"next"])
        assert await ends.receive(4) == b"next"

    run(test)


def test_sharing_again_changes_nothing() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        duplicate = ends.ours.socket
        assert ends.ours.send([LARGE])
        ends.ours.share()
        assert ends.ours.socket is duplicate
        assert not ends.ours.send([b"not sent"])
        assert await ends.receive(len(LARGE)) == LARGE

    run(test)


def test_a_connection_that_is_being_closed_is_not_shared() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.close()
        ends.ours.share()
        assert not ends.ours.send([b"not sent"])
        assert await ends.receive_rest() == b""

    run(test)


def test_a_full_system_accepts_nothing() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        duplicate = ends.loops.get_extra_info("socket").dup()
        with duplicate, pytest.raises(BlockingIOError):
            while True:
                duplicate.send(LARGE)
        assert ends.ours.send([b"not sent"]) is False
        assert not ends.ours.get_write_buffer_size()

    run(test)


def test_nothing_is_sent_after_the_end() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        ends.is_open = False
        assert not ends.ours.send([b"not sent"])
        ends.is_open = True
        assert ends.ours.send([LARGE])
        ends.ours.write(b"end")
        (ends.ours.write_eof if ends.ours.can_write_eof() else ends.ours.close)()
        assert not ends.ours.send([b"not sent"])
        assert await ends.receive_rest() == LARGE + b"end"
        ends.ours.get_write_buffer_size()
        assert not ends.ours.send([b"not sent"])

    run(test)


def test_closing_sends_the_rest() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        assert ends.ours.send([LARGE])
        ends.ours.close()
        assert ends.ours.is_closing()
        assert not ends.ours.send([b"not sent"])
        ends.ours.share()
        assert not ends.ours.send([b"not sent"])
        received = await ends.receive(len(LARGE))
        assert received == LARGE

    run(test)


def test_aborting_does_not() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        assert ends.ours.send([LARGE])
        ends.ours.abort()
        assert ends.ours.is_closing()
        assert not ends.ours.get_write_buffer_size()
        assert not ends.ours.send([b"not sent"])

    run(test)


def test_a_peer_may_be_kept_waiting_in_both_directions() -> None:
    async def test(ends: Ends) -> None:
        assert ends.ours.is_reading() is True
        ends.ours.pause_reading()
        assert ends.ours.is_reading() is False and not ends.loops.is_reading()
        ends.ours.resume_reading()
        assert ends.loops.is_reading()
        ends.ours.set_write_buffer_limits(10, 5)
        assert ends.loops.get_write_buffer_limits() == (5, 10)

    run(test)


def test_a_lost_connection() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        assert ends.ours.send([LARGE])
        ends.ours.lose()
        ends.ours.lose()
        assert not ends.ours.send([b"not sent"])
        assert not ends.ours.get_write_buffer_size()

    run(test)


def test_a_broken_connection_is_the_loops_matter() -> None:
    async def test(ends: Ends) -> None:
        ends.ours.share()
        ends.other.close()
        assert not ends.ours.send([b"not sent"])

    run(test)


def test_one_at_a_time_uses_the_socket(monkeypatch: pytest.MonkeyPatch) -> None:
    """Frames may not be mixed, or sent to a number that is another connection's meanwhile."""

    async def test(ends: Ends) -> None:
        uses: list[tuple[str, bool]] = []

        def guarded(name: str, use: Callable[..., Any]) -> Callable[..., Any]:
            def noted(*args: Any) -> Any:
                uses.append((name, ends.ours.lock.locked()))
                return use(*args)

            return noted

        class Socket:
            def dup(self) -> Socket:
                real = near.dup()
                for name in ("send", "sendmsg", "close"):
                    setattr(self, name, guarded(name, getattr(real, name)))
                return self

        near = ends.loops.get_extra_info("socket")
        monkeypatch.setattr(ends.loops, "get_extra_info", {"socket": Socket()}.get)
        monkeypatch.setattr(ends.loops, "write", guarded("the loop's", ends.loops.write))
        ends.ours.share()
        assert ends.ours.send([b"a"]) and ends.ours.send([b"b", b"c"])
        ends.ours.write(b"d")
        ends.ours.write(b"")  # does nothing
        assert ends.ours.send([LARGE])
        ends.ours.write(b"e")
        ends.ours.lose()
        expected = ["send", "sendmsg", "send", "send", "the loop's", "the loop's", "close"]
        assert uses == [(name, True) for name in expected]

    run(test)


@pytest.mark.parametrize("unsuitable", ["encrypted", "no socket", "no descriptors", "no sendmsg"])
def test_connections_that_only_the_loop_uses(unsuitable: str, monkeypatch: pytest.MonkeyPatch) -> None:
    class WithoutSendmsg:
        def close(self) -> None:
            closed.append(None)

    def dup() -> Any:
        if unsuitable == "no descriptors":
            raise OSError
        return WithoutSendmsg()

    closed: list[None] = []
    own = type("Socket", (), {"dup": staticmethod(dup)})()
    properties = {
        "encrypted": {"ssl_object": object()},
        "no socket": {"socket": None},
        "no descriptors": {"socket": own},
        "no sendmsg": {"socket": own},
    }[unsuitable]

    async def test(ends: Ends) -> None:
        get = ends.loops.get_extra_info
        monkeypatch.setattr(ends.loops, "get_extra_info", lambda name, default=None: properties.get(name, get(name)))
        ends.ours.share()
        assert not ends.ours.send([b"not sent"])
        ends.ours.write(b"the loop's")
        assert await ends.receive(10) == b"the loop's"
        assert not ends.ours.send([b"not sent"])

    run(test)
    assert bool(closed) is (unsuitable == "no sendmsg")
