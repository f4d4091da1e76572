"""How often messages come, how large and how old they are: classes whose methods are callbacks of subscribers."""

from __future__ import annotations

import math
import sys
import threading
import time
from collections import defaultdict
from collections.abc import Sequence
from typing import Any

import rospy

_MOST = 50_000
"""Size of a window without limit."""


class ROSTopicHz:
    """Rates of topics.

    Args:
        window_size: number of messages that count; negative: many.
        filter_expr: function that tells whether a message counts; None: all do.
        use_wtime: whether to use wall time, not the node's.
    """

    def __init__(self, window_size: int, filter_expr: Any = None, use_wtime: bool = False) -> None:
        self.lock = threading.Lock()
        self.last_printed_tn: float = 0
        self.msg_t0: float = -1
        self.msg_tn: float = 0
        self.times: list[float] = []
        self._last_printed_tn: dict[Any, float] = defaultdict(int)
        self._msg_t0: dict[Any, float] = defaultdict(lambda: -1)
        self._msg_tn: dict[Any, float] = defaultdict(int)
        self._times: dict[Any, list[float]] = defaultdict(list)
        self.filter_expr = filter_expr
        self.use_wtime = use_wtime
        self.window_size = _MOST if window_size < 0 else window_size

    def get_last_printed_tn(self, topic: Any = None) -> float:
        """Return the time of the last message that was printed, in seconds."""
        return self.last_printed_tn if topic is None else self._last_printed_tn[topic]

    def set_last_printed_tn(self, value: float, topic: Any = None) -> None:
        """Set the time of the last message that was printed."""
        if topic is None:
            self.last_printed_tn = value
        self._last_printed_tn[topic] = value

    def get_msg_t0(self, topic: Any = None) -> float:
        """Return the time of the first message in seconds, -1 before it came."""
        return self.msg_t0 if topic is None else self._msg_t0[topic]

    def set_msg_t0(self, value: float, topic: Any = None) -> None:
        """Set the time of the first message."""
        if topic is None:
            self.msg_t0 = value
        self._msg_t0[topic] = value

    def get_msg_tn(self, topic: Any = None) -> float:
        """Return the time of the last message in seconds."""
        return self.msg_tn if topic is None else self._msg_tn[topic]

    def set_msg_tn(self, value: float, topic: Any = None) -> None:
        """Set the time of the last message."""
        if topic is None:
            self.msg_tn = value
        self._msg_tn[topic] = value

    def get_times(self, topic: Any = None) -> list[float]:
        """Return the seconds between messages."""
        return self.times if topic is None else self._times[topic]

    def set_times(self, value: list[float], topic: Any = None) -> None:
        """Set the seconds between messages."""
        if topic is None:
            self.times = value
        self._times[topic] = value

    def callback_hz(self, m: Any, topic: Any = None) -> None:
        """Count a message.

        Args:
            m: the message.
            topic: its topic, if there are several.
        """
        if self.filter_expr is not None and not self.filter_expr(m):
            return
        with self.lock:
            now = time.time() if self.use_wtime else rospy.get_rostime().to_sec()
            if self.get_msg_t0(topic) < 0 or self.get_msg_t0(topic) > now:  # the first, or time has gone back
                self.set_msg_t0(now, topic)
                self.set_times([], topic)
            else:
                self.get_times(topic).append(now - self.get_msg_tn(topic))
            self.set_msg_tn(now, topic)
            if len(self.get_times(topic)) > self.window_size - 1:
                self.get_times(topic).pop(0)

    def get_hz(self, topic: Any = None) -> tuple[float, float, float, float, int] | None:
        """Return rate in Hz; shortest, longest and standard deviation of the time between messages in seconds; and
        number of messages. None if nothing came since the last call.
        """
        with self.lock:
            times = list(self.get_times(topic))
            if not times or self.get_msg_tn(topic) == self.get_last_printed_tn(topic):
                return None
            self.set_last_printed_tn(self.get_msg_tn(topic), topic)
        mean = sum(times) / len(times)
        deviation = math.sqrt(sum((each - mean) ** 2 for each in times) / len(times))
        return (1.0 / mean if mean > 0 else 0.0), min(times), max(times), deviation, len(times) + 1

    def print_hz(self, topics: Sequence[Any] = (None,)) -> None:
        """Print the rates of topics."""
        if len(topics) == 1:
            found = self.get_hz(topics[0])
            if found is None:
                print("no new messages")
                return
            rate, shortest, longest, deviation, count = found
            print(
                f"average rate: {rate:.3f}\n\tmin: {shortest:.3f}s max: {longest:.3f}s std dev: {deviation:.5f}s "
                f"window: {count}"
            )
            sys.stdout.flush()
            return
        rows = []
        for topic in topics:
            found = self.get_hz(topic)
            if found is not None:
                rows.append((str(topic), *(f"{each:.4g}" for each in found[:4]), str(found[4])))
        if not rows:
            print("no new messages")
            return
        print(_get_ascii_table(("topic", "rate", "min_delta", "max_delta", "std_dev", "window"), rows))


