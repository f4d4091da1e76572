"""turtle_teleop_key: drives turtle1 with keys (https://wiki.ros.org/turtlesim)."""

from __future__ import annotations

import sys
import threading
from math import pi
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.keys import KeyReader
from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.turtlesim.msg import Pose
from pyros1.msgs.turtlesim.srv import TeleportAbsolute
from pyros1.node import Node

SPEEDS_BY_ARROW = {"up": (1.0, 0.0), "down": (-1.0, 0.0), "left": (0.0, 1.0), "right": (0.0, -1.0)}
"""Arrow key -> speed and angular speed, as multiples of the parameters ``scale_linear`` and ``scale_angular``."""
HEADING_BY_KEY = {
    "g": 0.0,
    "t": pi / 4,
    "r": pi / 2,
    "e": 3 * pi / 4,
    "d": pi,
    "c": -3 * pi / 4,
    "v": -pi / 2,
    "b": -pi / 4,
}
"""Key -> heading to turn to, in radians: the direction from F to the key on the keyboard."""
HELP_TEXT = """\
Reading from keyboard
---------------------------
Use arrow keys to move the turtle.
Use g|b|v|c|d|e|r|t keys to turn in the key's direction as seen from f, and f to stop.
'q' to quit.
"""
_POLL_PERIOD = 0.2
"""Seconds between checks of whether the node has shut down."""
_SERVICE_TIMEOUT = 2.0
"""Maximum number of seconds to wait for the service that turns the turtle."""


class Teleop:
    """Drives turtle1 as keys are pressed.

    Args:
        node: the node, whose parameters ``~scale_linear`` and ``~scale_angular`` are the speeds for an arrow key.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._scales = [_number_param(node, name) for name in ("scale_linear", "scale_angular")]
        self._pose: Any = None
        self._pose_received = threading.Event()
        self._publisher = node.advertise("turtle1/cmd_vel", Twist, queue_size=1)
        self._teleport = node.service("turtle1/teleport_absolute", TeleportAbsolute)
        node.subscribe("turtle1/pose", Pose, self._on_pose, queue_size=1)

    def _on_pose(self, pose: Any) -> None:
        self._pose = pose
        self._pose_received.set()

    def handle_key(self, key: str) -> bool:
        """Handle a pressed key; return False for q, which quits."""
        key = key if key in SPEEDS_BY_ARROW else key.lower()
        if key == "q":
            return False
        if key in SPEEDS_BY_ARROW or key == "f":
            speed, turning = SPEEDS_BY_ARROW.get(key, (0.0, 0.0))
            twist = Twist()
            twist.linear.x, twist.angular.z = speed * self._scales[0], turning * self._scales[1]
            self._publisher.publish(twist)
        elif key in HEADING_BY_KEY:
            self._turn_to(HEADING_BY_KEY[key])
        return True

    def _turn_to(self, theta: float) -> None:
        pose = self._pose
        if pose is None:
            self._node.log.warn("there is no turtle yet: no node publishes %s", self._node.resolve("turtle1/pose"))
            return
        try:
            self._teleport.call(TeleportAbsolute._request_class(pose.x, pose.y, theta), _SERVICE_TIMEOUT)
        except Error as error:
            self._node.log.error("%s", error)

    def wait_for_pose(self, timeout: float) -> bool:
        """Wait for the turtle's first pose; return whether it has arrived within ``timeout`` seconds."""
        return self._pose_received.wait(timeout)


def _number_param(node: Node, name: str) -> float:
    value = node.params.get(f"~{name}", 2.0)
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise Error(f"the parameter ~{name} must be a number")
    return float(value)


def main(argv: list[str]) -> int:
    """Run turtle_teleop_key; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("teleop_turtle", argv=argv[1:]) as node:
        try:
            teleop = Teleop(node)
            with KeyReader() as keys:
                sys.stdout.write(HELP_TEXT)
                sys.stdout.flush()
                while node.ok() and (pressed := keys.read(_POLL_PERIOD)) is not None:
                    if not all(teleop.handle_key(key) for key in pressed):
                        break
        except Error as error:
            node.log.fatal("%s", error)
            return 1
    return 0
