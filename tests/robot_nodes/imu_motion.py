"""A simulated IMU that is turned about, calculated with rotation matrices."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.robot_nodes.shared.imu_readings import Reading
from pyros1.tf.rotation import Quaternion

Array = NDArray[np.float64]
EAST_NORTH_UP = {"enu": np.eye(3), "nwu": np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 1]])}
EAST_NORTH_UP["ned"] = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
"""For each world frame, its axes as rows: what converts east, north, up to it."""
FIELD = np.array([0.0, 20e-6, -43e-6])


def matrix(quaternion: Quaternion) -> Array:
    """Return a rotation matrix."""
    *axis, w = quaternion
    cross = skew(np.array(axis))
    return np.asarray(np.eye(3) + 2 * w * cross + 2 * cross @ cross)


def skew(vector: Array) -> Array:
    x, y, z = vector
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def exponential(vector: Array) -> Array:
    """Return the matrix of a rotation about an axis, given as the axis times the angle."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    cross = skew(vector / angle)
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross)


def angle_between(quaternion: Quaternion, truth: Array) -> float:
    """Return the angle in radians between an orientation and the true one."""
    # acos would lose half of the digits
    difference = matrix(quaternion).T @ truth
    sine = np.linalg.norm([difference[i, j] - difference[j, i] for i, j in ((2, 1), (0, 2), (1, 0))]) / 2
    return float(np.arctan2(sine, (np.trace(difference) - 1) / 2))


def tilt_between(quaternion: Quaternion, truth: Array) -> float:
    """Return the angle in radians between the directions that are vertical in both."""
    first, second = matrix(quaternion)[2], truth[2]
    return float(np.arctan2(np.linalg.norm(np.cross(first, second)), first @ second))


@dataclass
class Motion:
    """An IMU that swings about all axes.

    Attributes:
        world: the world frame of the true orientations.
        noise: standard deviation of the acceleration in m/s²; that of the rates and of the field follow from it.
        bias: of the gyroscope in rad/s.
        speed: greatest angular velocity in rad/s.
        has_field: whether there is a magnetometer.
        start: rotation vector of the initial orientation.
    """

    world: str = "enu"
    noise: float = 0.0
    bias: tuple[float, float, float] = (0.0, 0.0, 0.0)
    speed: float = 0.5
    has_field: bool = True
    start: tuple[float, float, float] = (0.2, -0.4, 1.0)
    seed: int = 1

    def readings(self, count: int, seconds: float = 0.01) -> Iterator[tuple[Reading, Array]]:
        """Yield what the IMU measures, with its true orientation as a matrix."""
        random = np.random.default_rng(self.seed)
        axes = EAST_NORTH_UP[self.world]
        truth = exponential(np.array(self.start))  # from the IMU's frame to east, north, up
        for index in range(count):
            rates = self.speed * np.sin(index * seconds * np.array([1.1, 0.7, 0.9]) + [0.0, 1.0, 2.0])
            truth = truth @ exponential(rates * seconds)
            values: list[Any] = [
                rates + self.bias + random.normal(0, self.noise * 0.05, 3),
                truth.T @ [0, 0, 9.81] + random.normal(0, self.noise, 3),
                truth.T @ FIELD + random.normal(0, self.noise * 2e-6, 3),
            ]
            reading = [tuple(value.tolist()) for value in values]
            yield Reading(reading[0], reading[1], reading[2] if self.has_field else None), axes @ truth
