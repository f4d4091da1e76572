"""Motion model of differential-drive robots (no I/O).

Arrays have a row for each robot. Speeds are in m/s and rad/s.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Drive:
    """The wheels of a robot, and how accurate they are.

    Attributes:
        separation: distance between the wheels in m.
        wheel_radius: in m.
        max_speed, max_turn: the robot's maximum speeds.
        acceleration, turn_acceleration: how fast the speeds change, in m/s² and rad/s².
        slip: average fraction of the distance that wheels lose; each wheel has its own, from 0 to twice the average.
        noise: standard deviation, in m, of the distance that a wheel moves after 1 m.
    """

    separation: float = 0.29
    wheel_radius: float = 0.08
    max_speed: float = 1.0
    max_turn: float = 3.0
    acceleration: float = 2.0
    turn_acceleration: float = 6.0
    slip: float = 0.01
    noise: float = 0.005

    def speed_up(self, speeds: Floats, wanted: Floats, dt: float) -> Floats:
        """Return the speeds after `dt` seconds.

        Args:
            speeds: current speeds and turn rates; shape (n, 2).
            wanted: commanded speeds and turn rates.
            dt: seconds.
        """
        highest = np.array([self.max_speed, self.max_turn])
        change = np.array([self.acceleration, self.turn_acceleration]) * dt
        wanted = np.clip(wanted, -highest, highest)
        missing = wanted - speeds
        # Set the wanted speed instead of adding the difference, so that a robot stops exactly.
        return np.where(np.abs(missing) <= change, wanted, speeds + np.copysign(change, missing))

    def to_wheels(self, speeds: Floats) -> Floats:
        """Convert distances or speeds of robots to those of their left and right wheels in m or m/s; shape (n, 2)."""
        forward, turn = speeds[:, 0], speeds[:, 1] * self.separation / 2
        return np.stack([forward - turn, forward + turn], axis=1)

    def from_wheels(self, wheels: Floats) -> Floats:
        """Convert distances or speeds of wheels to those of the robots."""
        left, right = wheels[:, 0], wheels[:, 1]
        return np.stack([(left + right) / 2, (right - left) / self.separation], axis=1)

    def slipped(self, ways: Floats, slips: Floats, random: np.random.Generator) -> Floats:
        """Return the distances by which the wheels move the robots, after slip and noise; shape (n, 2).

        Args:
            ways: how far the wheels roll, in m; shape (n, 2).
            slips: the fraction of the distance that each wheel loses.
            random: for the noise.
        """
        moved: Floats = ways * (1 - slips) + random.standard_normal(ways.shape) * self.noise * np.sqrt(np.abs(ways))
        return moved

    def draw_slips(self, num_robots: int, random: np.random.Generator) -> Floats:
        """Return a random slip for each wheel, with shape (num_robots, 2)."""
        return random.uniform(0, 2 * self.slip, (num_robots, 2))


def move(poses: Floats, ways: Floats) -> Floats:
    """Return poses after moving along arcs.

    Args:
        poses: x and y in m, heading in radians; shape (n, 3).
        ways: length of the arc in m, and change of heading along it in radians; shape (n, 2).
    """
    length, turn = ways[:, 0], ways[:, 1]
    # The arc's chord, whose direction is halfway between the headings at its ends.
    chord = length * np.sinc(turn / (2 * np.pi))
    middle = poses[:, 2] + turn / 2
    steps = np.stack([chord * np.cos(middle), chord * np.sin(middle), turn], axis=1)
    moved = poses + steps
    moved[:, 2] = (moved[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return moved
