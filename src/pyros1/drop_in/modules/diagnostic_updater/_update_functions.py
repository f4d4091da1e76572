"""Tasks that most nodes need."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import rospy

from diagnostic_updater._diagnostic_updater import DiagnosticTask
from pyros1.diagnostics import Frequency, TimeStamps, alive
from pyros1.drop_in.module_attributes import module_getattr

__getattr__ = module_getattr("diagnostic_updater._update_functions")


class FrequencyStatusParam:
    """The expected frequency of an event.

    Args:
        freq_bound: a dictionary with the expected "min" and (optional) "max" in Hz, which may be changed later.
        tolerance: fraction by which the frequency may lie outside this range: 0.1 is 10 %.
        window_size: number of updates over which events are counted.
    """

    def __init__(self, freq_bound: Mapping[str, float], tolerance: float = 0.1, window_size: int = 5) -> None:
        self.freq_bound = freq_bound
        self.tolerance = tolerance
        self.window_size = window_size


class FrequencyStatus(DiagnosticTask):
    """Monitors whether an event has the expected frequency.

    Args:
        params: a `FrequencyStatusParam`.
        name: the task's name.
    """

    def __init__(self, params: Any, name: str = "FrequencyStatus") -> None:
        super().__init__(name)
        self.params = params
        self._frequency = Frequency(rospy.Time.now, window=params.window_size)

    def clear(self) -> None:
        """Restart counting."""
        self._frequency.clear()

    def tick(self) -> None:
        """Count an event."""
        self._frequency.tick()

    def run(self, stat: Any) -> Any:
        """Fill in a `DiagnosticStatusWrapper` and return it."""
        bounds = self.params.freq_bound
        self._frequency.minimum, self._frequency.maximum = bounds["min"], bounds.get("max")
        self._frequency.tolerance = self.params.tolerance
        self._frequency.run(stat)
        return stat


class TimeStampStatusParam:
    """The acceptable age of time stamps.

    Args:
        min_acceptable, max_acceptable: the age in seconds; negative for times in the future.
    """

    def __init__(self, min_acceptable: float = -1, max_acceptable: float = 5) -> None:
        self.min_acceptable = min_acceptable
        self.max_acceptable = max_acceptable


class TimeStampStatus(DiagnosticTask):
    """Monitors whether messages' time stamps are close to the times at which they arrive.

    Args:
        params: a `TimeStampStatusParam`.
        name: the task's name.
    """

    def __init__(self, params: Any = TimeStampStatusParam(), name: str = "Timestamp Status") -> None:  # noqa: B008
        super().__init__(name)
        self.params = params
        self._stamps = TimeStamps(rospy.Time.now)

    def tick(self, stamp: Any) -> None:
        """Record a time stamp, as rospy.Time or in seconds."""
        self._stamps.tick(stamp)

    def run(self, stat: Any) -> Any:
        """Fill in a `DiagnosticStatusWrapper` and return it."""
        self._stamps.earliest, self._stamps.latest = self.params.min_acceptable, self.params.max_acceptable
        self._stamps.run(stat)
        return stat


class Heartbeat(DiagnosticTask):
    """Reports that the node is alive."""

    def __init__(self) -> None:
        super().__init__("Heartbeat")

    def run(self, stat: Any) -> Any:
        """Fill in a `DiagnosticStatusWrapper` and return it."""
        alive(stat)
        return stat
