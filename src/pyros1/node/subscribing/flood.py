"""Floods of single messages: a publisher that sends each message separately wakes the receiver for each, which costs
the publisher more than the sending. So the receiver lets them gather for a moment.
"""

from __future__ import annotations

import time
from time import perf_counter
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pyros1.node.subscribing.tcp_source import TcpSource

FLOOD = 30e-6
FEW = 16
LITTLE = 65536
"""A flood: FLOOD_RUN_UP receives in a row, of at most FEW messages and LITTLE bytes each, less than FLOOD seconds
apart.
"""
FLOOD_RUN_UP = 100
GATHER = 200e-6
"""Seconds of a pause, in which messages gather."""


class Flood:
    """Watches one link for floods while its receiver stays with it."""

    def __init__(self, link: TcpSource) -> None:
        self._link = link
        self._few = 0
        self._messages = link.messages
        self._size = link.bytes_received
        self._last = perf_counter()

    def pause(self) -> None:
        """Pause after a receive, if a flood of single messages comes."""
        link, now = self._link, perf_counter()
        count = link.messages - self._messages
        if now - self._last > count * FLOOD or link.bytes_received - self._size > LITTLE:
            self._few = 0
        elif count <= FEW:
            self._few += 1
            if self._few > FLOOD_RUN_UP:
                time.sleep(GATHER)
        self._messages, self._size, self._last = link.messages, link.bytes_received, now
