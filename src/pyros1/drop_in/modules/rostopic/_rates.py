"""Measures the rate, size and age of messages: `rostopic hz`, `bw` and `delay` for programs."""

from __future__ import annotations

import time
import traceback
from collections import defaultdict
from collections.abc import Callable, Sequence
from threading import Lock
from typing import Any

import rospy

from pyros1.observe.statistics import (
    BW_WINDOW,
    HZ_WINDOW,
    Summary,
    delay_lines,
    rate_lines,
    rate_table,
    size_lines,
    summarise,
)


class ROSTopicHz:
    """Measures how often messages arrive.

    Args:
        window_size: maximum number of messages in the window; -1 for a very large number.
        filter_expr: called with each message; returns whether to count it. None to count all.
        use_wtime: whether to use wall time instead of ROS time.
    """

    def __init__(
        self, window_size: int, filter_expr: Callable[[Any], object] | None = None, use_wtime: bool = False
    ) -> None:
        self.lock = Lock()
        self.window_size = HZ_WINDOW if window_size < 0 else window_size
        self.filter_expr = filter_expr
        self.use_wtime = use_wtime
        self._last_printed: defaultdict[str | None, float] = defaultdict(int)
        self._first: defaultdict[str | None, float] = defaultdict(lambda: -1)
        self._latest: defaultdict[str | None, float] = defaultdict(int)
        self._gaps: defaultdict[str | None, list[float]] = defaultdict(list)

    @property
    def last_printed_tn(self) -> float:
        """See `get_last_printed_tn`."""
        return self._last_printed[None]

    @property
    def msg_t0(self) -> float:
        """See `get_msg_t0`."""
        return self._first[None]

    @property
    def msg_tn(self) -> float:
        """See `get_msg_tn`."""
        return self._latest[None]

    @property
    def times(self) -> list[float]:
        """See `get_times`."""
        return self._gaps[None]

    def get_last_printed_tn(self, topic: str | None = None) -> float:
        """Return the time, in seconds, of the latest message that `get_hz` included; 0 if there is none."""
        return self._last_printed[topic]

    def set_last_printed_tn(self, value: float, topic: str | None = None) -> None:
        """Set the time that `get_last_printed_tn` returns."""
        self._last_printed[topic] = value

    def get_msg_t0(self, topic: str | None = None) -> float:
        """Return the time, in seconds, of the first message; -1 if there is none."""
        return self._first[topic]

    def set_msg_t0(self, value: float, topic: str | None = None) -> None:
        """Set the time that `get_msg_t0` returns."""
        self._first[topic] = value

    def get_msg_tn(self, topic: str | None = None) -> float:
        """Return the time, in seconds, of the latest message; 0 if there is none."""
        return self._latest[topic]

    def set_msg_tn(self, value: float, topic: str | None = None) -> None:
        """Set the time that `get_msg_tn` returns."""
        self._latest[topic] = value

    def get_times(self, topic: str | None = None) -> list[float]:
        """Return the seconds between consecutive messages in the window."""
        return self._gaps[topic]

    def set_times(self, value: list[float], topic: str | None = None) -> None:
        """Set the times that `get_times` returns."""
        self._gaps[topic] = value

    def callback_hz(self, m: Any, topic: str | None = None) -> None:
        """Count a message.

        Args:
            m: the message; only ``filter_expr`` uses it.
            topic: the topic's name, if there are several.
        """
        if self.filter_expr is not None and not self.filter_expr(m):
            return
        with self.lock:
            now = time.time() if self.use_wtime else rospy.get_rostime().to_sec()
            gaps = self._gaps[topic]
            if now == 0:
                if gaps:
                    print("time has reset, resetting counters")
                    self._gaps[topic] = []
                return
            if not 0 <= self._first[topic] <= now:  # the first message, or the time has jumped back
                self._first[topic] = now
                self._gaps[topic] = []
            else:
                gaps.append(now - self._latest[topic])
                if len(gaps) >= self.window_size:
                    del gaps[0]
            self._latest[topic] = now

    def get_hz(self, topic: str | None = None) -> tuple[float, float, float, float, int] | None:
        """Return statistics of the messages in the window.

        Returns:
            The rate in Hz; the minimum, maximum and standard deviation of the time between messages, in seconds; the
            number of messages. None if there are no new messages since the last call.
        """
        with self.lock:
            gaps = self._gaps.get(topic)
            latest = self._latest[topic]
            if not gaps or latest == self._last_printed[topic]:
                return None
            self._last_printed[topic] = latest
            summary = summarise(gaps)
            count = len(gaps) + 1
        rate = 1 / summary.mean if summary.mean > 0 else 0
        return rate, summary.minimum, summary.maximum, summary.deviation, count

    def print_hz(self, topics: Sequence[str | None] = (None,)) -> None:
        """Print the statistics of one topic, or a table for several topics."""
        results = {topic: result for topic in topics if (result := self.get_hz(topic)) is not None}
        if not results:
            print("no new messages")
        elif len(topics) == 1:
            print(rate_lines(*_with_summary(results[topics[0]])))
        else:
            print(rate_table({str(topic): _with_summary(result) for topic, result in results.items()}))


