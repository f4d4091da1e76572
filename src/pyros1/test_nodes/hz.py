"""hztest checks the rate of the messages on a topic (https://wiki.ros.org/rostest/Nodes)."""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING

from pyros1.msgs import AnyMsg
from pyros1.test_nodes.common import POLL_INTERVAL, Test, pause, require, required_params

if TYPE_CHECKING:
    from pyros1.node import Node

_DEFAULT_WAIT_TIME = 20.0


class Meter:
    """Measures the rate of messages.

    Args:
        hz: expected rate in Hz; 0 if no messages are expected.
        hzerror: allowed deviation in Hz.
        check_intervals: whether to check each interval between two messages, not only the mean rate.

    Attributes:
        any_received: an event that is set when a message has arrived.
        count: number of messages that were counted. Messages that arrive before simulated time has started are not
            counted; if time jumps back to before the first counted message, counting starts again.
    """

    def __init__(self, hz: float, hzerror: float, *, check_intervals: bool = False) -> None:
        self.any_received = threading.Event()
        self.count = 0
        self._hz = hz
        self._min_rate, self._max_rate = hz - hzerror, hz + hzerror
        self._check_intervals = check_intervals
        self._interval_errors: list[str] = []
        self._first_time = self._last_time = 0.0
        self._lock = threading.Lock()  # messages of several publishers arrive in several threads

    def add(self, now: float) -> None:
        """Process the arrival of a message.

        Args:
            now: the time of arrival in seconds; 0 before simulated time has started. A message that arrives at time 0
                sets `any_received`, but is not counted.
        """
        self.any_received.set()
        with self._lock:
            if now == 0:
                return
            if not self.count or now < self._first_time:
                self._first_time, self.count = now, 1
            else:
                self.count += 1
                if self._check_intervals:
                    self._check_interval(now - self._last_time)
            self._last_time = now

    def _check_interval(self, interval: float) -> None:
        if self._max_rate > 0 and interval < 1 / self._max_rate:
            self._interval_errors.append(
                f"an interval of {interval:.6f} s is too short: the minimum is {1 / self._max_rate:.6f} s"
            )
        elif self._min_rate > 0 and interval > 1 / self._min_rate:
            self._interval_errors.append(
                f"an interval of {interval:.6f} s is too long: the maximum is {1 / self._min_rate:.6f} s"
            )

    def check_rate(self) -> None:
        """Check the rate of the messages that were counted.

        Raises:
            FailedError: the rate is not as expected.
        """
        with self._lock:
            if not self._hz:
                require(not self.count, f"expected no messages, but {self.count} arrived")
                return
            require(self.count, "no messages arrived after the clock had started")
            require(not self._interval_errors, "\n".join(self._interval_errors))
            measured_seconds = self._last_time - self._first_time
            require(measured_seconds > 0, "one message is not enough to measure a rate")
            rate = (self.count - 1) / measured_seconds
            require(
                rate >= self._min_rate,
                f"the rate of {rate:.3f} Hz is below the minimum of {self._min_rate:.3f} Hz",
            )
            require(
                rate <= self._max_rate,
                f"the rate of {rate:.3f} Hz is above the maximum of {self._max_rate:.3f} Hz",
            )


def tests(node: Node) -> dict[str, Test]:
    """Return the test cases of hztest, by name.

    Args:
        node: the node; its parameters are ~topic, ~hz, ~hzerror, ~test_duration, ~wait_time, ~check_intervals and
            ~wall_clock.
    """
    return {"test_hz": lambda: _test_hz(node)}


def _test_hz(node: Node) -> None:
    hz, duration, topic = required_params(node, "hz", "test_duration", "topic")
    hz, duration, hzerror = float(hz), float(duration), 0.0
    timeout = float(node.params.get("~wait_time", _DEFAULT_WAIT_TIME))
    if hz:
        hzerror = float(required_params(node, "hzerror")[0])
    check_intervals = bool(node.params.get("~check_intervals", False))
    wall_clock = bool(node.params.get("~wall_clock", False))
    node.log.info(f"hz: {hz}, hzerror: {hzerror}, topic: {topic}, test_duration: {duration}")
    require(hz >= 0, f"~hz must not be negative: {hz}")
    require(hzerror >= 0, f"~hzerror must not be negative: {hzerror}")
    require(duration > 0, f"~test_duration must be greater than 0: {duration}")
    require(topic, "~topic is empty")

    meter = Meter(hz, hzerror, check_intervals=check_intervals)

    def on_message(_message: AnyMsg) -> None:
        meter.add(time.monotonic() if wall_clock else node.now().to_sec())

    subscriber = node.subscribe(topic, AnyMsg, on_message)
    node.log.info(f"waiting up to {timeout:g} s for the first message")
    deadline = time.monotonic() + timeout
    while not meter.any_received.is_set() and time.monotonic() < deadline:
        pause(node, min(POLL_INTERVAL, timeout))
    if hz:
        require(meter.any_received.is_set(), f"no message on {subscriber.name} within {timeout:g} s")
    else:
        require(not meter.any_received.is_set(), f"a message arrived on {subscriber.name}")
    node.log.info(f"measuring for {duration:g} s")
    if wall_clock:
        pause(node, duration)
    elif not node.sleep(duration):
        pause(node, 0)  # raises if the test was interrupted
    subscriber.unregister()
    meter.check_rate()
