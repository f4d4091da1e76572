"""Backlog of a subscription with slow callbacks: the newest messages of each publisher, still encoded."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, Generic, TypeVar

from pyros1.msgs.large_arrays import SplitBody

if TYPE_CHECKING:
    from pyros1.node.subscribing.tcp_source import TcpSource

S = TypeVar("S")
T = TypeVar("T")


class Backlog(Generic[S, T]):
    """The newest messages of each source; sources take turns.

    Args:
        limit: maximum number of messages to keep of each source.
    """

    def __init__(self, limit: int) -> None:
        self.dropped = 0
        self._limit = max(1, limit)
        self._waiting: dict[S, deque[T]] = {}

    def __bool__(self) -> bool:
        return bool(self._waiting)

    def put(self, source: S, item: T) -> None:
        """Keep a message, in place of the oldest of its source if there are too many."""
        items = self._waiting.get(source)
        if items is None:
            items = self._waiting[source] = deque(maxlen=self._limit)
        self.dropped += len(items) == self._limit
        items.append(item)

    def put_frames(self, link: TcpSource, frames: list[tuple[int, int]] | SplitBody) -> None:
        """Keep the newest frames of one receive. For backlogs of links and bytes."""
        if isinstance(frames, SplitBody):
            self.put(link, frames)  # type: ignore[arg-type]
        elif link.items is not None:
            for item in link.items:
                self.put(link, item)  # type: ignore[arg-type]
            link.items = None
        elif frames:
            self.dropped += max(0, len(frames) - self._limit)
            for body in link.buffer.take_bodies(frames[-self._limit :]):
                self.put(link, body)  # type: ignore[arg-type]

    def take(self) -> tuple[S, T]:
        """Take the oldest message of the source whose turn it is."""
        source = next(iter(self._waiting))
        items = self._waiting.pop(source)
        item = items.popleft()
        if items:
            self._waiting[source] = items  # behind the other sources now
        return source, item