def _get_ascii_table(header: Sequence[str], cols: Sequence[Sequence[str]]) -> str:
    """Return rows as a table.

    Args:
        header: names of the columns.
        cols: the rows.
    """
    widths = [max(map(len, column)) for column in zip(header, *cols, strict=True)]
    lines = ["   ".join(f"{word:<{width}}" for word, width in zip(row, widths, strict=True)) for row in (header, *cols)]
    return "\n".join((lines[0], "=" * len(lines[0]), *lines[1:]))


class ROSTopicBandwidth:
    """Bytes per second of a topic; subscribe with `rospy.AnyMsg`.

    Args:
        window_size: number of messages that count; negative: many.
    """

    def __init__(self, window_size: int = 100) -> None:
        self.lock = threading.Lock()
        self.last_printed_tn = 0
        self.sizes: list[int] = []
        self.times: list[float] = []
        self.window_size = window_size if window_size >= 0 else _MOST

    def callback(self, data: Any) -> None:
        """Count a message."""
        with self.lock:
            self.times.append(time.time())
            self.sizes.append(len(data._buff))
            if len(self.times) > self.window_size:
                self.times.pop(0)
                self.sizes.pop(0)

    def print_bw(self) -> None:
        """Print bytes per second, and the sizes of the messages."""
        with self.lock:
            times, sizes = list(self.times), list(self.sizes)
        if len(times) < 2:
            return
        duration = max(time.time() - times[0], 1e-9)
        rate = sum(sizes) / duration
        scale, unit = (1, "B") if rate < 1000 else (1000, "KB") if rate < 1_000_000 else (1_000_000, "MB")
        values = (sum(sizes) / len(sizes), min(sizes), max(sizes))
        mean, least, most = (f"{each / scale:.2f}{unit}" for each in values)
        print(f"average: {rate / scale:.2f}{unit}/s\n\tmean: {mean} min: {least} max: {most} window: {len(sizes)}")
        sys.stdout.flush()


class ROSTopicDelay:
    """Age of messages with headers.

    Args:
        window_size: number of messages that count; negative: many.
    """

    def __init__(self, window_size: int) -> None:
        self.lock = threading.Lock()
        self.last_msg_tn: float = 0
        self.msg_t0: float = -1.0
        self.msg_tn: float = 0
        self.delays: list[float] = []
        self.window_size = _MOST if window_size < 0 else window_size

    def callback_delay(self, msg: Any) -> None:
        """Count a message."""
        if not msg._has_header:
            rospy.logerr("msg does not have header")
            return
        with self.lock:
            now = rospy.get_rostime()
            if now.to_sec() < self.msg_tn:  # time has gone back
                self.delays = []
            self.delays.append((now - msg.header.stamp).to_sec())
            self.msg_tn = now.to_sec()
            if self.msg_t0 < 0:
                self.msg_t0 = self.msg_tn
            if len(self.delays) > self.window_size:
                self.delays.pop(0)

    def get_delay(self) -> tuple[float, float, float, float, int] | None:
        """Return mean, least, greatest and standard deviation of the ages in seconds, and number of messages.

        None if nothing came since the last call.
        """
        with self.lock:
            delays = list(self.delays)
            if not delays or self.msg_tn == self.last_msg_tn:
                return None
            self.last_msg_tn = self.msg_tn
        mean = sum(delays) / len(delays)
        deviation = math.sqrt(sum((each - mean) ** 2 for each in delays) / len(delays))
        return mean, min(delays), max(delays), deviation, len(delays)

    def print_delay(self) -> None:
        """Print the ages."""
        if not self.delays:
            return
        found = self.get_delay()
        if found is None:
            print("no new messages")
            return
        mean, least, most, deviation, count = found
        print(
            f"average delay: {mean:.3f}\n\tmin: {least:.3f}s max: {most:.3f}s std dev: {deviation:.5f}s window: {count}"
        )
        sys.stdout.flush()
