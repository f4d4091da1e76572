"""A turtle's state and movement, calculated as in stock turtlesim (https://wiki.ros.org/turtlesim)."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, floor, hypot, pi, sin
from typing import NamedTuple

PICTURE_SIZE = 500
"""Width and height of the drawing in pixels."""
PIXELS_PER_UNIT = 45
WORLD_SIZE = 11.088889122009277
"""Width and height of the world, in the units of poses; x points to the right, y upwards.

This is (PICTURE_SIZE - 1) / PIXELS_PER_UNIT as a 32-bit float, calculated as in stock ROS.
"""
STEP_PERIOD = 0.016
"""Simulated seconds per step."""
COMMAND_TIMEOUT = 1.0
"""Seconds for which a command remains in effect."""


class Pen(NamedTuple):
    """The pen with which a turtle draws.

    Attributes:
        red, green, blue: the pen's colour, each from 0 to 255.
        width: the line's width in pixels, at least 1.
        off: whether the pen is off, so that nothing is drawn.
    """

    red: int = 179
    green: int = 184
    blue: int = 255
    width: int = 3
    off: bool = False


class Position(NamedTuple):
    """A point in the world, in units."""

    x: float
    y: float


@dataclass
class Turtle:
    """A turtle's pose, speeds and pen.

    Attributes:
        x, y: position in units.
        theta: heading in radians: 0 is to the right; angles increase counterclockwise.
        forward, sideways: speeds in the direction of the heading, and to the left of it, in units per second.
        turning: angular speed in radians per second.
        pen: the turtle's pen.
        commanded_at: time of the last command in seconds, by the same clock as in `step`.
    """

    x: float = WORLD_SIZE / 2
    y: float = WORLD_SIZE / 2
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
        """The turtle's speed in units per second, regardless of its direction."""
        return hypot(self.forward, self.sideways)

    def command(self, forward: float, sideways: float, turning: float, now: float) -> None:
        """Set the speeds that apply from the next step on; ``now`` is the time in seconds."""
        self.forward, self.sideways, self.turning, self.commanded_at = forward, sideways, turning, now

    def teleport_absolute(self, x: float, y: float, theta: float) -> None:
        """Move to a pose at once.

        A position beyond the upper wall is corrected immediately; one beyond another wall, in the next step.
        """
        self.x, self.y, self.theta = x, min(y, WORLD_SIZE), theta

    def teleport_relative(self, distance: float, angle: float) -> None:
        """At once, turn by an angle (radians), and then move forward by a distance (units)."""
        self.theta += angle
        self.x += cos(self.theta) * distance
        self.y += sin(self.theta) * distance

    def step(self, now: float, seconds: float = STEP_PERIOD) -> Position | None:
        """Move for a number of seconds: first turn, then move straight on.

        Args:
            now: the current time in seconds, by the same clock as in `command`. The last command applies for
                `COMMAND_TIMEOUT` seconds.
            seconds: the movement's duration.

        Returns:
            The position that the turtle would have reached without walls; None if it has not hit a wall.
        """
        if now - self.commanded_at > COMMAND_TIMEOUT:
            self.forward = self.sideways = self.turning = 0.0
        self.theta = normalize_angle(self.theta + self.turning * seconds)
        ahead, left = self.forward * seconds, self.sideways * seconds
        requested = Position(
            self.x + cos(self.theta) * ahead - sin(self.theta) * left,
            self.y + sin(self.theta) * ahead + cos(self.theta) * left,
        )
        self.x, self.y = min(max(requested.x, 0.0), WORLD_SIZE), min(max(requested.y, 0.0), WORLD_SIZE)
        return None if requested == self.position else requested


def normalize_angle(angle: float) -> float:
    """Return the equivalent angle between -pi and pi, in radians."""
    return angle - 2 * pi * floor((angle + pi) / (2 * pi))
