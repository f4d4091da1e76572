"""Tasks that most nodes need."""

from __future__ import annotations

from typing import Any

import rospy

from diagnostic_updater._diagnostic_updater import *  # noqa: F403
from diagnostic_updater._diagnostic_updater import DiagnosticTask
from pyros1.diagnostics.tasks import Frequency, TimeStamps, alive


class FrequencyStatusParam:
    """How often something should happen.

    Attributes:
        freq_bound: in Hz, under "min" and "max"; may change at any time.
        tolerance: share by which the frequency may be outside of these. window_size: runs over which is counted.
    """

    def __init__(self, freq_bound: dict[str, float], tolerance: float = 0.1, window_size: int = 5) -> None:
        self.freq_bound = freq_bound
        self.tolerance = tolerance
        self.window_size = window_size


class FrequencyStatus(DiagnosticTask):
    """Tells whether something happens as often as it should."""

    def __init__(self, params: FrequencyStatusParam, name: str = "FrequencyStatus") -> None:
        super().__init__(name)
        self.params = params
        self._frequency = Frequency(rospy.Time.now, window=params.window_size)

    def clear(self) -> None:
        """Begin to count anew."""
        self._frequency.clear()

    def tick(self) -> None:
        """Count an event."""
        self._frequency.tick()

    def run(self, stat: Any) -> Any:
        """Fill a status, and return it."""
        bound, this = self.params.freq_bound, self._frequency
        this.minimum, this.maximum, this.tolerance = bound["min"], bound["max"], self.params.tolerance
        this.run(stat)
        return stat


class TimeStampStatusParam:
    """How old messages may be when they come, in seconds; negative numbers are in the future."""

    def __init__(self, min_acceptable: float = -1, max_acceptable: float = 5) -> None:
        self.max_acceptable = max_acceptable
        self.min_acceptable = min_acceptable


_USUAL = TimeStampStatusParam()


class TimeStampStatus(DiagnosticTask):
    """Tells whether the time stamps of messages are near the time at which they come."""

    def __init__(self, params: TimeStampStatusParam = _USUAL, name: str = "Timestamp Status") -> None:
        super().__init__(name)
        self.params = params
        self._stamps = TimeStamps(rospy.Time.now)

    def tick(self, stamp: Any) -> None:
        """Take a stamp: a Time, or seconds as a float."""
        self._stamps.tick(stamp)

    def run(self, stat: Any) -> Any:
        """Fill a status, and return it."""
        self._stamps.earliest, self._stamps.latest = self.params.min_acceptable, self.params.max_acceptable
        self._stamps.run(stat)
        return stat


class Heartbeat(DiagnosticTask):
    """Tells that the node is alive."""

    def __init__(self) -> None:
        super().__init__("Heartbeat")

    def run(self, stat: Any) -> Any:
        """Fill a status, and return it."""
        alive(stat)
        return stat
