"""Frames that wait for a slow link: bounded, oldest dropped whole, never a torn frame.

States of a frame: *waiting* (may still be dropped), *begun* (partly sent: must be finished) and
gone. At most one frame is begun. The limit counts waiting frames only.

A signal handler that raises may end any of these methods at any point. So the bytes sent are noted in `sent_bytes`
before they are removed, and each step of the removal is a sequence of instructions without calls, in which no handler
can run: `discard_sent` can be called again and continues where it was.
"""

from __future__ import annotations

from collections import deque
from itertools import islice

Buffer = bytes | bytearray | memoryview
Frame = bytes | list[Buffer]


def frame_size(frame: Frame) -> int:
    """Return the number of bytes of a frame."""
    return len(frame) if isinstance(frame, bytes) else sum(memoryview(part).nbytes for part in frame)


def _remainder(frame: Frame, sent: int) -> list[Buffer]:
    """Return what remains of a frame after ``sent`` bytes, as views."""
    remainder: list[Buffer] = []
    for part in [frame] if isinstance(frame, bytes) else frame:
        view = memoryview(part) if isinstance(part, bytes) else memoryview(part).cast("B")
        if sent < len(view):
            remainder.append(view[sent:])
        sent = max(0, sent - len(view))
    return remainder


def _snapshot(frame: list[Buffer]) -> list[Buffer]:
    """Return a frame that is safe to keep: memory that its owner may change is copied."""
    return [
        part if isinstance(part, bytes) or isinstance(memoryview(part).obj, bytes) else bytes(part) for part in frame
    ]


def frame_copy(frame: Frame) -> Frame:
    """Return a frame that may wait: memory that its owner may change is copied."""
    return frame if frame.__class__ is bytes else _snapshot(_remainder(frame, 0))


class OutQueue:
    """Queue of the frames of one link that the socket did not take at once.

    Args:
        limit: maximum number of frames that may wait, None or 0 for no limit.

    Attributes:
        dropped: number of frames dropped so far.
        sent_bytes: bytes of what `buffers()` returned that were sent, for `discard_sent`.
    """

    __slots__ = ("_limit", "_partial", "_waiting", "dropped", "sent_bytes")

    def __init__(self, limit: int | None) -> None:
        self._limit = limit or 0
        self._waiting: deque[Frame] = deque()
        self._partial: list[Buffer] = []
        self.dropped = 0
        self.sent_bytes = 0

    def __len__(self) -> int:
        """Return the number of frames not fully sent."""
        return len(self._waiting) + bool(self._partial)

    def push(self, frame: Frame) -> None:
        """Add a frame; drop the oldest waiting one if there are too many."""
        waiting = self._waiting
        waiting.append(frame if isinstance(frame, bytes) else _snapshot(_remainder(frame, 0)))
        if self._limit and len(waiting) > self._limit:
            waiting.popleft()
            self.dropped += 1

    def push_partial(self, frame: Frame, sent: int) -> None:
        """Add a frame of which ``sent`` bytes are on the wire already. Only for an empty queue."""
        self._partial = _snapshot(_remainder(frame, sent))

    def buffers(self, max_buffers: int = 256) -> list[Buffer]:
        """Return up to about ``max_buffers`` buffers to send next, in order, for one scatter-gather call."""
        parts: list[Buffer] = list(self._partial)
        for frame in islice(self._waiting, max(0, max_buffers - len(parts))):
            if isinstance(frame, bytes):
                parts.append(frame)
            else:
                parts.extend(frame)
                if len(parts) >= max_buffers:
                    break
        return parts

    def discard_sent(self) -> None:
        """Remove the first `sent_bytes` bytes of what `buffers()` returned: they were sent."""
        if self._partial:
            size = sum(len(part) for part in self._partial)
            if self.sent_bytes < size:
                remainder = _remainder(self._partial, self.sent_bytes)
                self._partial = remainder
                self.sent_bytes = 0
                return
            left = self.sent_bytes - size
            self._partial = []
            self.sent_bytes = left
        waiting = self._waiting
        while self.sent_bytes:
            frame = waiting[0]
            size = len(frame) if frame.__class__ is bytes else frame_size(frame)
            if self.sent_bytes < size:
                remainder = _remainder(frame, self.sent_bytes)
                del waiting[0]
                self._partial = remainder
                self.sent_bytes = 0
                return
            left = self.sent_bytes - size
            del waiting[0]
            self.sent_bytes = left

    def clear(self) -> None:
        """Remove all frames, for a link that has ended."""
        self._waiting.clear()
        self._partial = []
        self.sent_bytes = 0
