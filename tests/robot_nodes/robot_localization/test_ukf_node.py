"""ukf_localization_node through its topics; the rest of it is ekf_localization_node, with its tests.

Feature: the pose of a robot by an unscented filter -- ukf_localization_node of robot_localization
"""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.node import Node
from pyros1.robot_nodes.robot_localization.ukf import Spread
from pyros1.robot_nodes.robot_localization.ukf_node import make_ukf_node, read_spread
from pyros1.robot_nodes.shared.parameters import PrivateParameters

PATIENCE = 20.0


def test_the_robot_is_followed(make_node: Callable[..., Node]) -> None:
    robot = make_node("robot", wall_time=True)
    used = [False] * 6 + [True, True] + [False] * 3 + [True] + [False] * 3
    robot.params["/ukf"] = {"odom0": "wheels", "odom0_config": used, "frequency": 100, "alpha": "wide"}
    estimates: Queue[Any] = Queue()
    problems: Queue[Any] = Queue()
    robot.subscribe("odometry/filtered", Odometry, estimates.put)
    robot.subscribe("/rosout", Log, problems.put)
    wheels = robot.advertise("wheels", Odometry, queue_size=10)

    def report(event: object) -> None:
        message = Odometry(child_frame_id="base_link")
        message.header.stamp, message.header.frame_id = robot.now(), "odom"
        message.twist.twist.linear.x, message.twist.twist.angular.z = 1.0, 0.5
        message.twist.covariance = (0.01 * np.eye(6)).ravel().tolist()
        wheels.publish(message)

    robot.timer(0.02, report)
    running = make_ukf_node(make_node("ukf"))
    estimate = estimates.get(timeout=PATIENCE)
    while estimate.pose.pose.position.x < 0.3:
        estimate = estimates.get(timeout=PATIENCE)
    # on the circle with a radius of 2 m about (0, 2)
    position = estimate.pose.pose.position
    assert np.hypot(position.x, position.y - 2.0) == pytest.approx(2.0, abs=0.05)
    assert (estimate.header.frame_id, estimate.child_frame_id) == ("odom", "base_link")
    while "alpha" not in problems.get(timeout=PATIENCE).msg:
        pass
    del running


def test_the_parameters_of_the_spread() -> None:
    problems: list[str] = []

    def read(**values: object) -> Spread:
        return read_spread(PrivateParameters(values, problems.append))

    assert read() == Spread(0.001, 0.0, 2.0)
    assert read(alpha=1, kappa=-3.5, beta=0.5) == Spread(1.0, -3.5, 0.5)
    assert not problems
    # With these, the states would all be the estimate itself, or not be numbers.
    assert read(alpha=0, kappa=-15, beta="2") == Spread()
    assert len(problems) == 3
