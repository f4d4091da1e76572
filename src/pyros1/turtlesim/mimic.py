"""mimic: makes a turtle copy the movements of another turtle (https://wiki.ros.org/turtlesim)."""

from __future__ import annotations

from typing import Any

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.turtlesim.msg import Pose
from pyros1.node import Node


class Mimic:
    """Publishes the speeds received on input/pose as commands on output/cmd_vel.

    Args:
        node: the node, whose remappings of input and output select the turtles.
    """

    def __init__(self, node: Node) -> None:
        self._publisher = node.advertise("output/cmd_vel", Twist, queue_size=1)
        node.subscribe("input/pose", Pose, self._copy_speeds, queue_size=1)

    def _copy_speeds(self, pose: Any) -> None:
        twist = Twist()
        twist.linear.x, twist.angular.z = pose.linear_velocity, pose.angular_velocity
        self._publisher.publish(twist)


def main(argv: list[str]) -> int:
    """Run mimic; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("turtle_mimic", argv=argv[1:]) as node:
        Mimic(node)
        node.spin()
    return 0
