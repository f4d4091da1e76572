"""Converts sensor data to measurements of the filter's state: frames, masks and covariances. Pure.

Each sensor has a configuration of 15 bools, in the order of the state, which select the variables to use. They refer to
the sensor's frame; after rotation to the filter's frame, one selected axis can affect several.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, inf, isfinite

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
)
from pyros1.tf.rotation import IDENTITY, Quaternion, Transform, from_angles, invert, multiply, to_angles

Mask = np.ndarray[tuple[int], np.dtype[np.bool_]]

_FLAT_VARIANCE = 1e-6
_MIN_MASK = 1e-6
_NO_ROTATION: Quaternion = (0.0, 0.0, 0.0, 1.0)
_FLAT = [Z, ROLL, PITCH, VZ, VROLL, VPITCH, AZ]
"""The variables that are 0 if the robot moves in a plane."""


class Frame:
    """The pose of a sensor's frame in the frame to which its data is converted.

    Args:
        transform: the pose.

    Attributes:
        transform: the pose.
        rotation: the rotation matrix of the pose (3, 3).
        blocks: the rotation matrix twice on the diagonal (6, 6), for a pose or twist.
        offset: the position of the pose (3,).
        is_identity: whether no conversion is needed.
    """

    def __init__(self, transform: Transform = IDENTITY) -> None:
        self.transform = transform
        self.rotation = matrix(transform[3:])
        self.blocks = np.kron(np.eye(2), self.rotation)
        self.offset = np.array(transform[:3])
        self.is_identity = transform == IDENTITY


FindFrame = Callable[[str, str, int], Frame | None]
"""A function that returns the pose of the second frame in the first at a time in nanoseconds; None if unknown."""


class Part:
    """One part of a sensor's messages: the pose, twist or acceleration.

    Args:
        name: the sensor, such as ``odom0``.
        mask: which of the 15 variables are used (15,), in the sensor's frame.
        threshold: measurements are rejected at this Mahalanobis distance or beyond it.
        flat: whether the robot moves in a plane (``two_d_mode``).
    """

    variables = slice(0, SIZE)
    """The variables that this kind of part can measure."""

    def __init__(self, name: str, mask: Mask, threshold: float = inf, flat: bool = False) -> None:
        self.name, self.mask, self.threshold, self.flat = name, mask, threshold, flat
        self._frame: Frame | None = None
        self._choice = _Choice(mask, self.variables, flat)

    def measure(self, time: int, values: Array, covariance: Array, frame: Frame) -> Measurement | None:
        """Return a measurement of the used variables that are finite; None if there are none.

        Args:
            time: the time in nanoseconds.
            values: the converted values of the part's variables (k,).
            covariance: their covariance (k, k). The result is cached for the next time the same array is passed, so the
                array must not be changed.
            frame: the frame from which they were converted.
        """
        if frame is not self._frame:  # the frame stays the same for nearly all sensors
            self._frame, self._choice = frame, _Choice(rotate_mask(self.mask, frame), self.variables, self.flat)
        choice = self._choice
        if not isfinite(sum(values.tolist())):
            choice = choice.without(~np.isfinite(values))
        chosen = choice.apply(values, covariance)
        return None if chosen is None else Measurement(time, choice.indices, *chosen, self.threshold, self.name)


class _Choice:
    """Selects the used values and covariances of a part.

    Args:
        mask: the used variables (15,).
        variables: the variables that the part measures.
        flat: whether the robot moves in a plane.

    Attributes:
        indices: the variables in the measurement (k,).
    """

    def __init__(self, mask: Mask, variables: slice, flat: bool) -> None:
        self._arguments = mask, variables, flat
        in_plane = np.zeros(SIZE, bool)
        in_plane[_FLAT] = flat
        measured = mask & ~in_plane
        (self.indices,) = np.nonzero(measured | (in_plane & mask.any()))
        self._from = np.nonzero(measured[variables])[0]
        self._to = np.nonzero(measured[self.indices])[0]
        self._pads = len(self._to) < len(self.indices)
        self._covariance: Array | None = None
        self._chosen: Array | None = None

    def without(self, unknown: Mask) -> _Choice:
        """Return a choice without some of the part's variables."""
        mask, variables, flat = self._arguments
        mask = mask.copy()
        mask[variables] &= ~unknown
        return _Choice(mask, variables, flat)

    def apply(self, values: Array, covariance: Array) -> tuple[Array, Array] | None:
        """Return the values (k,) and covariance (k, k) of the measurement; None if there is none."""
        if covariance is not self._covariance:  # the covariance rarely changes
            self._covariance, self._chosen = covariance, self._choose(covariance)
        if self._chosen is None:
            return None
        chosen = values.take(self._from)
        if self._pads:
            padded = np.zeros(len(self.indices))
            padded[self._to] = chosen
            chosen = padded
        return chosen, self._chosen

    def _choose(self, covariance: Array) -> Array | None:
        chosen = covariance[self._from[:, None], self._from]
        if not len(self.indices) or not np.isfinite(chosen).all():
            return None
        diagonal = chosen.diagonal()
        if len(diagonal) and diagonal.min() < MIN_VARIANCE:
            np.fill_diagonal(chosen, np.maximum(np.abs(diagonal), MIN_VARIANCE))
        if self._pads:
            full = _FLAT_VARIANCE * np.eye(len(self.indices))
            full[self._to[:, None], self._to] = chosen
            chosen = full
        chosen.setflags(write=False)
        return chosen


