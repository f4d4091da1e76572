"""Limits the calls that each ROS 2 client may have in progress, so that a busy one leaves room for others. No I/O."""

from __future__ import annotations

import threading


class CallShares:
    """The calls in progress, by client. A client may make another call while it has fewer in progress than there are
    free places: a lone client gets half of all places, the next one half of the rest, and so on. May be used in several
    threads.

    Args:
        limit: maximum number of calls in progress.
    """

    def __init__(self, limit: int) -> None:
        self._limit = limit
        self._calls: dict[bytes, int] = {}
        self._total = 0
        self._lock = threading.Lock()

    def begin(self, client: bytes) -> bool:
        """Return whether a client may make a call now, and if so, count it.

        Args:
            client: identifies the client.
        """
        with self._lock:
            own = self._calls.get(client, 0)
            if own >= self._limit - self._total:
                return False
            self._calls[client] = own + 1
            self._total += 1
            return True

    def end(self, client: bytes) -> None:
        """Record that a call of a client has ended."""
        with self._lock:
            self._total -= 1
            self._calls[client] -= 1
            if not self._calls[client]:
                del self._calls[client]
