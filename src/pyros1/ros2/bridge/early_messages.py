"""Latched messages of publishers that ROS 2 has not discovered yet. No I/O."""

from __future__ import annotations

import threading
from collections.abc import Collection

from pyros1.bridge.exchange.actions import Send

MAX_MESSAGES = 1_000
MAX_BYTES = 64 << 20
"""Maximum total size in bytes of the waiting messages; a single larger one is accepted."""


class EarlyMessages:
    """The last message of each new latched publisher. May be used in several threads."""

    def __init__(self, max_bytes: int = MAX_BYTES) -> None:
        self._max_bytes = max_bytes
        self._packets: dict[str, Send] = {}
        self._bytes = 0
        self._lock = threading.Lock()

    def put(self, packet: Send) -> None:
        """Keep a message until its publisher is discovered, or publishes again. If there are too many, those that have
        waited longest are dropped.
        """
        with self._lock:
            self._remove(packet.key)
            self._packets[packet.key] = packet
            self._bytes += len(packet.body)
            while len(self._packets) > 1 and (self._bytes > self._max_bytes or len(self._packets) > MAX_MESSAGES):
                self._remove(next(iter(self._packets)))

    def pop(self, keys: Collection[str]) -> list[Send]:
        """Remove and return the messages with these keys."""
        with self._lock:
            found = [packet for key, packet in self._packets.items() if key in keys]
            for packet in found:
                self._remove(packet.key)
        return found

    def _remove(self, key: str) -> None:
        packet = self._packets.pop(key, None)
        if packet is not None:
            self._bytes -= len(packet.body)
