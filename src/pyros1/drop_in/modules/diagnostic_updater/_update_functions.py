"""Tasks that most nodes need."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import rospy

from diagnostic_updater._diagnostic_updater import DiagnosticTask
from pyros1.diagnostics import Frequency, TimeStamps, alive
from pyros1.drop_in.missing import missing

__getattr__ = missing("diagnostic_updater._update_functions")


class FrequencyStatusParam:
    """How often something should happen.

    Args:
        freq_bound: the frequencies "min" and "max" in Hz, in a dictionary that may change later; "max" may lack.
        tolerance: share by which the frequency may be outside of them: 0.1 is 10 %.
        window_size: number of updates over which is counted.
    """

    def __init__(self, freq_bound: Mapping[str, float], tolerance: float = 0.1, window_size: int = 5) -> None:
        self.freq_bound = freq_bound
        self.tolerance = tolerance
        self.window_size = window_size


class FrequencyStatus(DiagnosticTask):
    """Tells whether something happens as often as it should.

    Args:
        params: a `FrequencyStatusParam`.
        name: the task's name.
    """

    def __init__(self, params: Any, name: str = "FrequencyStatus") -> None:
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
        """Fill a `DiagnosticStatusWrapper`, and return it."""
        bounds = self.params.freq_bound
        self._frequency.minimum, self._frequency.maximum = bounds["min"], bounds.get("max")
        self._frequency.tolerance = self.params.tolerance
        self._frequency.run(stat)
        return stat


class TimeStampStatusParam:
    """How old time stamps may be.

    Args:
        min_acceptable, max_acceptable: in seconds; a negative number is in the future.
    """

    def __init__(self, min_acceptable: float = -1, max_acceptable: float = 5) -> None:
        self.min_acceptable = min_acceptable
        self.max_acceptable = max_acceptable


class TimeStampStatus(DiagnosticTask):
    """Tells whether time stamps are near the time at which their messages come.

    Args:
        params: a `TimeStampStatusParam`.
        name: the task's name.
    """

    def __init__(self, params: Any = TimeStampStatusParam(), name: str = "Timestamp Status") -> None:  # noqa: B008
        super().__init__(name)
        self.params = params
        self._stamps = TimeStamps(rospy.Time.now)

    def tick(self, stamp: Any) -> None:
        """Take a time stamp, as rospy.Time or in seconds."""
        self._stamps.tick(stamp)

    def run(self, stat: Any) -> Any:
        """Fill a `DiagnosticStatusWrapper`, and return it."""
        self._stamps.earliest, self._stamps.latest = self.params.min_acceptable, self.params.max_acceptable
        self._stamps.run(stat)
        return stat


class Heartbeat(DiagnosticTask):
    """Says that the node is alive."""

    def __init__(self) -> None:
        super().__init__("Heartbeat")

    def run(self, stat: Any) -> Any:
        """Fill a `DiagnosticStatusWrapper`, and return it."""
        alive(stat)
        return stat
