"""Turns what sensors report into measurements of the filter's state: frames, masks and covariances. Pure.

Each sensor has a configuration of 15 bools, in the order of the state, which says what of it is used. They are meant in
the sensor's frame; rotated to the filter's frame, a used axis can lead to several.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import hypot, inf

import numpy as np

from pyros1.robot_nodes.robot_localization.ekf import MIN_VARIANCE, Measurement
from pyros1.robot_nodes.robot_localization.motion import (
    ACCELERATION,
    ANGLES,
    ANGULAR,
    AZ,
    LINEAR,
    PITCH,
    POSITION,
    ROLL,
    SIZE,
    VPITCH,
    VROLL,
    VZ,
    Array,
    Z,
    rotation_matrix,
)
from pyros1.tf.rotation import IDENTITY, Quaternion, Transform, invert, multiply, to_angles

Mask = np.ndarray[tuple[int], np.dtype[np.bool_]]

_FLAT_VARIANCE = 1e-6
_MIN_MASK = 1e-6
_NO_ROTATION: Quaternion = (0.0, 0.0, 0.0, 1.0)
_FLAT = [Z, ROLL, PITCH, VZ, VROLL, VPITCH, AZ]
"""The variables that are 0 for a robot that moves in a plane."""


class Frame:
    """A sensor's frame, as it is in the frame that its data are converted to.

    Args:
        transform: the pose of the sensor's frame.

    Attributes:
        transform: the same.
        rotation: its rotation as a matrix (3, 3).
        offset: its position (3,).
        is_identity: whether nothing has to be converted.
    """

    def __init__(self, transform: Transform = IDENTITY) -> None:
        self.transform = transform
        self.rotation = matrix(transform[3:])
        self.offset = np.array(transform[:3])
        self.is_identity = transform == IDENTITY


FindFrame = Callable[[str, str, int], Frame | None]
"""Returns the pose of the second frame in the first at a time in nanoseconds, or None if it is not known."""


@dataclass(frozen=True)
class Part:
    """What is used of one part of a sensor's messages: its pose, twist or acceleration.

    Attributes:
        name: the sensor, such as ``odom0``.
        mask: which of the 15 variables are used (15,).
        threshold: the Mahalanobis distance from which on a measurement is rejected.
        flat: whether the robot moves in a plane (``two_d_mode``).
    """

    name: str
    mask: Mask
    threshold: float = inf
    flat: bool = False

    def measure(self, time: int, values: Array, covariance: Array, mask: Mask) -> Measurement | None:
        """Return a measurement of those variables that are masked and finite; None if there are none.

        Args:
            time: the time in nanoseconds.
            values, covariance: of the whole state (15,), (15, 15). Both are changed.
            mask: the variables (15,). It is changed.
        """
        if self.flat:
            mask[_FLAT] = True
            values[_FLAT] = 0.0
            covariance[_FLAT], covariance[:, _FLAT] = 0.0, 0.0
            covariance[_FLAT, _FLAT] = _FLAT_VARIANCE
        (indices,) = np.nonzero(mask & np.isfinite(values))
        covariance = covariance[indices[:, None], indices]
        if not len(indices) or not np.isfinite(covariance).all():
            return None
        diagonal = np.arange(len(indices))
        covariance[diagonal, diagonal] = np.maximum(np.abs(covariance[diagonal, diagonal]), MIN_VARIANCE)
        return Measurement(time, indices, values[indices], covariance, self.threshold, self.name)


def matrix(quaternion: Quaternion) -> Array:
    """Return the rotation matrix (3, 3) of a quaternion, which is normalised."""
    x, y, z, w = unit(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def unit(quaternion: Quaternion) -> Quaternion:
    """Return a quaternion of length 1; if it is 0, as in messages that nobody filled in, the one without rotation."""
    x, y, z, w = quaternion
    length = hypot(x, y, z, w)
    return (x / length, y / length, z / length, w / length) if length > 0.0 else _NO_ROTATION


class TwistPart(Part):
    """The twist of a sensor: velocities in the sensor's frame."""

    def convert(
        self, time: int, twist: Array, covariance: Array, frame: Frame, angular: Array, mask: Mask | None = None
    ) -> Measurement | None:
        """Return a measurement of the robot's velocities.

        Args:
            time: the time in nanoseconds.
            twist: linear and angular velocity (6,).
            covariance: its covariance (6, 6).
            frame: the sensor's frame on the robot.
            angular: the robot's estimated angular velocity (3,), by which a sensor beside its centre moves.
            mask: what is used (15,); None for the part's own mask.
        """
        values, full, mask = np.zeros(SIZE), np.zeros((SIZE, SIZE)), (self.mask if mask is None else mask).copy()
        values[6:12], full[6:12, 6:12] = twist, covariance
        if not frame.is_identity:
            values[LINEAR] = frame.rotation @ twist[:3] + np.cross(frame.offset, angular)
            values[ANGULAR] = frame.rotation @ twist[3:]
            _rotate(full[6:12, 6:12], frame.rotation)
            mask[LINEAR], mask[ANGULAR] = _rotate_mask(mask[LINEAR], frame), _rotate_mask(mask[ANGULAR], frame)
        return self.measure(time, values, full, mask)


