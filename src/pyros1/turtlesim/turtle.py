"""A turtle: where it is, how it moves, and its pen (https://wiki.ros.org/turtlesim)."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, floor, hypot, pi, sin
from typing import NamedTuple

PIXELS = 500
"""Width and height of the picture."""
PIXELS_PER_UNIT = 45
SIZE = 11.088889122009277
"""Width and height of the world, in the units of poses; x is to the right, y upwards.

(PIXELS - 1) / PIXELS_PER_UNIT as a 32-bit number, as stock calculates it.
"""
PERIOD = 0.016
"""Seconds of a step."""
COMMAND_TIMEOUT = 1.0
"""Seconds for which a command holds."""


class Pen(NamedTuple):
    """What a turtle draws with.

    Attributes:
        red, green, blue: its colour, 0 to 255.
        width: in pixels, at least 1.
        off: whether it draws nothing.
    """

    red: int = 179
    green: int = 184
    blue: int = 255
    width: int = 3
    off: bool = False


class Position(NamedTuple):
    """A point of the world, in its units."""

    x: float
    y: float


@dataclass
class Turtle:
    """A turtle.

    Attributes:
        x, y: where it is, in units.
        theta: where it looks, in radians: 0 is to the right, and angles grow to the left.
        forward, sideways: speeds along where it looks, and to the left of that, in units per second.
        turning: angular speed in radians per second.
        pen: what it draws with.
        commanded: when the last command came, in seconds of the clock of `step`.
    """

    x: float = SIZE / 2
    y: float = SIZE / 2
    theta: float = 0.0
    forward: float = 0.0
    sideways: float = 0.0
    turning: float = 0.0
    pen: Pen = field(default_factory=Pen)
    commanded: float = float("-inf")

    @property
    def position(self) -> Position:
        """Where it is."""
        return Position(self.x, self.y)

    @property
    def speed(self) -> float:
        """How fast it goes, in units per second; never negative."""
        return hypot(self.forward, self.sideways)

    def command(self, forward: float, sideways: float, turning: float, now: float) -> None:
        """Move with these speeds from the next step on, see the attributes."""
        self.forward, self.sideways, self.turning, self.commanded = forward, sideways, turning, now

    def teleport_absolute(self, x: float, y: float, theta: float) -> None:
        """Be elsewhere. Beyond the walls it is until the next step only, and never above the upper one."""
        self.x, self.y, self.theta = x, min(y, SIZE), theta

    def teleport_relative(self, distance: float, angle: float) -> None:
        """Turn by an angle (radians), then be a distance (units) further on."""
        self.theta += angle
        self.x += cos(self.theta) * distance
        self.y += sin(self.theta) * distance

    def step(self, now: float, seconds: float = PERIOD) -> Position | None:
        """Move for a while: turn first, then go.

        Args:
            now: seconds of any clock, for the age of the command.
            seconds: how long.

        Returns:
            Where it would be now if there were no wall; None if there was none on its way.
        """
        if now - self.commanded > COMMAND_TIMEOUT:
            self.forward = self.sideways = self.turning = 0.0
        self.theta = normal(self.theta + self.turning * seconds)
        ahead, left = self.forward * seconds, self.sideways * seconds
        requested = Position(
            self.x + cos(self.theta) * ahead - sin(self.theta) * left,
            self.y + sin(self.theta) * ahead + cos(self.theta) * left,
        )
        self.x, self.y = min(max(requested.x, 0.0), SIZE), min(max(requested.y, 0.0), SIZE)
        return None if requested == self.position else requested


def normal(angle: float) -> float:
    """Return an angle, in radians, as one from -pi to pi."""
    return angle - 2 * pi * floor((angle + pi) / (2 * pi))
