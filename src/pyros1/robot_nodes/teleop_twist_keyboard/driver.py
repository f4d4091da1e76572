"""Converts pressed keys to a robot's velocity (no I/O)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Velocity(NamedTuple):
    """A velocity: forwards, to the left and upwards in m/s, and the turning rate in rad/s, to the left."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    turning: float = 0.0


STOPPED = Velocity()
_DIRECTIONS = {
    "u": Velocity(x=1, turning=1),
    "i": Velocity(x=1),
    "o": Velocity(x=1, turning=-1),
    "j": Velocity(turning=1),
    "l": Velocity(turning=-1),
    "m": Velocity(x=-1, turning=-1),
    ",": Velocity(x=-1),
    ".": Velocity(x=-1, turning=1),
    "U": Velocity(x=1, y=1),
    "I": Velocity(x=1),
    "O": Velocity(x=1, y=-1),
    "J": Velocity(y=1),
    "L": Velocity(y=-1),
    "M": Velocity(x=-1, y=1),
    "<": Velocity(x=-1),
    ">": Velocity(x=-1, y=-1),
    "t": Velocity(z=1),
    "b": Velocity(z=-1),
}
"""Key -> direction. With shift, the robot moves sideways instead of turning."""
_FACTORS = {"q": (1.1, 1.1), "z": (0.9, 0.9), "w": (1.1, 1.0), "x": (0.9, 1.0), "e": (1.0, 1.1), "c": (1.0, 0.9)}
"""Key -> factors for the speed and for the turning rate."""


@dataclass
class Driver:
    """The velocity commanded by the pressed keys.

    Attributes:
        speed: the speed in m/s while a key for moving is in effect.
        turn: the turning rate in rad/s while a key for turning is in effect.
        speed_limit, turn_limit: the limits up to which keys can raise them.
        direction: the last key's direction, as multiples of speed and turning rate.
    """

    speed: float = 0.5
    turn: float = 1.0
    speed_limit: float = 1000.0
    turn_limit: float = 1000.0
    direction: Velocity = STOPPED

    @property
    def velocity(self) -> Velocity:
        """The velocity to publish."""
        x, y, z, turning = self.direction
        return Velocity(x * self.speed, y * self.speed, z * self.speed, turning * self.turn)

    def press(self, key: str) -> list[str]:
        """Handle a key; return the lines to show. A key without a meaning stops the robot."""
        factors = _FACTORS.get(key)
        if factors is None:
            self.direction = _DIRECTIONS.get(key, STOPPED)
            return []
        self.speed = min(self.speed_limit, self.speed * factors[0])
        self.turn = min(self.turn_limit, self.turn * factors[1])
        lines = ["Linear speed limit reached!"] if self.speed == self.speed_limit else []
        lines += ["Angular speed limit reached!"] if self.turn == self.turn_limit else []
        return [*lines, self.describe()]

    def describe(self) -> str:
        """Return a line with the speed and turning rate."""
        return f"currently:\tspeed {self.speed:g}\tturn {self.turn:g}"