def _with_summary(result: tuple[float, float, float, float, int]) -> tuple[float, Summary, int]:
    rate, minimum, maximum, deviation, number = result
    return rate, Summary(0.0, minimum, maximum, deviation), number


class ROSTopicBandwidth:
    """Measures how many bytes per second arrive.

    Args:
        window_size: maximum number of messages in the window.
    """

    def __init__(self, window_size: int = BW_WINDOW) -> None:
        self.lock = Lock()
        self.last_printed_tn = 0
        self.sizes: list[int] = []
        self.times: list[float] = []
        self.window_size = window_size

    def callback(self, data: Any) -> None:
        """Count a message, which must be an AnyMsg; a failure is printed to stderr."""
        with self.lock:
            try:
                size = len(data._buff)
                self.times.append(time.time())
                self.sizes.append(size)
                if len(self.times) > self.window_size:
                    del self.times[0], self.sizes[0]
            except Exception:  # noqa: BLE001 - not an AnyMsg: it is not counted
                traceback.print_exc()

    def print_bw(self) -> None:
        """Print the statistics; nothing while there are fewer than two messages."""
        with self.lock:
            if len(self.times) < 2:
                return
            elapsed = time.time() - self.times[0]
            sizes = list(self.sizes)
        if elapsed > 0:
            print(size_lines(sizes, elapsed))


class ROSTopicDelay:
    """Measures how old messages are when they arrive: the time since the stamp in their header.

    Args:
        window_size: maximum number of messages in the window; -1 for a very large number.
    """

    def __init__(self, window_size: int) -> None:
        self.lock = Lock()
        self.last_msg_tn: float = 0
        self.msg_t0 = -1.0
        self.msg_tn: float = 0
        self.delays: list[float] = []
        self.window_size = HZ_WINDOW if window_size < 0 else window_size

    def callback_delay(self, msg: Any) -> None:
        """Count a message; the first one only starts the window."""
        if not msg._has_header:
            rospy.logerr("msg does not have header")
            return
        with self.lock:
            now = rospy.get_rostime().to_sec()
            if now == 0:
                if self.delays:
                    print("time has reset, resetting counters")
                    self.delays = []
                return
            if not 0 <= self.msg_t0 <= now:
                self.msg_t0 = now
                self.delays = []
            else:
                self.delays.append(now - msg.header.stamp.to_sec())
                if len(self.delays) >= self.window_size:
                    del self.delays[0]
            self.msg_tn = now

    def get_delay(self) -> tuple[float, float, float, float, int] | None:
        """Return statistics of the messages in the window.

        Returns:
            The mean, minimum and maximum age and the standard deviation, in seconds; the number of messages. None if
            there are no new messages since the last call.
        """
        with self.lock:
            if not self.delays or self.msg_tn == self.last_msg_tn:
                return None
            self.last_msg_tn = self.msg_tn
            summary, count = summarise(self.delays), len(self.delays) + 1
        return summary.mean, summary.minimum, summary.maximum, summary.deviation, count

    def print_delay(self) -> None:
        """Print the statistics; nothing while there are fewer than two messages."""
        if not self.delays:
            return
        result = self.get_delay()
        if result is None:
            print("no new messages")
            return
        *values, number = result
        print(delay_lines(Summary(*values), number))
