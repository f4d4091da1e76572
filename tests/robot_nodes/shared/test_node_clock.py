"""Robots are stopped even if simulated time never begins: /use_sim_time is set, but nobody publishes /clock."""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.msgs.visualization_msgs.msg import InteractiveMarkerFeedback
from pyros1.robot_nodes.interactive_marker_twist_server.node import MarkerServer
from pyros1.robot_nodes.teleop_twist_joy.node import TeleopNode
from pyros1.robot_nodes.twist_mux.node import TwistMux
from pyros1.robot_nodes.yocs_cmd_vel_mux.node import CmdVelMux

SOURCES = [{"name": "pad", "topic": "in", "timeout": 0.2, "priority": 1}]
CONFIG = "subscribers: [{name: pad, topic: in, timeout: 0.2, priority: 1}]"
COMMAND = Twist()
COMMAND.linear.x = 1.0
DRAGGED = InteractiveMarkerFeedback(marker_name="robot_twist_marker")
DRAGGED.header.frame_id, DRAGGED.pose.position.x, DRAGGED.pose.orientation.w = "base_link", 1.0, 1.0


@pytest.mark.parametrize(
    ("start", "topic", "output", "command"),
    [
        (TwistMux, "/in", "/cmd_vel_out", COMMAND),
        (CmdVelMux, "/driver/in", "/driver/output", COMMAND),
        (MarkerServer, "/twist_marker_server/feedback", "/driver/cmd_vel", DRAGGED),
        (TeleopNode, "/joy", "/cmd_vel", Joy(axes=[0.0, 1.0], buttons=[1])),
    ],
)
def test_a_robot_is_stopped_before_simulated_time_begins(
    make_node: Callable[..., Any], start: Callable[[Any], Any], topic: str, output: str, command: Any
) -> None:
    user, pad = make_node("user"), make_node("pad")
    user.params["/use_sim_time"] = True
    user.params["/driver"] = {"topics": SOURCES, "yaml_cfg_data": CONFIG}
    came: Queue[float] = Queue()
    subscriber = user.subscribe(output, Twist, lambda twist: came.put(twist.linear.x))
    node = make_node("driver")
    running = start(node)
    publisher = pad.advertise(topic, type(command))
    assert publisher.wait_for_subscribers(timeout=20) and subscriber.wait_for_publishers(timeout=20)
    publisher.publish(command)
    assert came.get(timeout=20) > 0.0
    pad.shutdown()
    assert came.get(timeout=20) == 0.0
    del running