def matrix(quaternion: Quaternion) -> Array:
    """Return the rotation matrix (3, 3) of a quaternion, which is normalized first."""
    x, y, z, w = unit(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def unit(quaternion: Quaternion) -> Quaternion:
    """Return a quaternion normalized to length 1; the identity if it is 0, as in messages that were not filled in."""
    x, y, z, w = quaternion
    length = hypot(x, y, z, w)
    return (x / length, y / length, z / length, w / length) if length > 0.0 else _NO_ROTATION


class TwistPart(Part):
    """The twist of a sensor: velocities in the sensor's frame."""

    variables = slice(6, 12)

    def convert(self, time: int, twist: Array, covariance: Array, frame: Frame, angular: Array) -> Measurement | None:
        """Return a measurement of the robot's velocities.

        Args:
            time: the time in nanoseconds.
            twist: linear and angular velocity (6,).
            covariance: the covariance of the twist (6, 6).
            frame: the sensor's frame on the robot.
            angular: the robot's estimated angular velocity (3,), which moves a sensor that is not at the centre.
        """
        if not frame.is_identity:
            twist, covariance = frame.blocks @ twist, frame.blocks @ covariance @ frame.blocks.T
            twist[:3] += cross(frame.offset, angular)
        return self.measure(time, twist, covariance, frame)


class AccelerationPart(Part):
    """The linear acceleration of an IMU, in its own frame."""

    variables = ACCELERATION

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
            covariance: the covariance of the acceleration (3, 3).
            frame: the IMU's frame on the robot.
            angular: the robot's estimated angular velocity (3,), which accelerates an IMU that is not at the centre.
            to_world: the rotation (3, 3) from the IMU's frame to the world, to remove gravity; None to keep it.
            gravity: the upward acceleration that an IMU at rest measures, in m/s².
        """
        if to_world is not None:
            acceleration = acceleration - gravity * to_world[2]
        if not frame.is_identity:
            towards_centre = cross(angular, cross(angular, frame.offset))
            acceleration = frame.rotation @ acceleration - towards_centre
            covariance = frame.rotation @ covariance @ frame.rotation.T
        return self.measure(time, acceleration, covariance, frame)


class PosePart(Part):
    """The pose part of a sensor's messages: the robot's pose in the sensor's world frame."""

    variables = slice(0, 6)

    def convert(self, time: int, pose: Transform, covariance: Array, frame: Frame) -> Measurement | None:
        """Return a measurement of the robot's pose.

        Args:
            time: the time in nanoseconds.
            pose: the pose.
            covariance: the covariance of the pose (6, 6).
            frame: the sensor's world frame in the filter's world frame.
        """
        if not frame.is_identity:
            pose, covariance = multiply(frame.transform, pose), frame.blocks @ covariance @ frame.blocks.T
        return self.measure(time, np.array((*pose[:3], *to_angles(pose[3:]))), covariance, frame)


def cross(a: Array, b: Array) -> Array:
    """Return the cross product (3,) of two vectors (3,). numpy's own function takes 20 times as long."""
    ax, ay, az = a.tolist()
    bx, by, bz = b.tolist()
    return np.array((ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx))


def rotate_mask(mask: Mask, frame: Frame) -> Mask:
    """Rotate a mask (15,): return the mask (15,) of the variables that depend on the selected ones after a rotation."""
    if frame.is_identity:
        return mask
    rotated = np.zeros(SIZE, bool)
    for vector in (POSITION, ANGLES, LINEAR, ANGULAR, ACCELERATION):
        rotated[vector] = np.linalg.norm(frame.rotation[:, mask[vector]], axis=1) >= _MIN_MASK
    return rotated


class Mount:
    """The mounting of an IMU on the robot.

    Args:
        frame: the IMU's frame on the robot.

    Attributes:
        frame: the IMU's frame on the robot.
        turn: the frame's yaw only, by which the IMU's roll and pitch axes are rotated. The frame's roll and pitch do
            not change which axis is which.
    """

    def __init__(self, frame: Frame) -> None:
        self.frame = frame
        self.turn = frame
        if not frame.is_identity:
            self.turn = Frame((0.0, 0.0, 0.0, *from_angles(0.0, 0.0, to_angles(frame.transform[3:])[2])))
        self._from_robot = invert((0.0, 0.0, 0.0, *unit(frame.transform[3:])))

    def robot_orientation(self, orientation: Quaternion) -> Transform:
        """Return the robot's orientation in the world, given the IMU's. The position is 0."""
        return multiply((0.0, 0.0, 0.0, *unit(orientation)), self._from_robot)


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
            covariance: the covariance of the pose (6, 6).
        """
        last, self._last = self._last, (time, pose, covariance)
        if last is None or time <= last[0]:
            return None
        seconds = (time - last[0]) * 1e-9
        x, y, z, *rotation = multiply(invert(last[1]), pose)
        angles = to_angles((rotation[0], rotation[1], rotation[2], rotation[3]))
        # This is the original's covariance, for which robots' parameters were tuned. The correct one for a velocity
        # would be divided by the time twice.
        return np.array((x, y, z, *angles)) / seconds, (covariance + last[2]) * seconds


def velocity_mask(mask: Mask) -> Mask:
    """Return the mask (15,) of the velocities that a sensor with ``_differential`` measures, given the pose's mask."""
    velocities = np.zeros(SIZE, bool)
    velocities[6:12] = mask[:6]
    return velocities
