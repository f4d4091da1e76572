"""Gates for `Relay`: they decide which messages pass (https://wiki.ros.org/topic_tools/drop and .../throttle)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from itertools import cycle

from pyros1.msgs import AnyMsg


class Drop:
    """A gate that leaves out the first X of every Y messages.

    Args:
        dropped: number of messages to drop, X.
        among: size of each group of messages, Y.
    """

    def __init__(self, dropped: int, among: int) -> None:
        self._passes = cycle([number >= dropped for number in range(among)])

    def __call__(self, message: AnyMsg) -> bool:
        """Return whether the message passes."""
        return next(self._passes)


class MessageThrottle:
    """A gate for `Relay` that passes messages with a minimum period between them.

    Args:
        period: the period in nanoseconds.
        now: returns the time in nanoseconds.
        on_time_jump: called when the time has jumped back, which restarts the period.
    """

    def __init__(self, period: int, now: Callable[[], int], on_time_jump: Callable[[], object]) -> None:
        self._period = period
        self._now = now
        self._on_time_jump = on_time_jump
        self._last = 0

    def __call__(self, message: AnyMsg) -> bool:
        """Return whether the message passes."""
        now = self._now()
        if now < self._last:
            self._on_time_jump()
            self._last = now
        if now - self._last <= self._period:
            return False
        self._last = now
        return True


class ByteThrottle:
    """A gate for `Relay` that passes messages while fewer than a number of bytes have passed within a time window.

    Args:
        max_bytes: the number of bytes.
        window: the length of the window in nanoseconds.
        now: returns the time in nanoseconds.
        on_time_jump: called when the time has jumped back, which clears the window.
    """

    def __init__(self, max_bytes: int, window: int, now: Callable[[], int], on_time_jump: Callable[[], object]) -> None:
        self._max_bytes = max_bytes
        self._window = window
        self._now = now
        self._on_time_jump = on_time_jump
        self._sent: deque[tuple[int, int]] = deque()
        self._bytes = 0

    def __call__(self, message: AnyMsg) -> bool:
        """Return whether the message passes."""
        now = self._now()
        sent = self._sent
        if sent and now < sent[-1][0]:
            self._on_time_jump()
            sent.clear()
            self._bytes = 0
        while sent and sent[0][0] < now - self._window:
            self._bytes -= sent.popleft()[1]
        if self._bytes >= self._max_bytes:
            return False
        size = len(message._buff)
        sent.append((now, size))
        self._bytes += size
        return True
