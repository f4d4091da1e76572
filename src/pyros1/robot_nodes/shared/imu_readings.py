"""The inputs and outputs of IMU filters, and the time between messages."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, NamedTuple, TypeVar

from pyros1.ground.errors import Error
from pyros1.tf.rotation import Quaternion, Vector

SettingsType = TypeVar("SettingsType")
LIMIT = 1e9
"""Components of this size or more, in whatever unit, are garbage."""
MAX_PAUSE = 1.0
"""Seconds between messages beyond which the rotation in between is unknown."""


class UnusableReadingError(Error):
    """The filter cannot use a message."""


class Reading(NamedTuple):
    """An IMU's measurements in its own frame.

    Attributes:
        rates: angular velocities in rad/s.
        acceleration: acceleration in m/s²; at rest it points up.
        field: magnetic field in any unit; None if it is unknown.
    """

    rates: Vector
    acceleration: Vector
    field: Vector | None = None

    def check(self) -> None:
        """Check that the rates and the acceleration are usable.

        Raises:
            UnusableReadingError: a component is not finite, or absurdly large.
        """
        for name, vector in (("angular velocity", self.rates), ("linear acceleration", self.acceleration)):
            if not is_usable(vector):
                raise UnusableReadingError(f"the {name} is not finite: {vector}")


class Estimate(NamedTuple):
    """A filter's estimate.

    Attributes:
        orientation: the IMU's orientation in the world frame.
        rates, acceleration: the reading's values, without what the filter removes, such as a bias or gravity.
        steady: whether the IMU is at rest, if the filter detects that.
    """

    orientation: Quaternion
    rates: Vector
    acceleration: Vector
    steady: bool = False


class OrientationFilter(ABC, Generic[SettingsType]):
    """Estimates the orientation of an IMU.

    Args:
        settings: the parameters.
    """

    def __init__(self, settings: SettingsType) -> None:
        self._settings = settings
        self._orientation: Quaternion | None = None
        self._bias: Vector = (0.0, 0.0, 0.0)  # of the gyroscope

    def reset(self) -> None:
        """Start again with the next reading. The gyroscope's bias is kept."""
        self._orientation = None

    @abstractmethod
    def update(self, reading: Reading, seconds: float) -> Estimate | None:
        """Return the orientation after a reading; None if the filter needs another reading to start.

        Args:
            reading: a reading that has been checked.
            seconds: the time since the last reading.

        Raises:
            UnusableReadingError: the initial orientation cannot be computed from this reading.
        """


def is_usable(vector: Vector) -> bool:
    """Return whether all components are finite, and not absurdly large."""
    x, y, z = vector
    return abs(x) < LIMIT and abs(y) < LIMIT and abs(z) < LIMIT  # False for NaN


class TimeStep(NamedTuple):
    """The time since the previous message.

    Attributes:
        seconds: the time.
        problem: a message for the user, or empty.
        restart: whether the filter must start again.
        ignore: whether to ignore the message.
    """

    seconds: float
    problem: str = ""
    restart: bool = False
    ignore: bool = False


class TimeSteps:
    """Measures the time between messages by their stamps.

    Args:
        constant: the time step to return for all messages, in seconds; 0.0 to use the stamps.
    """

    def __init__(self, constant: float = 0.0) -> None:
        self._constant = constant
        self._last: int | None = None

    def next(self, stamp: int) -> TimeStep:
        """Return the time step from the previous message to this one.

        Args:
            stamp: the message's time stamp in nanoseconds.
        """
        if self._constant > 0.0:
            return TimeStep(self._constant)
        last, self._last = self._last, stamp
        if stamp == 0:
            return TimeStep(
                0.0, "IMU messages have no time stamp: set the parameter constant_dt to their period in seconds"
            )
        seconds = 0.0 if last is None else (stamp - last) * 1e-9
        if seconds > MAX_PAUSE and last:
            return TimeStep(0.0, f"no IMU messages for {seconds:.1f} s: rotations in this time are not known")
        if seconds < -MAX_PAUSE:
            return TimeStep(0.0, f"time has jumped back by {-seconds:.1f} s: the filter starts again", restart=True)
        if seconds < 0.0:
            self._last = last
            return TimeStep(
                0.0, f"an IMU message is ignored, since it is {-seconds:.3f} s older than the last", ignore=True
            )
        return TimeStep(seconds if last else 0.0)
