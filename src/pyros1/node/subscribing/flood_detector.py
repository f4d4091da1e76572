"""Floods of single messages: a publisher that sends each message separately wakes the receiver for each, which costs
the publisher more than sending. So the receiver lets them gather for a moment.
"""

from __future__ import annotations

import time
from time import perf_counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyros1.node.subscribing.tcp_source import TcpSource

MAX_FLOOD_GAP = 30e-6
MAX_FLOOD_MESSAGES = 16
MAX_FLOOD_BYTES = 65536
"""A flood: MIN_FLOOD_STREAK receives in a row, of at most FEW messages and MAX_FLOOD_BYTES bytes each, less than
MAX_FLOOD_GAP seconds apart.
"""
MIN_FLOOD_STREAK = 100
GATHER_TIME = 200e-6
"""Seconds of a pause, in which messages gather."""


class FloodDetector:
    """Watches one link for floods while its receiver serves it."""

    def __init__(self, link: TcpSource) -> None:
        self._link = link
        self._streak = 0
        self._messages = link.messages
        self._size = link.bytes_received
        self._last = perf_counter()

    def pause(self) -> None:
        """Pause after a receive if a flood of single messages is arriving."""
        link, now = self._link, perf_counter()
        count = link.messages - self._messages
        if now - self._last > count * MAX_FLOOD_GAP or link.bytes_received - self._size > MAX_FLOOD_BYTES:
            self._streak = 0
        elif count <= MAX_FLOOD_MESSAGES:
            self._streak += 1
            if self._streak > MIN_FLOOD_STREAK:
                time.sleep(GATHER_TIME)
        self._messages, self._size, self._last = link.messages, link.bytes_received, now
