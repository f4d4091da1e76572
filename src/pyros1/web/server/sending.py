"""Sends frames over a WebSocket, as RFC 6455, 5.2 describes them."""

from __future__ import annotations

import struct
from collections.abc import Iterable, Sequence
from typing import Protocol

from websockets.protocol import State

_TEXT, _BINARY = 0x81, 0x82
"""First byte of an unfragmented frame."""
_MAX_SMALL_BYTES = 64 << 10
"""Maximum size in bytes of frames that are copied to be written together."""


class _Transport(Protocol):
    def write(self, data: bytes, /) -> None: ...

    def get_write_buffer_size(self) -> int: ...


class Connection(Protocol):
    """What is needed of `websockets.asyncio.server.ServerConnection`."""

    @property
    def state(self) -> State: ...

    @property
    def transport(self) -> _Transport: ...

    async def send(self, message: str | bytes, /) -> None: ...

    async def drain(self) -> None: ...


async def send_frames(connection: Connection, frames: Sequence[str | bytes]) -> None:
    """Send frames in order, each as a WebSocket message, and wait while the client is slow.

    Small frames are written together, and large ones are not copied, unlike by ``connection.send``, which takes ten
    times as long for small frames.

    Args:
        connection: the connection to the client.
        frames: text or binary data, which should not be large in total, since all of it may be buffered.

    Raises:
        ConnectionClosed: the connection is closed.
    """
    if not frames:
        return
    if connection.state is not State.OPEN:
        await connection.send(frames[0])  # raises the error
    write_frames(connection, frames)
    try:
        await connection.drain()
    except OSError:  # the connection was reset meanwhile
        await connection.send(frames[-1])  # raises ConnectionClosed


def keeps_up(connection: Connection) -> bool:
    """Return whether `write_frames` may be called: the connection is open, and the client has received everything."""
    return connection.state is State.OPEN and not connection.transport.get_write_buffer_size()


def write_frames(connection: Connection, frames: Iterable[str | bytes]) -> None:
    """Send frames in order, each as a WebSocket message, without waiting."""
    transport = connection.transport
    small: list[bytes] = []
    for frame in frames:
        payload, first_byte = (frame.encode(), _TEXT) if isinstance(frame, str) else (frame, _BINARY)
        small.append(_header(first_byte, len(payload)))
        if len(payload) <= _MAX_SMALL_BYTES:
            small.append(payload)
        else:
            transport.write(b"".join(small))
            transport.write(payload)
            small = []
    if small:
        transport.write(b"".join(small))


def _header(first_byte: int, length: int) -> bytes:
    if length < 126:
        return bytes((first_byte, length))
    if length < 1 << 16:
        return struct.pack(">BBH", first_byte, 126, length)
    return struct.pack(">BBQ", first_byte, 127, length)
