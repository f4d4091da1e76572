"""A turtle: its pose, movement and pen (https://wiki.ros.org/turtlesim)."""

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
"""Duration of a step in seconds."""
COMMAND_TIMEOUT = 1.0
"""Seconds for which a command remains in effect."""


class Pen(NamedTuple):
    """The pen that a turtle draws with.

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
    """A point in the world, in world units."""

    x: float
    y: float


@dataclass
class Turtle:
    """A turtle.

    Attributes:
        x, y: position in units.
        theta: heading in radians: 0 is to the right, and angles increase to the left.
        forward, sideways: speeds along its heading, and to the left of that, in units per second.
        turning: angular speed in radians per second.
        pen: its pen.
        commanded: time of the last command, in seconds of the clock of `step`.
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
        """Its position."""
        return Position(self.x, self.y)

    @property
    def speed(self) -> float:
        """Its speed in units per second; never negative."""
        return hypot(self.forward, self.sideways)

    def command(self, forward: float, sideways: float, turning: float, now: float) -> None:
        """Set the speeds from the next step on, see the attributes."""
        self.forward, self.sideways, self.turning, self.commanded = forward, sideways, turning, now

    def teleport_absolute(self, x: float, y: float, theta: float) -> None:
        """Move to a position. It stays outside the walls only until the next step, and never above the upper one."""
        self.x, self.y, self.theta = x, min(y, SIZE), theta

    def teleport_relative(self, distance: float, angle: float) -> None:
        """Turn by an angle (radians), then move forward by a distance (units) at once."""
        self.theta += angle
        self.x += cos(self.theta) * distance
        self.y += sin(self.theta) * distance

    def step(self, now: float, seconds: float = PERIOD) -> Position | None:
        """Move for some time: turn first, then move forward.

        Args:
            now: seconds of any clock, for the age of the command.
            seconds: duration of the movement.

        Returns:
            The position it would have without walls; None if it hit none.
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
