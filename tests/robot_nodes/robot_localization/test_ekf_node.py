"""ekf_localization_node through its topics and services.

Feature: the pose of a robot from odometry and IMUs -- ekf_localization_node of robot_localization
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from pyros1.ground.errors import ServiceError
from pyros1.ground.timing import Duration, Time
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray
from pyros1.msgs.geometry_msgs.msg import AccelWithCovarianceStamped, PoseWithCovarianceStamped, Twist
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.robot_localization.srv import SetPose, ToggleFilterProcessing
from pyros1.msgs.rosgraph_msgs.msg import Clock, Log
from pyros1.msgs.sensor_msgs.msg import Imu
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.node import Node
from pyros1.robot_nodes.robot_localization.ekf_node import EkfNode
from pyros1.robot_nodes.robot_localization.output import make_transform
from pyros1.tf import StaticTransformBroadcaster, TransformBroadcaster
from pyros1.tf.rotation import IDENTITY

PATIENCE = 20.0
ODOMETRY = {
    "odom0": "wheels",
    "odom0_config": [False] * 6 + [True, True] + [False] * 3 + [True] + [False] * 3,
    "frequency": 100,
}


class Robot:
    """A node that drives at 1 m/s and reports it, beside the node that is tested."""

    def __init__(
        self, make_node: Callable[..., Node], parameters: dict[str, Any], simulated_since: float | None = None
    ) -> None:
        self.node = node = make_node("robot", wall_time=True)
        node.params["/ekf"] = parameters
        self.stamp: Time | None = None
        self.clock: Any = None
        if simulated_since is not None:
            node.params["/use_sim_time"] = True
            self.stamp, self.clock = Time.from_sec(simulated_since), node.advertise("/clock", Clock)
        self.ekf = make_node("ekf")
        self.heard: dict[str, list[Any]] = {}
        self._changed = threading.Condition()
        self._wheels = node.advertise("wheels", Odometry, queue_size=10)
        self._imu = node.advertise("imu", Imu, queue_size=10)
        self.listen("/rosout", Log)
        self.program = EkfNode(self.ekf)
        node.timer(0.02, lambda event: self.report())
        self.speed = 1.0

    def report(self) -> None:
        if self.clock is not None:
            assert self.stamp is not None
            self.stamp += Duration(0, 20_000_000)
            self.clock.publish(self.stamp)
        message = Odometry(child_frame_id="base_link")
        message.header.stamp, message.header.frame_id = self.stamp or self.node.now(), "odom"
        message.twist.twist.linear.x = self.speed
        message.twist.covariance = (0.01 * np.eye(6)).ravel().tolist()
        self._wheels.publish(message)
        imu = Imu(header=message.header)
        imu.header.frame_id, imu.orientation.w, imu.angular_velocity.x = "imu_link", 1.0, 0.25
        self._imu.publish(imu)

    def listen(self, topic: str, kind: Any) -> None:
        self.heard[topic] = []

        def keep(message: Any) -> None:
            with self._changed:
                self.heard[topic].append(message)
                self._changed.notify_all()

        self.node.subscribe(topic, kind, keep)

    def until(self, topic: str, fits: Callable[[Any], object]) -> Any:
        """Wait for a message that fits, among those from now on, and return it."""
        with self._changed:
            begin = 0 if topic == "/rosout" else len(self.heard[topic])
            assert self._changed.wait_for(lambda: any(map(fits, self.heard[topic][begin:])), PATIENCE), topic
            return next(filter(fits, self.heard[topic][begin:]))

    def call(self, service: str, kind: Any, *args: object) -> Any:
        self.node.wait_for_service(service, PATIENCE)
        return self.node.service(service, kind).call(kind._request_class(*args), PATIENCE)


@pytest.fixture
def make_robot(make_node: Callable[..., Node]) -> Callable[..., Robot]:
    return lambda **parameters: Robot(make_node, {**ODOMETRY, **parameters})


def test_the_robot_is_followed(make_robot: Callable[..., Robot]) -> None:
    robot = make_robot(publish_acceleration=True, transform_time_offset=0.5, sensor_timeout=0.2)
    for topic, kind in (("odometry/filtered", Odometry), ("accel/filtered", AccelWithCovarianceStamped)):
        robot.listen(topic, kind)
    robot.listen("/tf", TFMessage)
    robot.listen("/diagnostics", DiagnosticArray)
    near = robot.until("odometry/filtered", lambda message: message.pose.pose.position.x > 0.3)
    assert (near.header.frame_id, near.child_frame_id) == ("odom", "base_link")
    assert near.twist.twist.linear.x == pytest.approx(1.0, abs=0.01)
    assert 0.0 < near.pose.covariance[0] < 1.0
    assert near.twist.covariance[35] < 0.01
    (transform,) = robot.until("/tf", lambda message: True).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("odom", "base_link")
    assert transform.transform.translation.x > 0.3
    assert transform.header.stamp > near.header.stamp
    assert robot.until("accel/filtered", lambda message: True).header.frame_id == "base_link"
    status = robot.until("/diagnostics", lambda message: message.status[0].level == 0 and message.status[0].values)
    assert status.status[0].name == "ekf: Filter diagnostic updater"
    stamps = [message.header.stamp for message in robot.heard["odometry/filtered"]]
    assert stamps == sorted(set(stamps)), "no time is published twice"

    robot.stamp = Time(1)
    robot.until("/rosout", lambda message: "older than earlier ones" in message.msg)
    # What no sensor reports any more is predicted.
    far = robot.until("odometry/filtered", lambda message: message.header.stamp > near.header.stamp)
    assert far.pose.pose.position.x > near.pose.pose.position.x


def test_the_pose_can_be_set(make_robot: Callable[..., Robot]) -> None:
    robot = make_robot(print_diagnostics=False, publish_tf=False)
    robot.listen("odometry/filtered", Odometry)
    robot.until("odometry/filtered", lambda message: True)
    pose = PoseWithCovarianceStamped()
    pose.header.stamp, pose.header.frame_id = robot.node.now(), "odom"
    pose.pose.pose.position.y, pose.pose.pose.orientation.w = 40.0, 1.0
    robot.call("set_pose", SetPose, pose)
    robot.until("odometry/filtered", lambda message: message.pose.pose.position.y == pytest.approx(40.0, abs=0.1))
    publisher = robot.node.advertise("set_pose", PoseWithCovarianceStamped, latch=True)
    pose.pose.pose.position.y = -40.0
    publisher.publish(pose)
    robot.until("odometry/filtered", lambda message: message.pose.pose.position.y == pytest.approx(-40.0, abs=0.1))
    pose.header.frame_id = "moon"
    with pytest.raises(ServiceError, match="cannot be converted"):
        robot.call("set_pose", SetPose, pose)


def test_what_is_older_than_the_pose_that_was_set_is_ignored(make_robot: Callable[..., Robot]) -> None:
    robot = make_robot()
    pose = PoseWithCovarianceStamped()
    pose.header.stamp = robot.node.now() + Duration(1000)
    robot.call("set_pose", SetPose, pose)
    robot.until("/rosout", lambda message: "older than the pose that was set" in message.msg)


def test_time_that_jumps_back_restarts_the_filter(make_node: Callable[..., Node]) -> None:
    robot = Robot(make_node, {**ODOMETRY, "reset_on_time_jump": True}, simulated_since=100.0)
    robot.listen("odometry/filtered", Odometry)
    robot.until("odometry/filtered", lambda message: message.pose.pose.position.x > 0.3)
    robot.stamp = Time(50)
    robot.until("/rosout", lambda message: "time has jumped back by 5" in message.msg)
    robot.until("odometry/filtered", lambda message: message.header.stamp < Time(60))


def test_the_transform_can_be_inverted(make_robot: Callable[..., Robot]) -> None:
    robot = make_robot(invert_tf=True)
    robot.listen("/tf", TFMessage)
    (transform,) = robot.until("/tf", lambda message: message.transforms[0].transform.translation.x < -0.1).transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("base_link", "odom")


def test_the_filter_can_be_switched_off(make_robot: Callable[..., Robot]) -> None:
    robot = make_robot(disabled_at_startup=True)
    robot.listen("odometry/filtered", Odometry)
    robot.call("/ekf/enable", Empty)
    robot.until("odometry/filtered", lambda message: message.pose.pose.position.x > 0.05)
    assert robot.call("/ekf/toggle", ToggleFilterProcessing, False).status is True
    assert robot.call("/ekf/toggle", ToggleFilterProcessing, False).status is False
    position = robot.until("odometry/filtered", lambda message: True).pose.pose.position.x
    assert robot.until("odometry/filtered", lambda message: True).pose.pose.position.x == position
    assert robot.call("/ekf/toggle", ToggleFilterProcessing, True).status is True
    robot.until("odometry/filtered", lambda message: message.pose.pose.position.x > position + 0.05)


def test_sensors_are_found_by_tf_and_the_map_moves_odom(make_robot: Callable[..., Robot]) -> None:
    imu = {"imu0": "imu", "imu0_config": [False] * 9 + [True] + [False] * 5}
    robot = make_robot(world_frame="map", two_d_mode=False, **imu)
    mounted = (0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0)  # it looks backwards
    robot.listen("/tf", TFMessage)
    robot.listen("odometry/filtered", Odometry)
    StaticTransformBroadcaster(robot.node).send_transform(
        make_transform(mounted, robot.node.now(), "base_link", "imu_link")
    )
    broadcaster = TransformBroadcaster(robot.node)

    def send(event: object) -> None:
        broadcaster.send_transform(make_transform((5.0, *IDENTITY[1:]), robot.node.now(), "odom", "base_link"))

    robot.node.timer(0.05, send)
    robot.until("odometry/filtered", lambda message: message.twist.twist.angular.x == pytest.approx(-0.25, abs=0.02))
    message = robot.until("/tf", lambda message: message.transforms[0].header.frame_id == "map")
    assert message.transforms[0].child_frame_id == "odom"
    assert message.transforms[0].transform.translation.x < -3.0


def test_commands_are_anticipated(make_robot: Callable[..., Robot]) -> None:
    robot = make_robot(
        use_control=True,
        control_config=[True, False, False, False, False, False],
        acceleration_limits=[50.0] * 6,
        acceleration_gains=[50.0] * 6,
        control_timeout=1000.0,
    )
    robot.listen("odometry/filtered", Odometry)
    command = Twist()
    command.linear.x = 9.0
    robot.node.advertise("cmd_vel", Twist, latch=True).publish(command)
    robot.until("odometry/filtered", lambda message: message.twist.twist.linear.x > 1.2)


@pytest.mark.parametrize(
    ("parameters", "problem"),
    [
        ({"world_frame": "moon"}, "world_frame is moon, but it must be odom_frame (odom) or map_frame (map)"),
        ({"map_frame": "odom"}, "map_frame, odom_frame and base_link_frame must be different"),
        ({"odom0_config": [False] * 15}, "no sensors are configured"),
        ({"process_noise_covariance": [1e308] * 225}, "the estimate is no longer finite"),
    ],
)
def test_problems_are_reported(make_robot: Callable[..., Robot], parameters: dict[str, Any], problem: str) -> None:
    robot = make_robot(**parameters)
    assert robot.until("/rosout", lambda message: problem in message.msg).name == "/ekf"
