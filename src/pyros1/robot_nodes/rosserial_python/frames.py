"""The frames that a board and its host exchange (https://wiki.ros.org/rosserial/Overview/Protocol).

A frame is: 0xff, 0xfe (the version of the protocol), length of the data (u16), its checksum, topic id (u16), data,
checksum of topic id and data. Numbers are little-endian.
"""

from __future__ import annotations

import struct
from itertools import accumulate
from typing import NamedTuple

SYNC = b"\xff\xfe"
MAX_DATA = 0xFFFF
_HEAD_SIZE = 7
_OVERHEAD = _HEAD_SIZE + 1


class Frame(NamedTuple):
    """A frame with the right checksums.

    Attributes:
        topic_id: the kind of data: an id from rosserial_msgs/TopicInfo, or one of 100 or more that the board chose.
        data: a serialized message.
    """

    topic_id: int
    data: bytes


def encode_frame(topic_id: int, data: bytes) -> bytes:
    """Return a frame's bytes.

    Args:
        topic_id: 0 to 65535.
        data: the serialized message, at most `MAX_DATA` bytes.
    """
    length = struct.pack("<H", len(data))
    body = struct.pack("<H", topic_id) + data
    return b"".join((SYNC, length, _checksum(length), body, _checksum(body)))


def _checksum(data: bytes) -> bytes:
    return bytes([255 - sum(data) % 256])


class FrameReader:
    """Finds frames in a stream of bytes, some of which may be lost or wrong.

    After wrong bytes, the search continues right after the last sync bytes, so that a frame that was cut off or has a
    wrong length does not hide the following frames.

    Attributes:
        skipped: number of bytes so far that belonged to no frame.
    """

    def __init__(self) -> None:
        self.skipped = 0
        self._buffer = bytearray()
        # For each position in the buffer, including its end, the sum of all bytes before it, modulo 256. Without it,
        # data in which many frames of 64 KiB seem to begin would take minutes to check.
        self._sums = bytearray(1)

    @property
    def has_partial_frame(self) -> bool:
        """Whether there is an incomplete frame."""
        return bool(self._buffer)

    def feed(self, data: bytes) -> list[Frame]:
        """Add received bytes, and return the frames that are now complete."""
        self._buffer += data
        self._sums += bytes(total & 255 for total in accumulate(data, initial=self._sums.pop()))
        return self._take_frames()

    def give_up(self) -> list[Frame]:
        """Stop waiting for the rest of a frame; return the complete frames found after its beginning."""
        if self._buffer:
            self._skip(1)
        return self._take_frames()

    def clear(self) -> None:
        """Discard the buffer: the next byte is the first of a new connection."""
        self._remove(len(self._buffer))

    def _take_frames(self) -> list[Frame]:
        frames = []
        while (frame := self._next_frame()) is not None:
            frames.append(frame)
        return frames

    def _next_frame(self) -> Frame | None:
        buffer = self._buffer
        while True:
            self._skip_to_sync()
            if len(buffer) < _HEAD_SIZE:
                return None
            length = buffer[2] | buffer[3] << 8
            if not self._has_checksum(2, 5):
                self._skip(1)
                continue
            end = length + _OVERHEAD
            if len(buffer) < end:
                return None
            if self._has_checksum(5, end):
                frame = Frame(buffer[5] | buffer[6] << 8, bytes(buffer[_HEAD_SIZE : end - 1]))
                self._remove(end)
                return frame
            self._skip(1)

    def _skip_to_sync(self) -> None:
        start = self._buffer.find(SYNC)
        if start < 0:  # the last byte may be the first one of the next frame
            start = len(self._buffer) - self._buffer.endswith(SYNC[:1])
        self._skip(start)

    def _skip(self, count: int) -> None:
        self.skipped += count
        self._remove(count)

    def _remove(self, count: int) -> None:
        del self._buffer[:count]
        del self._sums[:count]

    def _has_checksum(self, start: int, end: int) -> bool:
        """Return whether the last byte in a range is the checksum of the others."""
        return (self._sums[end] - self._sums[start]) % 256 == 255
