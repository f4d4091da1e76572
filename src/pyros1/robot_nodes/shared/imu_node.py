"""The topics, parameters and transform that imu_filter_madgwick and imu_complementary_filter share."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

from pyros1.ground.terminal_text import one_line
from pyros1.msgs.geometry_msgs.msg import Quaternion, Transform, TransformStamped, Vector3, Vector3Stamped
from pyros1.msgs.sensor_msgs.msg import Imu, MagneticField
from pyros1.node import Node
from pyros1.robot_nodes.shared.imu_pairs import ImuPairs
from pyros1.robot_nodes.shared.imu_readings import (
    Estimate,
    OrientationFilter,
    Reading,
    TimeSteps,
    UnusableReadingError,
    is_usable,
)
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.quaternions import conjugate
from pyros1.tf import TransformBroadcaster
from pyros1.tf.rotation import Vector, to_angles

_QUEUE_SIZE = 5
WAIT_PERIOD = 10.0
"""Seconds without messages after which the node logs a warning."""


class ImuFilterNode:
    """Publishes an IMU's messages with the estimated orientation.

    It subscribes to ``imu/data_raw``, and to ``imu/mag`` if the magnetic field is used, and publishes ``imu/data``.
    Remapping ``imu`` renames all three.

    Args:
        node: the node.
        parameters: the node's parameters.
        filter_: estimates the orientation.
        use_mag: whether to use the magnetic field.
        publish_tf: the default of the parameter ``publish_tf``.
        vector_field: whether the type of ``imu/mag`` is Vector3Stamped, as in old versions.
        watch: called with a message's header, its reading and the estimate, if debug topics are published.
    """

    def __init__(
        self,
        node: Node,
        parameters: PrivateParameters,
        filter_: OrientationFilter[Any],
        *,
        use_mag: bool,
        publish_tf: bool,
        vector_field: bool = False,
        watch: Callable[[Any, Reading, Estimate], object] | None = None,
    ) -> None:
        self._node = node
        self._filter = filter_
        self._watch = watch
        self._fixed_frame = parameters.text("fixed_frame", "odom").lstrip("/")
        self._reverse_tf = parameters.flag("reverse_tf", False)
        self._steps = TimeSteps(parameters.number("constant_dt", 0.0, 0.0))
        variance = parameters.number("orientation_stddev", 0.0, 0.0, 1e6) ** 2
        self._covariance = [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, variance]
        self._broadcaster = TransformBroadcaster(node) if parameters.flag("publish_tf", publish_tf) else None
        imu = node.resolve("imu")
        self._publisher = node.advertise(f"{imu}/data", Imu, queue_size=_QUEUE_SIZE)
        self._angles = (
            node.advertise(f"{imu}/rpy/filtered", Vector3Stamped, queue_size=_QUEUE_SIZE) if watch is not None else None
        )
        self._topics = [f"{imu}/data_raw"]
        self._timer = node.timer(WAIT_PERIOD, lambda event: self._complain())
        if use_mag:
            self._topics.append(f"{imu}/mag")
            self._pairs = ImuPairs(_QUEUE_SIZE)
            self._pairs_lock = threading.Lock()
            field_type: type[Any] = Vector3Stamped if vector_field else MagneticField
            node.subscribe(self._topics[0], Imu, partial(self._add, 0), queue_size=_QUEUE_SIZE)
            node.subscribe(self._topics[1], field_type, partial(self._add, 1), queue_size=_QUEUE_SIZE)
        else:
            node.subscribe(self._topics[0], Imu, self._receive, queue_size=_QUEUE_SIZE)

    def _complain(self) -> None:
        topics = " and ".join(map(self._node.resolve, self._topics))
        self._node.log.warn("still waiting for messages on %s", topics)

    def _add(self, index: int, message: Any) -> None:
        with self._pairs_lock:  # held until the pair is filtered, so that no pair overtakes another
            for imu, field in self._pairs.add(index, message.header.stamp, message):
                self._receive_both(imu, field)

    def _receive_both(self, imu: Any, field: Any) -> None:
        vector = as_tuple(field.vector if isinstance(field, Vector3Stamped) else field.magnetic_field)
        self._receive(imu, vector if is_usable(vector) else None)

    def _receive(self, imu: Any, field: Vector | None = None) -> None:
        self._timer.shutdown()
        reading = Reading(as_tuple(imu.angular_velocity), as_tuple(imu.linear_acceleration), field)
        step = self._steps.next(imu.header.stamp.to_nsec())
        if step.problem:
            self._node.log.warn("%s", step.problem, throttle=10)
        if step.restart:
            self._filter.reset()
        if step.ignore:
            return
        try:
            reading.check()
            estimate = self._filter.update(reading, step.seconds)
        except UnusableReadingError as error:
            self._node.log.warn("an IMU message is ignored: %s", one_line(str(error), 200), throttle=10)
            return
        if estimate is not None:
            if not any(reading.acceleration):
                self._node.log.warn("the IMU measures no acceleration: only its rotation is used", throttle=10)
            self._publish(imu, reading, estimate)

    def _publish(self, imu: Any, reading: Reading, estimate: Estimate) -> None:
        self._publisher.publish(
            Imu(
                imu.header,
                Quaternion(*estimate.orientation),
                self._covariance,
                Vector3(*estimate.rates),
                imu.angular_velocity_covariance,
                Vector3(*estimate.acceleration),
                imu.linear_acceleration_covariance,
            )
        )
        if self._broadcaster is not None:
            if imu.header.frame_id:
                self._broadcaster.send_transform(self._transform(imu.header, estimate))
            else:
                self._node.log.warn("IMU messages have no frame_id, so no transform is published", throttle=10)
        if self._angles is not None and self._watch is not None:
            self._angles.publish(Vector3Stamped(imu.header, Vector3(*to_angles(estimate.orientation))))
            self._watch(imu.header, reading, estimate)

    def _transform(self, header: Any, estimate: Estimate) -> Any:
        frames, rotation = (self._fixed_frame, header.frame_id.lstrip("/")), estimate.orientation
        if self._reverse_tf:
            frames, rotation = frames[::-1], conjugate(rotation)
        transform: Any = TransformStamped(child_frame_id=frames[1], transform=Transform(rotation=Quaternion(*rotation)))
        transform.header.stamp, transform.header.frame_id = header.stamp, frames[0]
        return transform


def as_tuple(vector: Any) -> Vector:
    """Return a geometry_msgs/Vector3 as a tuple."""
    return vector.x, vector.y, vector.z
