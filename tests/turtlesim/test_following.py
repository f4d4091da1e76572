"""Frames of turtles, and the turtle that follows another one."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, pi, sin
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.turtlesim.msg import Pose
from pyros1.tf import Buffer, TransformListener
from pyros1.turtlesim.following import Broadcaster, Follower, chase_speeds
from pyros1.turtlesim.mimic import Mimic
from pyros1.turtlesim.turtle import STEP_PERIOD, Turtle, normalize_angle

PATIENCE = 20.0
Make = Callable[..., Any]


@pytest.mark.parametrize("theta", [0.0, 2.0, -3.0])
def test_one_that_chases_arrives(theta: float) -> None:
    turtle = Turtle(x=1.0, y=1.0, theta=theta)
    for step in range(1000):
        now = step * STEP_PERIOD
        far, angle = hypot(9 - turtle.x, 7 - turtle.y), atan2(7 - turtle.y, 9 - turtle.x) - turtle.theta
        if step % 6 == 0:
            forward, turning = chase_speeds(far * cos(angle), far * sin(angle))
            turtle.command(forward, 0.0, turning, now)
        turtle.step(now)
    assert far < 0.1


def test_frames_and_commands(make_node: Make) -> None:
    told, follower_node = make_node("told"), make_node("follower")
    for turtle in ("turtle1", "turtle2"):
        Broadcaster(make_node(f"broadcaster_{turtle}"), turtle)
    poses = {name: told.advertise(f"{name}/pose", Pose) for name in ("turtle1", "turtle2")}
    came: Queue[Any] = Queue()
    told.subscribe("turtle2/cmd_vel", Twist, came.put)
    follower = Follower(follower_node, "turtle2", "turtle1")
    assert not follower.step()
    buffer = Buffer()
    TransformListener(told, buffer)

    def tell(event: object) -> None:
        poses["turtle1"].publish(4.0, 6.0, 1.0, 0.0, 0.0)
        poses["turtle2"].publish(4.0, 2.0, pi / 2, 0.0, 0.0)

    told.timer(0.02, tell)
    found = buffer.lookup_transform("turtle2", "turtle1", timeout=PATIENCE).transform
    assert (found.translation.x, found.translation.y) == pytest.approx((4.0, 0.0), abs=1e-6)
    assert 2 * atan2(found.rotation.z, found.rotation.w) == pytest.approx(normalize_angle(1.0 - pi / 2), abs=1e-6)
    world = buffer.lookup_transform("world", "turtle1").transform
    assert (world.translation.x, world.translation.y, world.translation.z) == (4.0, 6.0, 0.0)
    rate = told.rate(50)
    while not follower.step():
        rate.sleep()
    twist = came.get(timeout=PATIENCE)
    assert (twist.linear.x, twist.angular.z) == pytest.approx((2.0, 0.0), abs=1e-6)


def test_mimic(make_node: Make, transport: str) -> None:
    user = make_node("user")
    Mimic(make_node("mimic", argv=["input/pose:=/a/turtle1/pose", "output/cmd_vel:=/b/turtle1/cmd_vel"]))
    came: Queue[Any] = Queue()
    assert user.subscribe("/b/turtle1/cmd_vel", Twist, came.put).wait_for_publishers(timeout=PATIENCE)
    user.advertise("/a/turtle1/pose", Pose, latch=True).publish(1.0, 2.0, 3.0, 0.5, -0.25)
    twist = came.get(timeout=PATIENCE)
    assert (twist.linear.x, twist.angular.z) == (0.5, -0.25)
