"""The inputs and outputs of IMU filters, and the time between messages."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic, NamedTuple, TypeVar

from pyros1.ground.errors import Error
from pyros1.tf.rotation import Quaternion, Vector

SettingsType = TypeVar("SettingsType")
LIMIT = 1e9
"""Components that are not smaller than this in any unit are garbage."""
MAX_PAUSE = 1.0
"""Seconds between messages after which the rotation in between is not known."""


class UnusableReadingError(Error):
    """The filter cannot use a message."""


class Reading(NamedTuple):
    """What an IMU measures, in its frame.

    Attributes:
        rates: angular velocities in rad/s.
        acceleration: in m/s²; at rest it points up.
        field: magnetic field in any unit; None if it is not known.
    """

    rates: Vector
    acceleration: Vector
    field: Vector | None = None

    def check(self) -> None:
        """Check that the rates and the acceleration are usable.

        Raises:
            UnusableReadingError: they are not.
        """
        for name, vector in (("angular velocity", self.rates), ("linear acceleration", self.acceleration)):
            if not is_usable(vector):
                raise UnusableReadingError(f"the {name} is not finite: {vector}")


class Estimate(NamedTuple):
    """The estimate of a filter.

    Attributes:
        orientation: of the IMU in the world frame.
        rates, acceleration: those of the reading, without what the filter removes.
        steady: whether the IMU is at rest, for filters that need to know.
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
        """Begin again with the next reading. The bias of the gyroscope stays the same."""
        self._orientation = None

    @abstractmethod
    def update(self, reading: Reading, seconds: float) -> Estimate | None:
        """Return the orientation after a reading; None if the filter needs another one to begin.

        Args:
            reading: a reading that has been checked.
            seconds: the time since the last reading.

        Raises:
            UnusableReadingError: the reading does not show the orientation to begin with.
        """


def is_usable(vector: Vector) -> bool:
    """Return whether all components are finite, and not absurdly large."""
    x, y, z = vector
    return abs(x) < LIMIT and abs(y) < LIMIT and abs(z) < LIMIT  # False for NaN


class TimeStep(NamedTuple):
    """The time since the previous message.

    Attributes:
        seconds: the time.
        problem: what to tell the user; empty if nothing.
        restart: whether the filter must begin again.
        ignore: whether to ignore the message.
    """

    seconds: float
    problem: str = ""
    restart: bool = False
    ignore: bool = False


class TimeSteps:
    """Measures the time between messages by their stamps.

    Args:
        constant: the seconds to return for all messages; 0.0 to use the stamps.
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
