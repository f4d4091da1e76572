"""twist_mux and twist_marker as nodes."""

from __future__ import annotations

from collections.abc import Callable
from math import nan
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.std_msgs.msg import Bool
from pyros1.msgs.visualization_msgs.msg import Marker
from pyros1.robot_nodes.twist_mux import marker
from pyros1.robot_nodes.twist_mux.node import TwistMux, main

Make = Callable[..., Any]
TOPICS = [
    {"name": "joy", "topic": "joy_teleop/cmd_vel", "timeout": 0.3, "priority": 10},
    {"name": "external", "topic": "cmd_vel", "timeout": 60, "priority": 1},
]
LOCKS = [{"name": "e_stop", "topic": "e_stop", "timeout": 0.0, "priority": 255}]


def twist(speed: float) -> Any:
    message = Twist()
    message.linear.x = speed
    return message


def test_the_robot_is_driven_and_stopped(
    make_node: Make, next_of: Callable[..., Any], wait_for_line: Callable[[str], None]
) -> None:
    """Feature: twist_mux selects by priority, and stops the robot when its source is silent or locked"""
    user = make_node("user")
    user.params["/mux/topics"], user.params["/mux/locks"] = TOPICS, LOCKS
    came: Queue[Any] = Queue()
    subscriber = user.subscribe("/base/cmd_vel", Twist, came.put)
    mux = make_node("mux", argv=["cmd_vel_out:=base/cmd_vel"])
    TwistMux(mux)
    joy, other = (user.advertise(topic["topic"], Twist) for topic in TOPICS)
    lock = user.advertise("e_stop", Bool)
    for publisher in (joy, other, lock):
        assert publisher.wait_for_subscribers(timeout=20)
    assert subscriber.wait_for_publishers(timeout=20)

    def speeds(*expected: float) -> None:
        for speed in expected:
            assert came.get(timeout=20).linear.x == speed

    joy.publish(twist(1.0))
    speeds(1.0)
    other.publish(twist(2.0))
    joy.publish(twist(nan))
    speeds(0.0)
    wait_for_line("dropped a command on /joy_teleop/cmd_vel, since it is not finite")
    other.publish(twist(3.0))
    next_of(came, lambda twist: twist.linear.x == 3.0)  # after 2.0, if that came when joy had timed out
    lock.publish(True)
    speeds(0.0)
    other.publish(twist(4.0))
    lock.publish(False)
    statuses: Queue[Any] = Queue()
    user.subscribe("/diagnostics", DiagnosticArray, lambda array: statuses.put(array.status[0]))
    status = next_of(statuses, lambda status: any("free" in value.value for value in status.values))
    values = {value.key: value.value for value in status.values}
    assert values["velocity external"].startswith(("unmasked (", "masked (")) and status.name == "mux: Twist mux status"
    assert (status.level, status.message) == (0, "ok")
    assert values["lock e_stop"] == "free (listening to e_stop @ 0.000000s with priority #255)"
    other.publish(twist(5.0))
    next_of(came, lambda twist: twist.linear.x == 5.0)
    mux.shutdown()
    speeds(0.0)


def test_what_cannot_be_used_ends_the_program(
    environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, make_node: Make, capfd: pytest.CaptureFixture[str]
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    make_node("user").params["/twist_mux/locks"] = [{"name": "e_stop", "topic": "e_stop"}]
    assert main(["twist_mux"]) == 1
    assert "/twist_mux/locks[0] (e_stop) needs a timeout, a number of at least 0, not None" in capfd.readouterr().err


@pytest.mark.parametrize(("y", "turning", "sideways"), [(0.5, -0.2, 0.5), (0.1, -0.2, -0.2)])
def test_marker(y: float, turning: float, sideways: float) -> None:
    command = twist(0.5)
    command.linear.y, command.angular.z = y, turning
    arrow = marker.make_marker(command, "base", 2.0, 1.5)
    assert (arrow.header.frame_id, arrow.type, arrow.pose.position.z) == ("base", Marker.ARROW, 1.5)
    assert (arrow.points[1].x, arrow.points[1].y) == (0.5, sideways)
    assert (arrow.scale.x, arrow.scale.y, arrow.color.g, arrow.color.a) == (0.1, 0.2, 1.0, 1.0)


def test_marker_node(make_node: Make) -> None:
    user = make_node("user")
    came: Queue[Any] = Queue()
    subscriber = user.subscribe("marker", Marker, came.put)
    marker.start(make_node("twist_marker"))
    assert subscriber.wait_for_publishers(timeout=20)
    user.advertise("twist", Twist, latch=True).publish(twist(0.5))
    arrow = came.get(timeout=20)
    assert (arrow.header.frame_id, arrow.pose.position.z, arrow.points[1].x) == ("base_footprint", 2.0, 0.5)
