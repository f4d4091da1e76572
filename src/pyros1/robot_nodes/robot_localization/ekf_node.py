"""ekf_localization_node: estimates a robot's pose, velocity and acceleration from odometry, IMUs and other sensors.

See https://wiki.ros.org/robot_localization.
"""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from pyros1.diagnostics import OK, WARN, Frequency, Updater
from pyros1.ground.errors import ServiceRefusal
from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import (
    AccelWithCovarianceStamped,
    PoseWithCovarianceStamped,
    Twist,
    TwistStamped,
    TwistWithCovarianceStamped,
)
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.robot_localization.srv import SetPose, ToggleFilterProcessing
from pyros1.msgs.sensor_msgs.msg import Imu
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.node import Node
from pyros1.robot_nodes.robot_localization.ekf import Ekf
from pyros1.robot_nodes.robot_localization.estimator import Estimator
from pyros1.robot_nodes.robot_localization.frames import Frames
from pyros1.robot_nodes.robot_localization.inputs import SensorInput, pose_tuple
from pyros1.robot_nodes.robot_localization.motion import SIZE
from pyros1.robot_nodes.robot_localization.output import (
    estimated_pose,
    make_acceleration,
    make_odometry,
    make_transform,
)
from pyros1.robot_nodes.robot_localization.sensors import PosePart
from pyros1.robot_nodes.robot_localization.settings import read_settings
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.tf.broadcaster import TransformBroadcaster
from pyros1.tf.rotation import invert, multiply

_MESSAGES = {"odom": Odometry, "pose": PoseWithCovarianceStamped, "twist": TwistWithCovarianceStamped, "imu": Imu}
_UNMEASURED_VARIANCE = 1e-6
_NS = 1e-9


