"""Converts a sensor's messages to measurements. Does no I/O: a function provides the frames."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from pyros1.robot_nodes.robot_localization.ekf import Ekf, Measurement
from pyros1.robot_nodes.robot_localization.motion import ACCELERATION, ANGLES, ANGULAR, SIZE, Array, rotation_matrix
from pyros1.robot_nodes.robot_localization.sensors import (
    AccelerationPart,
    FindFrame,
    Frame,
    Mount,
    PoseHistory,
    PosePart,
    TwistPart,
    matrix,
    unit,
    velocity_mask,
)
from pyros1.robot_nodes.robot_localization.settings import SensorSettings, Settings
from pyros1.tf.rotation import Quaternion, Transform, to_angles

_NOT_MEASURED = -1.0
"""The first element of a covariance in an IMU's message, if the IMU does not measure that part."""


class SensorInput:
    """Reads the messages of one sensor.

    Args:
        sensor: the sensor's parameters.
        settings: the node's parameters.
        ekf: the filter, whose estimate some conversions need.
        find_frame: looks up the sensor's frames.
    """

    def __init__(self, sensor: SensorSettings, settings: Settings, ekf: Ekf, find_frame: FindFrame) -> None:
        self.sensor = sensor
        self._ekf = ekf
        self._find_frame = find_frame
        self._world, self._base, self._gravity = settings.world_frame, settings.base_frame, settings.gravity
        self._history = PoseHistory()
        self._identity = Frame()
        self._mount = Mount(self._identity)
        self._covariances = _Covariance(), _Covariance()  # for the pose and the twist
        self._imu_covariances = _Covariance(True), _Covariance(True), _Covariance()
        parts = {"pose": slice(0, 6), "twist": slice(6, 12), "acceleration": ACCELERATION}
        masks = {part: np.zeros(SIZE, bool) for part in parts}
        for part, variables in parts.items():
            masks[part][variables] = sensor.mask[variables]
        self._uses = {part: bool(mask.any()) for part, mask in masks.items()}
        self._pose = PosePart(sensor.name, masks["pose"], sensor.pose_threshold, settings.flat)
        self._twist = TwistPart(sensor.name, masks["twist"], sensor.twist_threshold, settings.flat)
        self._velocity = TwistPart(
            sensor.name, velocity_mask(masks["pose"]), sensor.pose_threshold, settings.flat
        )  # velocities computed from poses (``_differential``)
        self._acceleration = AccelerationPart(
            sensor.name, masks["acceleration"], sensor.acceleration_threshold, settings.flat
        )
        readers = {"odom": self._read_odometry, "pose": self._read_pose, "twist": self._read_twist}
        self._read = readers.get(sensor.kind, self._read_imu)

    def read(self, message: Any) -> list[Measurement]:
        """Return the measurements in a nav_msgs/Odometry, sensor_msgs/Imu, geometry_msgs/PoseWithCovarianceStamped or
        TwistWithCovarianceStamped.
        """
        measurements = self._read(message.header.stamp.to_nsec(), message)
        return [measurement for measurement in measurements if measurement is not None]

    def _read_odometry(self, time: int, message: Any) -> Iterator[Measurement | None]:
        if self._uses["pose"]:
            yield from self._read_pose(time, message)
        if self._uses["twist"]:
            yield self._convert_twist(time, message.child_frame_id, message.twist)

    def _read_pose(self, time: int, message: Any) -> Iterator[Measurement | None]:
        pose, covariance = pose_tuple(message.pose.pose), self._covariances[0].to_matrix(message.pose.covariance)
        if self.sensor.differential:
            yield self._differentiate(time, pose, covariance, self._identity)
            return
        if self.sensor.relative:
            pose = self._history.relative(pose)
        frame = self._find_frame(self._world, message.header.frame_id or self._world, time)
        yield None if frame is None else self._pose.convert(time, pose, covariance, frame)

    def _read_twist(self, time: int, message: Any) -> Iterator[Measurement | None]:
        yield self._convert_twist(time, message.header.frame_id, message.twist)

    def _read_imu(self, time: int, message: Any) -> Iterator[Measurement | None]:
        frame = self._find_frame(self._base, message.header.frame_id or self._base, time)
        if frame is None:
            return
        if frame is not self._mount.frame:  # the frame stays the same for nearly all IMUs
            self._mount = Mount(frame)
        if self._uses["pose"] and message.orientation_covariance[0] != _NOT_MEASURED:
            yield self._convert_orientation(time, message, self._mount)
        if self._uses["twist"] and message.angular_velocity_covariance[0] != _NOT_MEASURED:
            twist = np.array((0.0, 0.0, 0.0, *_vector(message.angular_velocity)))
            covariance = self._imu_covariances[1].to_matrix(message.angular_velocity_covariance)
            yield self._twist.convert(time, twist, covariance, frame, self._ekf.state[ANGULAR])
        if self._uses["acceleration"] and message.linear_acceleration_covariance[0] != _NOT_MEASURED:
            yield self._acceleration.convert(
                time,
                np.array(_vector(message.linear_acceleration)),
                self._imu_covariances[2].to_matrix(message.linear_acceleration_covariance),
                frame,
                self._ekf.state[ANGULAR],
                self._find_attitude(message, frame) if self.sensor.removes_gravity else None,
                self._gravity,
            )

    def _convert_orientation(self, time: int, message: Any, mount: Mount) -> Measurement | None:
        pose = mount.robot_orientation(_quaternion(message.orientation))
        covariance = self._imu_covariances[0].to_matrix(message.orientation_covariance)
        if not mount.turn.is_identity:
            covariance = mount.turn.blocks @ covariance @ mount.turn.blocks.T
        if self.sensor.differential:
            return self._differentiate(time, pose, covariance, mount.turn)
        if self.sensor.relative:
            pose = self._history.relative(pose)
        return self._pose.measure(time, np.array((0.0, 0.0, 0.0, *to_angles(pose[3:]))), covariance, mount.turn)

    def _find_attitude(self, message: Any, frame: Frame) -> Array:
        """Return the rotation matrix (3, 3) from an IMU's frame to the world."""
        if message.orientation_covariance[0] == _NOT_MEASURED:
            return rotation_matrix(*self._ekf.state[ANGLES].tolist()) @ frame.rotation
        attitude = matrix(_quaternion(message.orientation))
        # With ``_relative``, the orientation is relative to the IMU's mounting.
        return attitude @ frame.rotation if self.sensor.relative else attitude

    def _convert_twist(self, time: int, frame_name: str, twist: Any) -> Measurement | None:
        frame = self._find_frame(self._base, frame_name or self._base, time)
        if frame is None:
            return None
        values = np.array((*_vector(twist.twist.linear), *_vector(twist.twist.angular)))
        return self._twist.convert(
            time, values, self._covariances[1].to_matrix(twist.covariance), frame, self._ekf.state[ANGULAR]
        )

    def _differentiate(self, time: int, pose: Transform, covariance: Array, frame: Frame) -> Measurement | None:
        velocity = self._history.velocity(time, pose, covariance)
        return None if velocity is None else self._velocity.measure(time, *velocity, frame)


