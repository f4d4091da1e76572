"""Simulates sensors: laser scanners and IMUs (no I/O)."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from pyros1.robot_nodes.flat_world.walls import Walls

Floats = NDArray[np.float64]
GRAVITY = 9.81


@dataclass(frozen=True)
class Laser:
    """A laser scanner, whose rays are spread evenly over a full turn, beginning at the back.

    Attributes:
        rays: number of rays.
        max_range, min_range: in m.
        noise: standard deviation of distances in m.
        x, z: the scanner's position on the robot in m.
    """

    rays: int = 360
    max_range: float = 10.0
    min_range: float = 0.05
    noise: float = 0.01
    x: float = 0.1
    z: float = 0.2

    @property
    def angles(self) -> Floats:
        """The directions of the rays in radians, with shape (rays,)."""
        angles: Floats = np.linspace(-pi, pi, self.rays, endpoint=False)
        return angles


@dataclass(frozen=True)
class Imu:
    """An inertial measurement unit.

    Attributes:
        turn_noise: standard deviation of turn rates in rad/s.
        turn_bias: standard deviation of the constant offset that each robot's turn rates have.
        acceleration_noise: standard deviation of accelerations in m/s².
    """

    turn_noise: float = 0.005
    turn_bias: float = 0.002
    acceleration_noise: float = 0.05


def cast_rays(
    walls: Walls, poses: Floats, angles: Floats, offset: float, max_range: float, discs: Floats, radius: float
) -> tuple[Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """Cast rays from robots to walls and other robots.

    Args:
        walls: the walls.
        poses: the robots' x and y in m, and heading in radians; shape (m, 3).
        angles: directions of the rays from each robot, relative to its heading; shape (n,).
        offset: how far in front of a robot's centre its rays start, in m.
        max_range: maximum length of the rays in m.
        discs: x and y of all robots; shape (k, 2). A ray that starts within a disc ignores it.
        radius: the robots' radius in m.

    Returns:
        Distances in m, infinite if nothing is hit; whether a wall is hit on a side that faces along x; and whether a
        robot is hit. All have shape (m, n).
    """
    shape = (len(poses), len(angles))
    headings = poses[:, 2]
    start_x, start_y = poses[:, 0] + offset * np.cos(headings), poses[:, 1] + offset * np.sin(headings)
    directions = headings[:, None] + angles
    x, y = (np.broadcast_to(start[:, None], shape).ravel() for start in (start_x, start_y))
    distances, faces_x = walls.cast(x, y, directions.ravel(), max_range)
    distances = distances.reshape(shape)
    to_robots = _cast_to_discs(start_x, start_y, directions, max_range, discs, radius)
    return np.minimum(distances, to_robots), faces_x.reshape(shape), to_robots < distances


def _cast_to_discs(x: Floats, y: Floats, directions: Floats, max_range: float, discs: Floats, radius: float) -> Floats:
    nearest = np.full(directions.shape, np.inf)
    cosines, sines = np.cos(directions), np.sin(directions)
    for disc_x, disc_y in discs:
        away_x, away_y = disc_x - x, disc_y - y
        away = np.hypot(away_x, away_y)
        seen = np.flatnonzero((away > radius) & (away < max_range + radius))
        if not seen.size:
            continue
        along = cosines[seen] * away_x[seen, None] + sines[seen] * away_y[seen, None]
        half_chord_squared = radius**2 - (away[seen, None] ** 2 - along**2)
        distance = along - np.sqrt(np.maximum(half_chord_squared, 0))
        hit = (half_chord_squared > 0) & (along > 0) & (distance <= max_range)
        nearest[seen] = np.where(hit, np.minimum(nearest[seen], distance), nearest[seen])
    return nearest


def blur_ranges(distances: Floats, laser: Laser, noise: Floats) -> NDArray[np.float32]:
    """Return the ranges that a laser measures: at least its minimum range, and infinity beyond its maximum range.

    Args:
        distances: true distances in m; any shape.
        laser: the laser, which defines the accuracy.
        noise: normally distributed numbers of the same shape.
    """
    noisy = distances + noise * laser.noise
    return np.where(noisy > laser.max_range, np.inf, np.maximum(noisy, laser.min_range)).astype(np.float32)


def read_imus(
    before: Floats, speeds: Floats, dt: float, imu: Imu, biases: Floats, random: np.random.Generator
) -> Floats:
    """Return the turn rates in rad/s and accelerations (x, y, z) in m/s² that robots measure, with shape (n, 4).

    Args:
        before, speeds: true speeds and turn rates, `dt` seconds ago and now; shape (n, 2).
        dt: seconds.
        imu: the IMU, which defines the accuracy.
        biases: offsets of the turn rates; shape (n,).
        random: for the noise.
    """
    forward, turn = speeds[:, 0], speeds[:, 1]
    centrifugal = forward * turn
    exact = np.stack([turn + biases, (forward - before[:, 0]) / dt, centrifugal, np.full(len(speeds), GRAVITY)], axis=1)
    noise = np.array([imu.turn_noise, *[imu.acceleration_noise] * 3])
    measured: Floats = exact + random.standard_normal(exact.shape) * noise
    return measured
