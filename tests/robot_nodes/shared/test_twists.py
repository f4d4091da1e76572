"""Zero twists that stop a robot."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, nan
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.geometry_msgs.msg import Twist, Vector3
from pyros1.robot_nodes.shared.twists import TwistOutput, components, is_finite


@pytest.mark.parametrize("component", range(6))
def test_components(component: int) -> None:
    values = [0.0] * 6
    values[component] = 1.5
    twist = Twist(Vector3(*values[:3]), Vector3(*values[3:]))
    assert components(twist) == tuple(values) and is_finite(twist)
    for bad in (nan, inf, -inf):
        values[component] = bad
        assert not is_finite(Twist(Vector3(*values[:3]), Vector3(*values[3:])))


def test_a_robot_is_stopped_once(make_node: Callable[..., Any]) -> None:
    came: Queue[Any] = Queue()
    make_node("robot").subscribe("cmd_vel", Twist, came.put, in_publisher=True)
    driver = make_node("driver")
    output = TwistOutput(driver, "cmd_vel")
    assert output.publisher.wait_for_subscribers(timeout=20)
    assert not output.stop()
    output.publish(Twist(Vector3(), Vector3(0.0, 0.0, 0.5)))
    assert output.stop() and not output.stop()
    output.publish(Twist(Vector3(0.0, -0.5, 0.0), Vector3()))
    driver.shutdown()
    assert [any(components(came.get(timeout=20))) for _ in range(4)] == [True, False, True, False]
    assert came.empty()


def test_commands_that_come_while_the_node_shuts_down_do_not_start_the_robot_again(
    make_node: Callable[..., Any],
) -> None:
    came: Queue[Any] = Queue()
    make_node("robot").subscribe("cmd_vel", Twist, came.put, in_publisher=True)
    driver = make_node("driver")
    output = TwistOutput(driver, "cmd_vel")
    assert output.publisher.wait_for_subscribers(timeout=20)
    command = Twist(Vector3(0.5, 0.0, 0.0), Vector3())
    output.publish(command)
    driver.on_shutdown(lambda: output.publish(command))  # as callbacks do, which still run at this time
    driver.shutdown()
    assert [any(components(came.get(timeout=20))) for _ in range(2)] == [True, False]
    assert came.empty()
