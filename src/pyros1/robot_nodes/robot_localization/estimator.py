"""Feeds measurements to the filter in order of time, including late ones. Pure.

Measurements wait in a queue until `Estimator.advance`. With a history, a measurement that is older than the estimate
takes the filter back to an earlier state, from which all later measurements are applied again. Without a history, it
corrects the current estimate.
"""

from __future__ import annotations

import heapq
from collections import deque
from dataclasses import dataclass
from itertools import count

import numpy as np

from pyros1.robot_nodes.robot_localization.control import Control
from pyros1.robot_nodes.robot_localization.ekf import Ekf, Measurement
from pyros1.robot_nodes.robot_localization.motion import Array

MAX_QUEUED = 2000
"""Maximum number of measurements that wait, for example because their clock is ahead."""
MAX_HISTORY = 5000
"""Maximum number of measurements in the history, however long it is."""
MAX_STEP = 100_000.0
"""A longer step, in seconds, can only be a clock error; `CLOCK_ERROR_STEP` is predicted instead."""
CLOCK_ERROR_STEP = 0.01


@dataclass(frozen=True, slots=True)
class _Past:
    """A measurement that was used, and the time, state and covariance after it."""

    measurement: Measurement
    time: int
    state: Array
    covariance: Array


class Estimator:
    """A filter with a queue and a history.

    Args:
        ekf: the filter.
        history: nanoseconds by which measurements may be late and still be fused in order; 0 for no history.
        sensor_timeout: nanoseconds without measurements after which the state is predicted.
        always_predict: whether the state is always predicted up to the current time.
        control: the robot's commands, or None.

    Attributes:
        ekf: the filter.
        time: the time of the estimate in nanoseconds; None before the first measurement.
        num_rejected: number of measurements that were too far from the estimate.
        num_too_late: number of measurements that were older than the history.
        num_dropped: number of measurements that did not fit into the queue.
    """

    def __init__(
        self,
        ekf: Ekf,
        *,
        history: int = 0,
        sensor_timeout: int = 33_000_000,
        always_predict: bool = False,
        control: Control | None = None,
    ) -> None:
        self.ekf = ekf
        self.time: int | None = None
        self.num_rejected = self.num_too_late = self.num_dropped = 0
        self.control = control
        self._history_length = history
        self._sensor_timeout = sensor_timeout
        self._always_predict = always_predict
        self._queue: list[tuple[int, int, Measurement]] = []
        self._numbers = count()
        self._history: deque[_Past] = deque(maxlen=MAX_HISTORY)

    def add(self, measurement: Measurement) -> None:
        """Put a measurement into the queue."""
        if len(self._queue) >= MAX_QUEUED:
            self.num_dropped += 1
            return
        heapq.heappush(self._queue, (measurement.time, next(self._numbers), measurement))

    def advance(self, now: int) -> None:
        """Use the measurements up to a time in nanoseconds, and predict if there have been none for too long."""
        with np.errstate(all="ignore"):  # callers check whether the estimate is still finite
            self._advance(now)

    def _advance(self, now: int) -> None:
        had_measurements = bool(self._queue)
        if self._history_length and self.time is not None:
            while self._queue and self._queue[0][0] < self.time and not self._go_back(self._queue[0][0]):
                self.num_too_late += 1
                self._use(heapq.heappop(self._queue)[2])
        while self._queue and self._queue[0][0] <= now:
            self._use(heapq.heappop(self._queue)[2])
        if self.time is None:
            return
        timed_out = not had_measurements and now - self.time >= self._sensor_timeout
        if now > self.time and (timed_out or self._always_predict):
            self._predict(now)
        self._forget(self.time - self._history_length)

    def set_state(self, state: Array, covariance: Array, time: int) -> None:
        """Set the estimate (15,) and its covariance (15, 15), and clear the queue and the history."""
        self.clear()
        self.ekf.state, self.ekf.covariance = state.copy(), covariance.copy()
        self.time = time

    def skip_to(self, now: int) -> None:
        """Clear the queue, and set the time of the estimate to ``now`` (nanoseconds)."""
        self._queue.clear()
        if self.time is not None:
            self.time = now

    def clear(self) -> None:
        """Clear the queue and the history."""
        self._queue.clear()
        self._history.clear()

    def _use(self, measurement: Measurement) -> None:
        if self.time is None:
            self.ekf.start(measurement)
            self.time = measurement.time
        else:
            if measurement.time > self.time:
                self._predict(measurement.time)
            self.num_rejected += not self.ekf.correct(measurement)
        if self._history_length:
            self._history.append(_Past(measurement, self.time, self.ekf.state.copy(), self.ekf.covariance.copy()))

    def _predict(self, time: int) -> None:
        seconds = (time - (self.time or 0)) * 1e-9
        self.ekf.predict(seconds if seconds <= MAX_STEP else CLOCK_ERROR_STEP, self.control, time)
        self.time = time

    def _go_back(self, time: int) -> bool:
        """Return to the last state before a time, and put the measurements since then back into the queue.

        Returns whether the history goes back that far.
        """
        if not self._history or self._history[0].time >= time:
            return False
        while self._history[-1].time >= time:
            measurement = self._history.pop().measurement
            heapq.heappush(self._queue, (measurement.time, -next(self._numbers), measurement))
        last = self._history[-1]
        self.time = last.time
        self.ekf.state, self.ekf.covariance = last.state.copy(), last.covariance.copy()
        return True

    def _forget(self, time: int) -> None:
        # Keep one state that is older than the history, so that the filter can return to it for a late measurement.
        while len(self._history) > 1 and self._history[1].time < time:
            self._history.popleft()