class EkfNode:
    """The topics, services and timer of ekf_localization_node.

    Args:
        node: the node.
        make_filter: creates the filter; takes the same arguments as `Ekf`.
    """

    def __init__(self, node: Node, make_filter: Callable[..., Ekf] = Ekf) -> None:
        self._node, self._make_filter = node, make_filter
        self._settings = settings = read_settings(PrivateParameters.of(node), find_prefix(node))
        self._frames = Frames(node, settings.transform_timeout)
        self._lock = threading.Lock()
        self._enabled, self._processes = not settings.starts_disabled, True
        self._problems: dict[str, str] = {}
        self._start()

        self._odometry = node.advertise("odometry/filtered", Odometry, queue_size=20)
        self._acceleration: Any = None
        if settings.publishes_acceleration:
            self._acceleration = node.advertise("accel/filtered", AccelWithCovarianceStamped, queue_size=20)
        self._broadcaster = TransformBroadcaster(node) if settings.publishes_tf and self._check_frames() else None
        self._frequency: Frequency | None = None
        if settings.diagnostics:
            self._frequency = Frequency(node.now, settings.frequency - 2.0, settings.frequency + 2.0)
            updater = Updater(node, hardware_id="none")
            updater.add("Filter diagnostic updater", self._diagnose)
            updater.add("odometry/filtered topic status", self._frequency.run)

        node.advertise_service("set_pose", SetPose, self._on_set_pose_request)
        node.advertise_service("~toggle", ToggleFilterProcessing, self._on_toggle)
        node.advertise_service("~enable", Empty, self._on_enable)
        node.subscribe("set_pose", PoseWithCovarianceStamped, self._on_set_pose, queue_size=1)
        self._subscribe()
        node.timer(1.0 / settings.frequency, lambda event: self.update())

    def update(self) -> None:
        """Update the filter with the queued measurements, and publish the estimate."""
        with self._lock:
            now = self._node.now().to_nsec()
            if not self._enabled:
                return
            if self._processes:
                self._estimator.advance(now)
            else:
                self._estimator.skip_to(now)
            if self._estimator.time is None:
                return
            if not (np.isfinite(self._ekf.state).all() and np.isfinite(self._ekf.covariance).all()):
                text = "the estimate is no longer finite, so the filter starts again: check the covariances of %s"
                self._node.log.error(text, ", ".join(self._inputs), throttle=10)
                self._start()
                return
            self._publish(self._estimator.time)

    def _start(self) -> None:
        settings = self._settings
        self._ekf = self._make_filter(
            settings.process_noise, settings.initial_covariance, settings.initial_state, settings.dynamic_noise
        )
        self._estimator = Estimator(
            self._ekf,
            history=round(settings.history / _NS),
            sensor_timeout=round(settings.sensor_timeout / _NS),
            always_predict=settings.predicts_to_now,
            control=settings.control,
        )
        self._inputs = {
            sensor.name: SensorInput(sensor, settings, self._ekf, self._frames.find) for sensor in settings.sensors
        }
        self._last_stamps: dict[str, int] = {}
        self._set_pose_at = self._last_published = 0

    def _check_frames(self) -> bool:
        """Return whether there is a transform to publish."""
        settings = self._settings
        if len({settings.map_frame, settings.odom_frame, settings.base_frame}) < 3:
            self._node.log.error("map_frame, odom_frame and base_link_frame must be different frames")
        if settings.world_frame in (settings.map_frame, settings.odom_frame) or settings.inverts_tf:
            return True
        text = "world_frame is %s, but it must be odom_frame (%s) or map_frame (%s): no transform is published"
        self._node.log.error(text, settings.world_frame, settings.odom_frame, settings.map_frame)
        return False

    def _subscribe(self) -> None:
        settings = self._settings
        for sensor in settings.sensors:
            self._node.subscribe(
                sensor.topic,
                _MESSAGES[sensor.kind],
                partial(self._receive, sensor.name),
                queue_size=sensor.queue_size or None,
                tcp_nodelay=sensor.nodelay,
            )
        if not settings.sensors:
            text = "no sensors are configured: for example, set ~odom0 to a topic and ~odom0_config to 15 booleans"
            self._node.log.error(text)
        if settings.control is not None and settings.stamped_control:
            self._node.subscribe("cmd_vel", TwistStamped, lambda message: self._command(message.twist), queue_size=1)
        elif settings.control is not None:
            self._node.subscribe("cmd_vel", Twist, self._command, queue_size=1)

    # Receiving --------------------------------------------------------------------------------------------------------

    def _receive(self, name: str, message: Any) -> None:
        stamp = message.header.stamp.to_nsec()
        with self._lock:
            last = self._last_stamps.get(name, 0)
            if stamp < last and self._settings.resets_on_time_jump and self._node.simulated_time:
                self._node.log.warn("time has jumped back by %.3f s: the filter starts again", (last - stamp) * _NS)
                self._start()
            elif stamp < last:
                self._note(name, f"messages of {name} are older than earlier ones, and ignored")
                return
            elif stamp <= self._set_pose_at:
                self._note(name, f"messages of {name} are older than the pose that was set, or have no time: ignored")
                return
            self._last_stamps[name] = stamp
            measurements = self._inputs[name].read(message)
            for measurement in measurements:
                self._estimator.add(measurement)

    def _command(self, twist: Any) -> None:
        control = self._settings.control
        assert control is not None
        linear, angular = twist.linear, twist.angular
        command = np.array((linear.x, linear.y, linear.z, angular.x, angular.y, angular.z))
        if np.isfinite(command).all():
            with self._lock:
                control.command, control.time = command, self._node.now().to_nsec()

    # Publishing -------------------------------------------------------------------------------------------------------

    def _publish(self, time: int) -> None:
        if time <= self._last_published and not self._settings.publishes_corrections:
            return
        self._last_published = time
        settings, stamp = self._settings, Time.from_nsec(time)
        if self._broadcaster is not None:
            self._publish_transform(time)
        if self._odometry.num_connections:
            self._odometry.publish(make_odometry(self._ekf, stamp, settings.world_frame, settings.base_frame))
        if self._acceleration is not None and self._acceleration.num_connections:
            self._acceleration.publish(make_acceleration(self._ekf, stamp, settings.base_frame))
        if self._frequency is not None:
            self._frequency.tick()

    def _publish_transform(self, time: int) -> None:
        settings = self._settings
        pose, parent, child = estimated_pose(self._ekf.state), settings.world_frame, settings.base_frame
        if settings.inverts_tf:
            pose, parent, child = invert(pose), child, parent
        elif settings.world_frame != settings.odom_frame:
            odom = self._frames.find(settings.base_frame, settings.odom_frame, time)
            if odom is None:
                return
            pose, child = multiply(pose, odom.transform), settings.odom_frame
        stamp = Time.from_nsec(max(0, time + round(settings.transform_time_offset / _NS)))
        assert self._broadcaster is not None
        self._broadcaster.send_transform(make_transform(pose, stamp, parent, child))

    def _note(self, key: str, problem: str) -> None:
        self._problems[key] = problem
        self._node.log.warn("%s", problem, throttle=10)

    def _diagnose(self, status: Any) -> None:
        with self._lock:
            problems, self._problems = self._problems, {}
            estimator = self._estimator
            counts = {
                "rejected measurements": estimator.num_rejected,
                "measurements older than the history": estimator.num_too_late,
                "measurements dropped since too many were waiting": estimator.num_dropped,
            }
        if estimator.time is None:
            status.summary(WARN, "no measurements have been received")
        elif problems:
            status.summary(WARN, "some messages are ignored")
        else:
            status.summary(OK, "the filter is running")
        for name, text in {**problems, **counts}.items():
            status.add(name, text)

    # Services ---------------------------------------------------------------------------------------------------------

    def _on_set_pose(self, message: Any) -> None:
        time, settings = message.header.stamp.to_nsec(), self._settings
        frame = self._frames.find(settings.world_frame, message.header.frame_id or settings.world_frame, time)
        mask = np.zeros(SIZE, bool)
        mask[:6] = True
        covariance = np.array(message.pose.covariance, float).reshape(6, 6)
        measurement = frame and PosePart("set_pose", mask, flat=settings.flat).convert(
            time, pose_tuple(message.pose.pose), covariance, frame
        )
        if not measurement or not mask[measurement.indices][:6].all() or len(measurement.indices) < 6:
            raise ServiceRefusal("the pose cannot be converted to world_frame, or it is not finite")
        with self._lock:
            state, full = np.zeros(SIZE), _UNMEASURED_VARIANCE * np.eye(SIZE)
            state[measurement.indices] = measurement.values
            full[measurement.indices[:, None], measurement.indices] = measurement.covariance
            self._start()
            self._set_pose_at = time
            self._estimator.set_state(state, full, self._node.now().to_nsec())
        self._node.log.info("the pose was set to %s", np.round(state[:6], 3).tolist())

    def _on_set_pose_request(self, request: Any) -> Any:
        self._on_set_pose(request.pose)
        return SetPose._response_class()

    def _on_toggle(self, request: Any) -> Any:
        with self._lock:
            changes, self._processes = request.on != self._processes, request.on
        if not changes:
            self._node.log.warn("the filter is already %s", "on" if request.on else "off")
        return ToggleFilterProcessing._response_class(status=changes)

    def _on_enable(self, request: Any) -> Any:
        with self._lock:
            self._enabled = True
        return Empty._response_class()


def find_prefix(node: Node) -> str:
    """Return the parameter tf_prefix of the node or of the nearest namespace; empty if there is none."""
    name = node.params.search("tf_prefix")
    prefix = None if name is None else node.params.get(name)
    return prefix if isinstance(prefix, str) else ""


def main(argv: list[str]) -> int:
    """Run ekf_localization_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "ekf_localization_node", EkfNode)


if __name__ == "__main__":
    sys.exit(main(sys.argv))
