"""Receive buffer that splits a TCPROS stream into frames: u32 little-endian length, then that many bytes.

A FrameBuffer owns the memory that a link receives into. The driver asks for `writable()`, receives into it, says how
much arrived and gets the positions of the complete frames inside `data`.
Frames larger than the buffer make it grow, but only as bytes really arrive: a peer's claim costs no memory. It shrinks
again when no large frames have come for a while, and at once after one of more than 16 MiB: such a frame takes twice
its size while it is copied out, and then no more than its size. Nothing is received together with the end of a large
frame, so that the next one can be received elsewhere.
"""

from __future__ import annotations

import struct

from pyros1.ground.errors import ProtocolError

MAX_MESSAGE_SIZE = 1_000_000_000
"""Largest frame accepted, in bytes: the same limit as roscpp."""

_unpack_size = struct.Struct("<I").unpack_from
_TRUSTED_GROWTH = 1 << 20
_LARGE = 16 << 20
_SMALL = 2048
_SPARE_ROUNDS = 200
"""Receives in a row without need of more than the capacity, after which the buffer shrinks."""


class FrameBuffer:
    """Receive buffer of one link.

    Args:
        capacity: maximum number of bytes received in one go while frames are small. An idle link needs less: the
            buffer begins small and grows when it is filled.
        limit: largest accepted frame body in bytes.
        first: bytes that arrived together with the connection header.

    Attributes:
        data: the memory; frame positions refer to it until the next `writable()`.
        view: the same memory, for slicing without a copy.
    """

    __slots__ = ("_begin", "_capacity", "_end", "_filled", "_limit", "_spare", "_stop", "_trusted", "data", "view")

    def __init__(self, capacity: int = 1 << 16, limit: int = MAX_MESSAGE_SIZE, first: bytes = b"") -> None:
        self._capacity = capacity
        self._limit = limit
        self.data = bytearray(max(min(capacity, _SMALL), 2 * len(first)))
        self.data[: len(first)] = first
        self.view = memoryview(self.data)
        self._begin = 0  # first byte of the first incomplete frame
        self._end = len(first)
        self._filled = False
        self._spare = 0  # receives since a large buffer was last needed
        self._stop = 0  # size of the large frame that is incomplete, with its length field; else 0
        self._trusted = _TRUSTED_GROWTH  # memory reserved before the bytes arrive: no more than have arrived already

    @property
    def partial(self) -> bool:
        """Whether a part of a frame is in the buffer."""
        return self._begin != self._end

    def writable(self) -> memoryview:
        """Return the memory to receive into, never empty. Positions returned earlier become invalid."""
        begin, end = self._begin, self._end
        if len(self.data) > self._capacity:
            self._spare = self._spare + 1 if end <= self._capacity else 0
            if self._spare > _SPARE_ROUNDS and begin == end:
                self.shrink()
                begin = end = 0
        if begin:
            if begin != end:
                self.view[: end - begin] = self.view[begin:end]
            self._begin = 0
            self._end = end = end - begin
        if end == len(self.data) or (self._filled and len(self.data) < self._capacity):
            self._grow(max(len(self.data) * 2, min(len(self.data) * 8, self._capacity)))
            self._filled = False
        return self.view[end : self._stop] if end < self._stop else self.view[end:]

    def feed(self, data: bytes) -> None:
        """Append bytes that were received elsewhere; `received` then counts them."""
        if len(data) > len(self.writable()):
            self._grow(self._end + len(data))
        self.view[self._end : self._end + len(data)] = data

    def shrink(self) -> None:
        """Free memory that only large frames need, if the buffer is empty."""
        if self._begin == self._end and len(self.data) > self._capacity:
            self._begin = self._end = self._spare = 0
            self._grow(self._capacity)

    def _grow(self, size: int) -> None:
        larger = bytearray(size)
        larger[: self._end] = self.view[: self._end]
        self.data = larger
        self.view = memoryview(larger)

    def received(self, count: int) -> list[tuple[int, int]]:
        """Note that ``count`` bytes arrived; return (start, end) of each complete frame's body in `data`, in order.

        Raises:
            ProtocolError: a frame claims to be larger than the limit.
        """
        data, position = self.data, self._begin
        end = self._end = self._end + count
        self._filled = end == len(data)
        frames: list[tuple[int, int]] = []
        while end - position >= 4:
            start = position + 4
            stop = start + _unpack_size(data, position)[0]
            if stop > end:
                self._begin = position
                self._expect(stop - start)
                return frames
            frames.append((start, stop))
            position = stop
        self._begin = position
        self._stop = 0
        return frames

    def take(self, frames: list[tuple[int, int]]) -> bytes:
        """Return a copy of the bytes to which the positions of complete frames refer; positions must not be empty."""
        data = bytes(self.view[: frames[-1][1]])
        self._taken(frames)
        return data

    def take_bodies(self, frames: list[tuple[int, int]]) -> list[bytes]:
        """Return the bodies of complete frames, as separate objects; no position stays valid. There must be at least
        one."""
        bodies = [bytes(self.view[start:stop]) for start, stop in frames]
        self._taken(frames)
        return bodies

    def _taken(self, frames: list[tuple[int, int]]) -> None:
        if frames[-1][1] > _LARGE:
            self._trusted = frames[-1][1]
            self.shrink()

    def _expect(self, size: int) -> None:
        """Make room for a frame of ``size`` bytes of which a part has arrived, in steps if it is large."""
        if size > self._limit:
            raise ProtocolError(f"message of {size} bytes exceeds the limit of {self._limit} bytes")
        self._stop = size + 4 if size > self._capacity else 0
        if size + 4 > len(self.data):
            doubled = 2 * len(self.data) if self._end == len(self.data) else 0
            wanted = min(size + 4 + self._capacity, max(self._trusted, doubled))
            if wanted > len(self.data):
                self._grow(wanted)
