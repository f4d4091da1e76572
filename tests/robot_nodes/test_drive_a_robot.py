"""From a joystick to a robot that moves, with the nodes that robots have between them, and the estimate of its pose."""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.node import Node
from pyros1.robot_nodes.flat_world.simulator import Pace, Simulator
from pyros1.robot_nodes.flat_world.walls import Walls
from pyros1.robot_nodes.flat_world.world import DT, World
from pyros1.robot_nodes.flat_world.world import Settings as WorldSettings
from pyros1.robot_nodes.joy.node import JoyNode
from pyros1.robot_nodes.robot_localization.ekf_node import EkfNode
from pyros1.robot_nodes.teleop_twist_joy.node import TeleopNode
from pyros1.robot_nodes.twist_mux.node import TwistMux
from pyros1.robot_nodes.yocs_velocity_smoother.node import VelocitySmoother

PATIENCE = 30.0
BUTTON, AXIS = 1, 2
PARAMETERS = {
    "/use_sim_time": True,
    # A long timeout: twist_mux is not what stops the robot.
    "/mux/topics": [{"name": "joy", "topic": "joy_vel", "timeout": 1000.0, "priority": 10}],
    "/smoother": {"speed_lim_v": 0.8, "speed_lim_w": 5.4, "accel_lim_v": 1.0, "accel_lim_w": 9.0},
    "/ekf": {
        "two_d_mode": True,
        "base_link_frame": "base_footprint",
        "publish_tf": False,
        "odom0": "odom",
        "odom0_config": [False] * 6 + [True, True] + [False] * 7,
        "imu0": "imu/data",
        "imu0_config": [False] * 5 + [True] + [False] * 5 + [True] + [False] * 3,
    },
}


class Watched:
    """The latest messages of topics, to wait for."""

    def __init__(self, node: Node) -> None:
        self.latest: dict[str, Any] = {}
        self._changed = threading.Condition()
        for topic, kind in (("base_pose_ground_truth", Odometry), ("odometry/filtered", Odometry), ("cmd_vel", Twist)):
            node.subscribe(topic, kind, partial(self._keep, topic))

    def _keep(self, topic: str, message: Any) -> None:
        with self._changed:
            self.latest[topic] = message
            self._changed.notify_all()

    def until(self, condition: Callable[[dict[str, Any]], object]) -> None:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.latest) == 3 and condition(self.latest), PATIENCE)


@pytest.mark.slow
def test_a_joystick_drives_a_robot_and_stops_it_when_it_is_unplugged(
    make_node: Callable[..., Node], joystick: Any
) -> None:
    """Feature: a robot between joystick and estimated pose: joy, teleop_twist_joy, twist_mux, velocity_smoother, ekf"""
    user = make_node("user", wall_time=True)
    for name, value in PARAMETERS.items():
        user.params[name] = value
    watched = Watched(user)
    world = World(Walls(np.zeros((100, 100), np.bool_), 1.0), np.array([[50.0, 50.0, 0.0]]), WorldSettings())
    simulated = Simulator(make_node("world", wall_time=True), world, Pace())
    nodes = [
        EkfNode(make_node("ekf")),
        VelocitySmoother(
            make_node("smoother", argv=["smoother/raw_cmd_vel:=mux_vel", "smoother/smooth_cmd_vel:=cmd_vel"])
        ),
        TwistMux(make_node("mux", argv=["cmd_vel_out:=mux_vel"])),
        TeleopNode(make_node("teleop", argv=["cmd_vel:=joy_vel"])),
        JoyNode(make_node("stick", argv=[f"_dev:={joystick.path}", "_autorepeat_rate:=20"])),
    ]
    user.timer(DT, lambda event: simulated.step())
    joystick.plug()
    joystick.send(BUTTON, 0, 1)
    joystick.send(AXIS, 1, -32767)

    def moved(latest: dict[str, Any]) -> float:
        x: float = latest["base_pose_ground_truth"].pose.pose.position.x
        return x - 50.0

    watched.until(lambda latest: moved(latest) > 0.2)
    joystick.unplug()
    watched.until(
        lambda latest: latest["cmd_vel"] == Twist() and latest["base_pose_ground_truth"].twist.twist.linear.x == 0.0
    )

    def is_followed(latest: dict[str, Any]) -> bool:
        """The estimate begins at 0, where the robot was when its first message came."""
        place, speed = latest["odometry/filtered"].pose.pose.position, latest["odometry/filtered"].twist.twist.linear
        return bool(max(abs(place.x - moved(latest)), abs(place.y), abs(speed.x)) < 0.05)

    watched.until(is_followed)
    del nodes
