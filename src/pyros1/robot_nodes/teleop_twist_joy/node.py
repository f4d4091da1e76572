"""teleop_node: converts joy to cmd_vel, which is latched (https://wiki.ros.org/teleop_twist_joy).

If the last publisher of joy disappears while the robot is driving, the robot is stopped, although nobody has released
the button. Silence alone does not stop it, since a joystick that is held still may send nothing for any length of time.
"""

from __future__ import annotations

import threading
from typing import Any

from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.node import Node
from pyros1.robot_nodes.shared.node_clock import check_regularly
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.robot_nodes.shared.twists import TwistOutput
from pyros1.robot_nodes.teleop_twist_joy.teleop import Teleop, read_controls

WATCH_PERIOD = 0.2
"""Seconds between checks that joy has a publisher."""


class TeleopNode:
    """Publishes a command for each state of the joystick.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        controls = read_controls(PrivateParameters.of(node))
        if controls.enable_button < 0:
            node.log.warn("enable_button is negative: the robot drives without a button being pressed")
        self._node = node
        self._teleop = Teleop(controls)
        self._output = TwistOutput(node, "cmd_vel", latch=True)
        self._lock = threading.Lock()
        self._subscriber = node.subscribe("joy", Joy, self._receive, queue_size=1)
        check_regularly(node, WATCH_PERIOD, self._check_publishers)

    def _receive(self, joy: Any) -> None:
        with self._lock:
            twist = self._teleop.handle(joy.axes, joy.buttons)
            if twist is not None:
                self._output.publish(twist)

    def _check_publishers(self) -> None:
        if self._subscriber.num_connections == 0 and self._output.stop():
            self._node.log.error("%s has no publishers left: stopped the robot", self._node.resolve("joy"))


def main(argv: list[str]) -> int:
    """Run teleop_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "teleop_twist_joy_node", TeleopNode)
