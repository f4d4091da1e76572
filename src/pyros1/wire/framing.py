"""A receive buffer that splits a TCPROS stream into frames: a little-endian u32 length, then that many bytes.

A FrameBuffer owns the memory that a link receives into. The caller gets memory from `writable()`, receives into it,
reports with `received()` how much arrived, and gets the positions of the complete frames in `data`. Frames larger than
the buffer make it grow, but only as bytes actually arrive, so a length claimed by a peer costs no memory. The buffer
shrinks again when no large frames have arrived for a while. After a frame of more than 16 MiB it shrinks immediately,
so that the buffer and the copy of the frame are both in memory only during copying. A receive never goes beyond the
end of a large frame, so that the next frame can be received elsewhere.
"""

from __future__ import annotations

import struct

from pyros1.ground.errors import ProtocolError

MAX_MESSAGE_SIZE = 1_000_000_000
"""Maximum size of an accepted frame in bytes; the same limit as in roscpp."""

_unpack_size = struct.Struct("<I").unpack_from
_TRUSTED_GROWTH = 1 << 20
"""Size in bytes to which a claimed frame length makes the buffer grow before the bytes arrive."""
_LARGE_FRAME_SIZE = 16 << 20
_INITIAL_SIZE = 2048
_RECEIVES_BEFORE_SHRINKING = 200
"""The buffer shrinks after this many consecutive receives that needed no more than the capacity."""


class FrameBuffer:
    """The receive buffer of one link.

    Args:
        capacity: maximum number of bytes received at a time while frames are small. The buffer starts smaller, since an
            idle link needs little, and grows when it is filled.
        limit: maximum size of an accepted frame body in bytes.
        initial_bytes: bytes that arrived together with the connection header.

    Attributes:
        data: the memory; frame positions refer to it until the next `writable()`.
        view: the same memory, for slicing without copying.
    """

    __slots__ = (
        "_begin",
        "_capacity",
        "_end",
        "_is_filled",
        "_large_frame_size",
        "_limit",
        "_small_receives",
        "_trusted_size",
        "data",
        "view",
    )

    def __init__(self, capacity: int = 1 << 16, limit: int = MAX_MESSAGE_SIZE, initial_bytes: bytes = b"") -> None:
        self._capacity = capacity
        self._limit = limit
        self.data = bytearray(max(min(capacity, _INITIAL_SIZE), 2 * len(initial_bytes)))
        self.data[: len(initial_bytes)] = initial_bytes
        self.view = memoryview(self.data)
        self._begin = 0  # first byte of the first incomplete frame
        self._end = len(initial_bytes)
        self._is_filled = False
        self._small_receives = 0  # receives since a large buffer was last needed
        self._large_frame_size = 0  # size of an incomplete large frame, including its length field, or 0
        self._trusted_size = _TRUSTED_GROWTH  # size to which memory may grow before the bytes arrive

    @property
    def has_partial_frame(self) -> bool:
        """Whether the buffer contains part of a frame."""
        return self._begin != self._end

    def writable(self) -> memoryview:
        """Return the memory to receive into, which is never empty. Positions returned earlier become invalid."""
        begin, end = self._begin, self._end
        if len(self.data) > self._capacity:
            self._small_receives = self._small_receives + 1 if end <= self._capacity else 0
            if self._small_receives > _RECEIVES_BEFORE_SHRINKING and begin == end:
                self.shrink()
                begin = end = 0
        if begin:
            if begin != end:
                self.view[: end - begin] = self.view[begin:end]
            self._begin = 0
            self._end = end = end - begin
        if end == len(self.data) or (self._is_filled and len(self.data) < self._capacity):
            self._grow(max(len(self.data) * 2, min(len(self.data) * 8, self._capacity)))
            self._is_filled = False
        return self.view[end : self._large_frame_size] if end < self._large_frame_size else self.view[end:]

    def feed(self, data: bytes) -> None:
        """Append bytes that were received elsewhere; call `received` with their number afterwards."""
        if len(data) > len(self.writable()):
            self._grow(self._end + len(data))
        self.view[self._end : self._end + len(data)] = data

    def shrink(self) -> None:
        """Free the memory that only large frames need, if the buffer is empty."""
        if self._begin == self._end and len(self.data) > self._capacity:
            self._begin = self._end = self._small_receives = 0
            self._grow(self._capacity)

    def _grow(self, size: int) -> None:
        larger = bytearray(size)
        larger[: self._end] = self.view[: self._end]
        self.data = larger
        self.view = memoryview(larger)

    def received(self, count: int) -> list[tuple[int, int]]:
        """Record that ``count`` bytes arrived; return (start, end) of each complete frame's body in `data`, in order.

        Raises:
            ProtocolError: a frame claims to be larger than the limit.
        """
        data, position = self.data, self._begin
        end = self._end = self._end + count
        self._is_filled = end == len(data)
        frames: list[tuple[int, int]] = []
        while end - position >= 4:
            start = position + 4
            stop = start + _unpack_size(data, position)[0]
            if stop > end:
                self._begin = position
                self._make_room(stop - start)
                return frames
            frames.append((start, stop))
            position = stop
        self._begin = position
        self._large_frame_size = 0
        return frames

    def take(self, frames: list[tuple[int, int]]) -> bytes:
        """Return a copy of all bytes up to the end of the last given frame; there must be at least one frame."""
        data = bytes(self.view[: frames[-1][1]])
        self._shrink_after(frames)
        return data

    def take_bodies(self, frames: list[tuple[int, int]]) -> list[bytes]:
        """Return the bodies of the given frames as separate objects; there must be at least one frame. All positions
        become invalid.
        """
        bodies = [bytes(self.view[start:stop]) for start, stop in frames]
        self._shrink_after(frames)
        return bodies

    def _shrink_after(self, frames: list[tuple[int, int]]) -> None:
        if frames[-1][1] > _LARGE_FRAME_SIZE:
            self._trusted_size = frames[-1][1]
            self.shrink()

    def _make_room(self, size: int) -> None:
        """Make room for a frame of ``size`` bytes that has only partly arrived; in steps if it is large."""
        if size > self._limit:
            raise ProtocolError(f"message of {size} bytes exceeds the limit of {self._limit} bytes")
        self._large_frame_size = size + 4 if size > self._capacity else 0
        if size + 4 > len(self.data):
            doubled = 2 * len(self.data) if self._end == len(self.data) else 0
            new_size = min(size + 4 + self._capacity, max(self._trusted_size, doubled))
            if new_size > len(self.data):
                self._grow(new_size)
