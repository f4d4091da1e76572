"""Frames written past the library."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed, ConnectionClosedError
from websockets.frames import Frame, Opcode
from websockets.protocol import State

from pyros1.web.server.sending import LargeFrame, keeps_up, send_frames, send_now, shared_transport
from pyros1.web.server.shared_transport import SharedTransport

LARGE = b"b" * 100_000


class Link:
    """A connection, and its transport, that notes what is done with it."""

    def __init__(self) -> None:
        self.state = State.OPEN
        self.done: list[bytes] = []
        self.is_reset = False
        self.num_unsent_bytes = 0

    @property
    def transport(self) -> Link:
        return self

    def write(self, data: bytes) -> None:
        self.done.append(data)

    def get_write_buffer_size(self) -> int:
        return self.num_unsent_bytes

    async def drain(self) -> None:
        if self.is_reset:
            raise ConnectionResetError
        self.done.append(b"drained")

    async def send(self, frame: str | bytes) -> None:
        raise ConnectionClosedError(None, None)


def send(link: Link, *frames: str | bytes) -> list[bytes]:
    asyncio.run(send_frames(link, frames))
    return link.done


@pytest.mark.parametrize("size", [0, 1, 125, 126, 65_535, 65_536, 65_537, 100_000])
@pytest.mark.parametrize("opcode", [Opcode.TEXT, Opcode.BINARY])
def test_frames_are_those_of_the_library(size: int, opcode: Opcode) -> None:
    data = b"x" * size
    frame: Any = data.decode() if opcode is Opcode.TEXT else data
    *written, drained = send(Link(), frame)
    assert b"".join(written) == Frame(opcode, data).serialize(mask=False)
    assert drained == b"drained"


def test_small_ones_are_written_together_in_order() -> None:
    *written, drained = send(Link(), "a", b"b", LARGE, "c")
    assert len(written) == 3
    assert b"".join(written) == b"\x81\x01a\x82\x01b" + Frame(Opcode.BINARY, LARGE).serialize(mask=False) + b"\x81\x01c"
    assert drained == b"drained"
    assert send(Link()) == []


@pytest.mark.parametrize(("size", "num_writes"), [(65_536, 1), (65_537, 2)])
def test_which_frames_are_copied(size: int, num_writes: int) -> None:
    *written, _ = send(Link(), b"x" * size)
    assert len(written) == num_writes


@pytest.mark.parametrize("size", [5, 100_000])
@pytest.mark.parametrize("is_text", [False, True])
def test_frames_in_pieces(size: int, is_text: bool) -> None:
    pieces = (b"head", memoryview(bytes(size)), b"x" * size, b"end")
    whole = b"".join(pieces)
    *written, _ = send(Link(), LargeFrame(pieces, len(whole), is_text), "next")
    opcode = Opcode.TEXT if is_text else Opcode.BINARY
    assert b"".join(written) == Frame(opcode, whole).serialize(mask=False) + b"\x81\x04next"
    assert any(piece is pieces[1] for piece in written), "it was copied"


@pytest.mark.parametrize(
    ("state", "num_unsent_bytes", "expected"),
    [(State.OPEN, 0, True), (State.OPEN, 1, False), (State.CLOSING, 0, False), (State.CLOSED, 1, False)],
)
def test_whether_a_client_keeps_up(state: State, num_unsent_bytes: int, expected: bool) -> None:
    link = Link()
    link.state, link.num_unsent_bytes = state, num_unsent_bytes
    assert keeps_up(link) is expected


def test_a_connection_whose_transport_is_shared(monkeypatch: pytest.MonkeyPatch) -> None:
    loop: Any = None  # not used
    shared: list[SharedTransport] = []

    def note(transport: SharedTransport) -> None:
        shared.append(transport)

    monkeypatch.setattr(SharedTransport, "share", note)
    transport = SharedTransport(asyncio.Transport(), loop, lambda: True)
    connection = type("Connection", (), {"transport": transport})()
    assert shared_transport(connection) is transport
    assert shared == [transport]


def test_connections_that_only_the_loop_uses() -> None:
    assert shared_transport(Link()) is None
    assert shared_transport(object()) is None


class Shared:
    """A transport that accepts nothing."""

    def __init__(self) -> None:
        self.offered: list[Any] = []

    def send(self, pieces: Any) -> bool:
        self.offered.append(pieces)
        return False


def test_frames_from_any_thread() -> None:
    transport: Any = Shared()
    assert send_now(transport, []) and not transport.offered
    assert not send_now(transport, ["a", b"b"])
    assert transport.offered == [[b"\x81\x01a\x82\x01b"]]


@pytest.mark.parametrize("state", [State.CLOSING, State.CLOSED])
def test_nothing_is_written_after_the_end(state: State) -> None:
    link = Link()
    link.state = state
    with pytest.raises(ConnectionClosed):
        send(link, "a")
    assert link.done == []


def test_a_reset_connection_is_closed() -> None:
    link = Link()
    link.is_reset = True
    with pytest.raises(ConnectionClosed):
        send(link, "a")
