"""A bounded queue of frames for a slow link: the oldest frames are dropped, but never part of a frame.

A frame is *waiting* (it can still be dropped) or *partial* (partly sent, so it must be finished). At most one frame is
partial. The limit only applies to waiting frames.

A signal handler that raises can interrupt any of these methods at any point. So the number of bytes sent is stored in
`sent_bytes` before these bytes are removed. Each step of the removal is a sequence of instructions without calls,
during which no handler can run, so `discard_sent` can be called again and continues where it was interrupted.
"""

from __future__ import annotations

from collections import deque
from itertools import islice

Buffer = bytes | bytearray | memoryview
Frame = bytes | list[Buffer]


def frame_size(frame: Frame) -> int:
    """Return the size of a frame in bytes."""
    return len(frame) if isinstance(frame, bytes) else sum(memoryview(part).nbytes for part in frame)


def _remainder(frame: Frame, sent: int) -> list[Buffer]:
    """Return a frame without its first ``sent`` bytes, as views."""
    remainder: list[Buffer] = []
    for part in [frame] if isinstance(frame, bytes) else frame:
        view = memoryview(part) if isinstance(part, bytes) else memoryview(part).cast("B")
        if sent < len(view):
            remainder.append(view[sent:])
        sent = max(0, sent - len(view))
    return remainder


def _copy_mutable(frame: list[Buffer]) -> list[Buffer]:
    """Return a frame's buffers in a form that can be stored: memory that its owner might change is copied."""
    return [
        part if isinstance(part, bytes) or isinstance(memoryview(part).obj, bytes) else bytes(part) for part in frame
    ]


def copy_frame(frame: Frame) -> Frame:
    """Return a frame that can wait in a queue: memory that its owner might change is copied."""
    return frame if frame.__class__ is bytes else _copy_mutable(_remainder(frame, 0))


class OutQueue:
    """The frames of one link that the socket did not accept immediately.

    Args:
        limit: maximum number of waiting frames; None or 0 for no limit.

    Attributes:
        dropped: number of frames dropped so far.
        sent_bytes: how many of the bytes returned by `buffers()` have been sent; `discard_sent` removes them.
    """

    __slots__ = ("_limit", "_partial", "_waiting", "dropped", "sent_bytes")

    def __init__(self, limit: int | None) -> None:
        self._limit = limit or 0
        self._waiting: deque[Frame] = deque()
        self._partial: list[Buffer] = []
        self.dropped = 0
        self.sent_bytes = 0

    def __len__(self) -> int:
        """Return the number of frames that are not completely sent."""
        return len(self._waiting) + bool(self._partial)

    def push(self, frame: Frame) -> None:
        """Add a frame; drop the oldest waiting frame if there are too many."""
        waiting = self._waiting
        waiting.append(frame if isinstance(frame, bytes) else _copy_mutable(_remainder(frame, 0)))
        if self._limit and len(waiting) > self._limit:
            waiting.popleft()
            self.dropped += 1

    def push_partial(self, frame: Frame, sent: int) -> None:
        """Add a frame whose first ``sent`` bytes have already been sent. The queue must be empty."""
        self._partial = _copy_mutable(_remainder(frame, sent))

    def buffers(self, max_buffers: int = 256) -> list[Buffer]:
        """Return about ``max_buffers`` buffers to send next, in order, for one scatter-gather call."""
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
        """Remove the bytes that were sent: the first `sent_bytes` bytes of what `buffers()` returned."""
        if self._partial:
            size = sum(len(part) for part in self._partial)
            if self.sent_bytes < size:
                remainder = _remainder(self._partial, self.sent_bytes)
                self._partial = remainder
                self.sent_bytes = 0
                return
            remaining_bytes = self.sent_bytes - size
            self._partial = []
            self.sent_bytes = remaining_bytes
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
            remaining_bytes = self.sent_bytes - size
            del waiting[0]
            self.sent_bytes = remaining_bytes

    def clear(self) -> None:
        """Remove all frames of a link that has been closed."""
        self._waiting.clear()
        self._partial = []
        self.sent_bytes = 0
