"""Frames written past the library."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from websockets.exceptions import ConnectionClosed, ConnectionClosedError
from websockets.frames import Frame, Opcode
from websockets.protocol import State

from pyros1.web.server.sending import send_frames

LARGE = b"b" * 100_000


class Link:
    """A connection, and its transport, that notes what is done with it."""

    def __init__(self) -> None:
        self.state = State.OPEN
        self.done: list[bytes] = []
        self.is_reset = False

    @property
    def transport(self) -> Link:
        return self

    def write(self, data: bytes) -> None:
        self.done.append(data)

    def get_write_buffer_size(self) -> int:
        return 0

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
