"""Gates for `Relay`: they decide which messages pass (https://wiki.ros.org/topic_tools/drop and .../throttle)."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from itertools import cycle

from pyros1.msgs import AnyMsg


class Drop:
    """A gate that leaves out the first X of every Y messages.

    Args:
        dropped: the number of messages to drop from each group, X.
        group_size: the number of messages in each group, Y.
    """

    def __init__(self, dropped: int, group_size: int) -> None:
        self._pass_sequence = cycle([number >= dropped for number in range(group_size)])

    def __call__(self, message: AnyMsg) -> bool:
        """Return whether the message passes."""
        return next(self._pass_sequence)


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
        self._last_passed_at = 0

    def __call__(self, message: AnyMsg) -> bool:
        """Return whether the message passes."""
        now = self._now()
        if now < self._last_passed_at:
            self._on_time_jump()
            self._last_passed_at = now
        if now - self._last_passed_at <= self._period:
            return False
        self._last_passed_at = now
        return True


class ByteThrottle:
    """A gate for `Relay` that passes messages while fewer than `max_bytes` bytes have passed in a time window.

    Args:
        max_bytes: no message passes if that many bytes or more have passed in the window.
        window: the length of the window in nanoseconds.
        now: returns the time in nanoseconds.
        on_time_jump: called when the time has jumped back, which clears the window.
    """

    def __init__(self, max_bytes: int, window: int, now: Callable[[], int], on_time_jump: Callable[[], object]) -> None:
        self._max_bytes = max_bytes
        self._window = window
        self._now = now
        self._on_time_jump = on_time_jump
        self._passed_messages: deque[tuple[int, int]] = deque()
        self._bytes_in_window = 0

    def __call__(self, message: AnyMsg) -> bool:
        """Return whether the message passes."""
        now = self._now()
        passed_messages = self._passed_messages
        if passed_messages and now < passed_messages[-1][0]:
            self._on_time_jump()
            passed_messages.clear()
            self._bytes_in_window = 0
        while passed_messages and passed_messages[0][0] < now - self._window:
            self._bytes_in_window -= passed_messages.popleft()[1]
        if self._bytes_in_window >= self._max_bytes:
            return False
        size = len(message._buff)
        passed_messages.append((now, size))
        self._bytes_in_window += size
        return True