def pose_tuple(pose: Any) -> Transform:
    """Return a geometry_msgs/Pose as a tuple, with its quaternion normalised."""
    return (*_vector(pose.position), *unit(_quaternion(pose.orientation)))


def _vector(vector: Any) -> tuple[float, float, float]:
    return vector.x, vector.y, vector.z


def _quaternion(quaternion: Any) -> Quaternion:
    return quaternion.x, quaternion.y, quaternion.z, quaternion.w


class _Covariance:
    """Converts covariances from a sensor's messages, and caches the last one, since they rarely change.

    Args:
        angular: whether the covariances are of three angles or their rates, the second half of a pose or twist.
    """

    def __init__(self, angular: bool = False) -> None:
        self._angular = angular
        self._numbers: tuple[float, ...] = ()
        self._matrix = np.zeros((0, 0))

    def to_matrix(self, numbers: Any) -> Array:
        """Return k * k numbers as a (k, k) matrix, or (6, 6) if angular; for unchanged numbers, the same array."""
        numbers = tuple(numbers)
        if numbers != self._numbers:
            size = round(len(numbers) ** 0.5)
            matrix = np.array(numbers, float).reshape(size, size)
            if self._angular:
                full = np.zeros((6, 6))
                full[3:, 3:] = matrix
                matrix = full
            matrix.setflags(write=False)
            self._numbers, self._matrix = numbers, matrix
        return self._matrix
