"""velocity_smoother as a node."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from math import nan
from queue import Queue
from typing import Any

import pytest

from pyros1.ground.errors import SettingError
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.reconfigure import Client
from pyros1.robot_nodes.yocs_velocity_smoother.node import VelocitySmoother

Make = Callable[..., Any]
LIMITS = {"speed_lim_v": 0.8, "speed_lim_w": 5.4, "accel_lim_v": 9, "accel_lim_w": 9.0}


def twist(speed: float, turning: float = 0.0) -> Any:
    message = Twist()
    message.linear.x, message.angular.z, message.linear.y = speed, turning, 7.0
    return message


def test_commands_are_limited_and_stopped(
    make_node: Make, next_of: Callable[..., Any], wait_for_line: Callable[[str], None]
) -> None:
    user = make_node("user")
    user.params["/smoother"] = {**LIMITS, "frequency": 100, "robot_feedback": 1, "decel_factor": "much"}
    came: Queue[Any] = Queue()
    smooth = user.subscribe("/cmd_vel", Twist, came.put)
    VelocitySmoother(make_node("smoother", argv=["smoother/smooth_cmd_vel:=cmd_vel", "smoother/odometry:=odom"]))
    assert smooth.wait_for_publishers(1, 20)
    commands = user.advertise("smoother/raw_cmd_vel", Twist)
    assert commands.wait_for_subscribers(timeout=20)
    assert user.advertise("odom", Odometry).wait_for_subscribers(timeout=20)
    with closing(Client(user, "smoother")) as client:
        assert client.update({"speed_lim_w": 1.5})["decel_factor"] == 1.0
    commands.publish(twist(nan))
    wait_for_line("dropped a command, since it is not finite")
    commands.publish(twist(5.0, 5.0))
    seen = next_of(came, lambda twist: twist.linear.x == 0.8)
    assert (seen.angular.z, seen.linear.y) == (1.5, 0.0)
    next_of(came, lambda twist: not (twist.linear.x or twist.angular.z))


def test_feedback_that_does_not_exist(make_node: Make, wait_for_line: Callable[[str], None]) -> None:
    make_node("user").params["/smoother"] = {**LIMITS, "robot_feedback": 7}
    VelocitySmoother(make_node("smoother"))
    wait_for_line("/smoother/robot_feedback must be an integer from 0 to 2, not 7: using 0")


@pytest.mark.parametrize(
    ("values", "problem"),
    [
        ({}, "/smoother needs the parameters speed_lim_v, speed_lim_w, accel_lim_v, accel_lim_w: limits in m/s"),
        ({**LIMITS, "accel_lim_w": None}, "needs the parameters accel_lim_w"),
        ({**LIMITS, "speed_lim_v": "fast"}, "/smoother/speed_lim_v must be a number of at least 0, not 'fast'"),
        ({**LIMITS, "accel_lim_v": -1}, "/smoother/accel_lim_v must be a number of at least 0, not -1"),
    ],
)
def test_limits_must_be_set(make_node: Make, values: dict[str, Any], problem: str) -> None:
    node = make_node("smoother")
    node.params["~"] = {"other": 1} | {name: value for name, value in values.items() if value is not None}
    with pytest.raises(SettingError, match=problem):
        VelocitySmoother(node)