class AccelerationPart(Part):
    """The linear acceleration of an IMU, in its own frame."""

    def convert(
        self,
        time: int,
        acceleration: Array,
        covariance: Array,
        frame: Frame,
        angular: Array,
        to_world: Array | None = None,
        gravity: float = 0.0,
    ) -> Measurement | None:
        """Return a measurement of the robot's acceleration.

        Args:
            time: the time in nanoseconds.
            acceleration: the acceleration (3,).
            covariance: its covariance (3, 3).
            frame: the IMU's frame on the robot.
            angular: the robot's estimated angular velocity (3,), which accelerates an IMU beside its centre.
            to_world: the rotation (3, 3) from the IMU's frame to the world, to remove gravity; None to keep it.
            gravity: what an IMU at rest measures upwards, in m/s².
        """
        if to_world is not None:
            acceleration = acceleration - gravity * to_world[2]
        values, full, mask = np.zeros(SIZE), np.zeros((SIZE, SIZE)), self.mask.copy()
        if not frame.is_identity:
            towards_centre = np.cross(angular, np.cross(angular, frame.offset))
            acceleration = frame.rotation @ acceleration - towards_centre
            covariance = frame.rotation @ covariance @ frame.rotation.T
            mask[ACCELERATION] = _rotate_mask(mask[ACCELERATION], frame)
        values[ACCELERATION], full[ACCELERATION, ACCELERATION] = acceleration, covariance
        return self.measure(time, values, full, mask)


class PosePart(Part):
    """The pose of a sensor: the robot's, in the sensor's world."""

    def convert(self, time: int, pose: Transform, covariance: Array, frame: Frame) -> Measurement | None:
        """Return a measurement of the robot's pose.

        Args:
            time: the time in nanoseconds.
            pose: the pose.
            covariance: its covariance (6, 6).
            frame: the sensor's world in the filter's.
        """
        x, y, z, *quaternion = multiply(frame.transform, pose)
        mask, full = self.mask.copy(), np.zeros((SIZE, SIZE))
        full[:6, :6] = covariance
        if not frame.is_identity:
            _rotate(full[:6, :6], frame.rotation)
            mask[POSITION], mask[ANGLES] = _rotate_mask(mask[POSITION], frame), _rotate_mask(mask[ANGLES], frame)
        values = np.zeros(SIZE)
        values[:6] = (x, y, z, *to_angles((quaternion[0], quaternion[1], quaternion[2], quaternion[3])))
        return self.measure(time, values, full, mask)

    def mounted(self, frame: Frame) -> PosePart:
        """Return this part for an IMU that is mounted on the robot in another direction: what it calls roll and pitch
        is turned by its yaw.
        """
        mask = self.mask.copy()
        mask[ANGLES] = _rotate_mask(mask[ANGLES], mounting(frame))
        return PosePart(self.name, mask, self.threshold, self.flat)


def mounting(frame: Frame) -> Frame:
    """Return the yaw of an IMU's frame, alone: its roll and pitch do not change which axis of the robot is which."""
    if frame.is_identity:
        return frame
    yaw = to_angles(frame.transform[3:])[2]
    turned = Frame()
    turned.rotation, turned.is_identity = rotation_matrix(0.0, 0.0, yaw), False
    return turned


def robot_orientation(orientation: Quaternion, frame: Frame) -> Transform:
    """Return the robot's orientation in the world, without a position.

    Args:
        orientation: that of an IMU in the world.
        frame: the IMU's frame on the robot.
    """
    mount = invert((0.0, 0.0, 0.0, *unit(frame.transform[3:])))
    return multiply((0.0, 0.0, 0.0, *unit(orientation)), mount)


class PoseHistory:
    """The earlier poses of a sensor, for its ``_differential`` and ``_relative`` parameters."""

    def __init__(self) -> None:
        self._first: Transform | None = None
        self._last: tuple[int, Transform, Array] | None = None

    def relative(self, pose: Transform) -> Transform:
        """Return a pose in the frame of the sensor's first pose."""
        if self._first is None:
            self._first = pose
        return multiply(invert(self._first), pose)

    def velocity(self, time: int, pose: Transform, covariance: Array) -> tuple[Array, Array] | None:
        """Return the velocity since the previous pose, in the robot's frame, and its covariance; None for the first.

        Args:
            time: the time in nanoseconds.
            pose: the pose.
            covariance: its covariance (6, 6).
        """
        last, self._last = self._last, (time, pose, covariance)
        if last is None or time <= last[0]:
            return None
        seconds = (time - last[0]) * 1e-9
        x, y, z, *rotation = multiply(invert(last[1]), pose)
        angles = to_angles((rotation[0], rotation[1], rotation[2], rotation[3]))
        # The original's covariance, for which the parameters of robots were tuned; the velocity's would be divided by
        # the time twice.
        return np.array((x, y, z, *angles)) / seconds, (covariance + last[2]) * seconds


def velocity_mask(mask: Mask) -> Mask:
    """Return which velocities are used (15,) of a sensor whose poses are used as differences."""
    velocities = np.zeros(SIZE, bool)
    velocities[6:12] = mask[:6]
    return velocities


def _rotate(covariance: Array, rotation: Array) -> None:
    """Rotate the four blocks of a covariance (6, 6) in place."""
    blocks = np.zeros((6, 6))
    blocks[:3, :3] = blocks[3:, 3:] = rotation
    covariance[:] = blocks @ covariance @ blocks.T


def _rotate_mask(mask: Mask, frame: Frame) -> Mask:
    """Return which axes (3,) have a part of the used axes of a sensor."""
    rotated: Mask = np.linalg.norm(frame.rotation[:, mask], axis=1) >= _MIN_MASK
    return rotated
