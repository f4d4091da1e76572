"""A turtle: its pose, movement and pen (https://wiki.ros.org/turtlesim)."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, floor, hypot, pi, sin
from typing import NamedTuple

PIXELS = 500
"""Width and height of the picture in pixels."""
PIXELS_PER_UNIT = 45
SIZE = 11.088889122009277
"""Width and height of the world, in the units of poses; x is to the right, y upwards.

(PIXELS - 1) / PIXELS_PER_UNIT as a 32-bit number, calculated as in stock.
"""
PERIOD = 0.016
"""Duration of a step in seconds."""
COMMAND_TIMEOUT = 1.0
"""Seconds for which a command remains in effect."""


class Pen(NamedTuple):
    """The pen that a turtle draws with.

    Attributes:
        red, green, blue: the pen's colour, 0 to 255.
        width: the width in pixels, at least 1.
        off: whether the pen draws nothing.
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
        forward, sideways: speeds along the heading, and at right angles to it, to the left, in units per second.
        turning: angular speed in radians per second.
        pen: the turtle's pen.
        commanded_at: time of the last command in seconds, by the clock used for `step`.
    """

    x: float = SIZE / 2
    y: float = SIZE / 2
    theta: float = 0.0
    forward: float = 0.0
    sideways: float = 0.0
    turning: float = 0.0
    pen: Pen = field(default_factory=Pen)
    commanded_at: float = float("-inf")

    @property
    def position(self) -> Position:
        """The turtle's position."""
        return Position(self.x, self.y)

    @property
    def speed(self) -> float:
        """The turtle's speed in units per second; never negative."""
        return hypot(self.forward, self.sideways)

    def command(self, forward: float, sideways: float, turning: float, now: float) -> None:
        """Set the speeds that apply from the next step on; see the attributes."""
        self.forward, self.sideways, self.turning, self.commanded_at = forward, sideways, turning, now

    def teleport_absolute(self, x: float, y: float, theta: float) -> None:
        """Move to a position. If it is outside the walls (never above the upper wall), the next step corrects it."""
        self.x, self.y, self.theta = x, min(y, SIZE), theta

    def teleport_relative(self, distance: float, angle: float) -> None:
        """Turn by an angle (radians), then move forward by a distance (units) at once."""
        self.theta += angle
        self.x += cos(self.theta) * distance
        self.y += sin(self.theta) * distance

    def step(self, now: float, seconds: float = PERIOD) -> Position | None:
        """Move for a number of seconds: turn first, then move forward.

        Args:
            now: the current time in seconds, by the same clock as in `command`, to find out whether the command still
                applies.
            seconds: duration of the movement.

        Returns:
            The position that the turtle would have without walls; None if it did not hit a wall.
        """
        if now - self.commanded_at > COMMAND_TIMEOUT:
            self.forward = self.sideways = self.turning = 0.0
        self.theta = normalize_angle(self.theta + self.turning * seconds)
        ahead, left = self.forward * seconds, self.sideways * seconds
        requested = Position(
            self.x + cos(self.theta) * ahead - sin(self.theta) * left,
            self.y + sin(self.theta) * ahead + cos(self.theta) * left,
        )
        self.x, self.y = min(max(requested.x, 0.0), SIZE), min(max(requested.y, 0.0), SIZE)
        return None if requested == self.position else requested


def normalize_angle(angle: float) -> float:
    """Return an equivalent angle from -pi to pi, in radians."""
    return angle - 2 * pi * floor((angle + pi) / (2 * pi))
