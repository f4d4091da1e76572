"""A bounded queue of messages from other bridges. No I/O.

A flood of messages displaces only messages: beacons have a separate queue, and go first.
"""

from __future__ import annotations

from collections import deque

MAX_BEACONS = 20_000
MAX_BYTES = 64 << 20
"""Maximum total size in bytes of the waiting messages; a single larger one is accepted."""
MAX_MESSAGES = 10_000


class Arrivals:
    """Waiting beacons and messages.

    Attributes:
        dropped: how many were dropped because too many were waiting.
    """

    def __init__(self, max_bytes: int = MAX_BYTES, max_messages: int = MAX_MESSAGES) -> None:
        self.dropped = 0
        self._max_bytes = max_bytes
        self._max_messages = max_messages
        self._beacons: deque[str] = deque()
        self._messages: deque[tuple[str, bytes]] = deque()
        self._bytes = 0

    def put_beacon(self, key: str) -> None:
        """Add a beacon; it is dropped if the queue is full."""
        if len(self._beacons) < MAX_BEACONS:
            self._beacons.append(key)
        else:
            self.dropped += 1

    def put_message(self, key: str, body: bytes) -> None:
        """Add a message. If there are too many, the oldest is dropped."""
        self._messages.append((key, body))
        self._bytes += len(body)
        while len(self._messages) > 1 and (self._bytes > self._max_bytes or len(self._messages) > self._max_messages):
            self._bytes -= len(self._messages.popleft()[1])
            self.dropped += 1

    def pop(self) -> tuple[str, bytes | None] | None:
        """Return the next key and its message (None for a beacon) to handle; None if nothing waits."""
        if self._beacons:
            return self._beacons.popleft(), None
        if not self._messages:
            return None
        key, body = self._messages.popleft()
        self._bytes -= len(body)
        return key, body
