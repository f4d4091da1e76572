"""From a joystick that is unplugged to a robot that stands still."""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from typing import Any

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.robot_nodes.joy.node import JoyNode
from pyros1.robot_nodes.teleop_twist_joy.node import TeleopNode

Make = Callable[..., Any]


def test_a_joystick_that_disappears_stops_the_robot(
    make_node: Make, joystick: Any, next_of: Callable[..., Any], transport: str
) -> None:
    """Feature: a joystick that is unplugged stops the robot"""
    came: Queue[Any] = Queue()
    make_node("robot").subscribe("cmd_vel", Twist, came.put)
    TeleopNode(make_node("teleop"))
    JoyNode(make_node("stick", argv=[f"_dev:={joystick.path}", "_autorepeat_rate:=50"]))
    joystick.plug()
    joystick.send(1, 0, 1)
    joystick.send(2, 1, -32767)
    assert next_of(came, lambda twist: twist.linear.x).linear.x == 0.5
    joystick.unplug()
    next_of(came, lambda twist: not twist.linear.x)
    assert came.empty(), "nothing follows the stop"


def test_joy_without_a_publisher_stops_the_robot(make_node: Make, next_of: Callable[..., Any]) -> None:
    came: Queue[Any] = Queue()
    make_node("robot").subscribe("cmd_vel", Twist, came.put)
    driver = make_node("driver")
    joy = driver.advertise("joy", Joy, latch=True)
    joy.publish(Joy(axes=[0.0, 1.0], buttons=[1]))
    TeleopNode(make_node("teleop"))
    next_of(came, lambda twist: twist.linear.x)
    driver.shutdown()
    next_of(came, lambda twist: not twist.linear.x)
    late: Queue[Any] = Queue()
    make_node("late").subscribe("cmd_vel", Twist, late.put)
    assert late.get(timeout=20) == Twist(), "the topic is latched"
