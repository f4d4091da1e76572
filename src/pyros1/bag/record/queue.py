"""A bounded queue between the receiving threads and the writing thread; the oldest messages are dropped first."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Generic, TypeVar

_S = TypeVar("_S")

MESSAGE_OVERHEAD = 250
"""Bytes of memory that a waiting message takes in addition to its own size."""
_MAX_BATCH_BYTES = 4 << 20
"""Number of bytes that `take` removes at a time; these are in memory in addition to the queue's limit."""
_WAKE_BYTES = 1 << 20
"""Number of waiting bytes at which the writer is woken early."""


class RecordQueue(Generic[_S]):
    """Messages that have been received but not written yet.

    Args:
        limit: maximum size in bytes; 0 for no limit.
        on_put: called with the source and size in bytes of each accepted message, before the message can be taken, so
            that the callback's counts are complete when the queue is closed.
        on_drop: called with the source of each dropped message, in the thread that adds a newer message.
    """

    def __init__(self, limit: int, on_put: Callable[[_S, int], object], on_drop: Callable[[_S], object]) -> None:
        self._limit = limit
        self._on_put = on_put
        self._on_drop = on_drop
        self._entries: deque[tuple[_S, int, bytes]] = deque()
        self._bytes = 0
        self._lock = threading.Lock()
        self._wake_at = min(_WAKE_BYTES, limit // 4) if limit else _WAKE_BYTES
        self._wake = threading.Event()
        self._closed = False

    def put(self, source: _S, time: int, data: bytes) -> bool:
        """Add a message; return False if the queue is closed.

        Args:
            source: the source of the message.
            time: receive time in nanoseconds.
            data: its bytes.
        """
        with self._lock:
            if self._closed:
                return False
            self._on_put(source, len(data))
            self._entries.append((source, time, data))
            self._bytes += len(data) + MESSAGE_OVERHEAD
            if self._limit and self._bytes > self._limit:
                self._make_room()
        if self._bytes > self._wake_at and not self._wake.is_set():
            self._wake.set()
        return True

    def _make_room(self) -> None:
        while self._bytes > self._limit and len(self._entries) > 1:
            source, _, data = self._entries.popleft()
            self._bytes -= len(data) + MESSAGE_OVERHEAD
            self._on_drop(source)

    def take(self, timeout: float) -> list[tuple[_S, int, bytes]]:
        """Remove and return some of the oldest messages.

        Args:
            timeout: seconds to wait for messages to accumulate, unless many are already waiting.
        """
        if self._bytes <= self._wake_at:
            self._wake.wait(timeout)
        self._wake.clear()
        batch: list[tuple[_S, int, bytes]] = []
        size = 0
        with self._lock:
            entries = self._entries
            while entries and size < _MAX_BATCH_BYTES:
                entry = entries.popleft()
                size += len(entry[2]) + MESSAGE_OVERHEAD
                batch.append(entry)
            self._bytes -= size
        return batch

    def close(self) -> list[tuple[_S, int, bytes]]:
        """Stop accepting messages, and return all waiting ones."""
        with self._lock:
            self._closed = True
            batch = list(self._entries)
            self._entries.clear()
            return batch

    def wake(self) -> None:
        """Make `take` return at once."""
        self._wake.set()
