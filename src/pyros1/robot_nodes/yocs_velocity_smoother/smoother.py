"""Limits the speed and the acceleration of a robot that drives forward and turns."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import IntEnum
from math import inf
from statistics import median
from typing import NamedTuple

_PERIODS = 5
_DEFAULT_PERIOD = 0.1
_MAX_SILENCE = 0.5
_MAX_DIFFERENCE = (0.2, 2.0)
"""If the robot's velocity differs more from the last command, in m/s or rad/s, the command is distrusted."""


class Velocity(NamedTuple):
    """A forward speed in m/s, and a turning speed in rad/s."""

    forward: float
    turning: float


STANDSTILL = Velocity(0.0, 0.0)


class Feedback(IntEnum):
    """The source of the robot's current velocity."""

    NONE = 0
    ODOMETRY = 1
    COMMANDS = 2


@dataclass(frozen=True)
class Limits:
    """Limits of a robot.

    Attributes:
        speed: the maximum speeds.
        acceleration: the maximum accelerations in m/s² and rad/s².
        decel_factor: the maximum decelerations as a multiple of the accelerations. A maximum of 0 means no limit.
    """

    speed: Velocity
    acceleration: Velocity
    decel_factor: float = 1.0


class Smoother:
    """Follows commands within the limits.

    Both speeds change in proportion, so that the robot stays on the commanded curve while it accelerates. When the
    input has been silent for three of its periods, at most 0.5 s, the robot is stopped within the limits. Times are in
    seconds.

    With feedback, a change starts from the robot's velocity instead of the last command if they differ a lot, since
    something else then drives the robot, or it cannot follow. Feedback older than 0.5 s is ignored: if it ended while
    the robot was fast, the robot could otherwise never be stopped.

    Args:
        limits: the limits; they may be replaced at any time.
        period: the time between two calls of `step`.
        feedback: the source of the velocities for `robot_moves`.

    Attributes:
        limits: the limits.
    """

    def __init__(self, limits: Limits, period: float, feedback: Feedback = Feedback.NONE) -> None:
        self.limits = limits
        self._period = period
        self._feedback = feedback
        self._target = self._last = STANDSTILL
        self._robot = (STANDSTILL, -inf)  # its last known velocity, and when that was known
        self._is_active = False
        self._received: float | None = None
        self._periods: deque[float] = deque(maxlen=_PERIODS)

    def command(self, velocity: Velocity, now: float) -> None:
        """Handle a command."""
        if self._received is not None:
            self._periods.append(now - self._received)
        self._received = now
        self._is_active = True
        self._target = Velocity(*map(_clamp, velocity, self.limits.speed))

    def robot_moves(self, velocity: Velocity, now: float) -> None:
        """Record the robot's current velocity."""
        self._robot = (velocity, now)

    def on_stopped(self) -> None:
        """Record that the robot has been stopped immediately; it stands still until the next command."""
        self._target = self._last = STANDSTILL
        self._is_active = False

    def step(self, now: float) -> Velocity | None:
        """Return the velocity to command now; None if the robot stands still and there is no input."""
        if self._is_active and self._is_silent(now):
            self._is_active = False
            self._target = STANDSTILL
        robot, known_at = self._robot
        has_feedback = self._feedback != Feedback.NONE and 0 <= now - known_at <= _MAX_SILENCE
        if has_feedback and self._is_active and self._differs(robot):
            self._last = Velocity(*map(_clamp, robot, self.limits.speed))
        if self._target == self._last:
            return self._last if self._is_active else None
        change = Velocity(*(target - last for target, last in zip(self._target, self._last, strict=True)))
        # With odometry, a robot that still rolls in the opposite direction is known to be braking.
        rolling = robot if has_feedback and self._feedback == Feedback.ODOMETRY else STANDSTILL
        fraction = min(map(self._possible_fraction, change, self._target, rolling, self.limits.acceleration))
        if fraction == 1.0:
            self._last = self._target
        else:
            self._last = Velocity(*(last + fraction * part for last, part in zip(self._last, change, strict=True)))
        return self._last

    def _is_silent(self, now: float) -> bool:
        """Return whether the last command is too old, or time has jumped back since it arrived."""
        # Until some periods are known, assume commands at 10 Hz.
        usual = median(self._periods) if len(self._periods) > _PERIODS // 2 else _DEFAULT_PERIOD
        limit = min(max(3 * usual, self._period), _MAX_SILENCE)
        return self._received is None or not 0 <= now - self._received <= limit

    def _differs(self, robot: Velocity) -> bool:
        """Return whether the robot's velocity differs a lot from the last command."""
        return any(
            abs(speed - last) > limit for speed, last, limit in zip(robot, self._last, _MAX_DIFFERENCE, strict=True)
        )

    def _possible_fraction(self, change: float, target: float, rolling: float, acceleration: float) -> float:
        """Return the fraction of a speed's change that is possible within one period, at most 1."""
        limit = acceleration * self._period
        if change * target <= 0 or rolling * target < 0:
            limit *= self.limits.decel_factor
            if limit == 0:  # the robot could never be stopped
                return 1.0
        return min(1.0, limit / abs(change)) if change else 1.0


def _clamp(value: float, limit: float) -> float:
    return max(-limit, min(limit, value))
