"""joy_remap.py: makes the messages of one joystick look like those of another (https://wiki.ros.org/joy).

Joy messages on joy_in are published on joy_out, with axes and buttons computed by the expressions in ``~mappings/axes``
and ``~mappings/buttons``. The package's ``config/ps4joy.yaml`` makes a PS4 controller look like a PS3 controller.

If the last publisher of joy_in goes away, this node publishes all axes and buttons as 0, as joy_node does when the
joystick is unplugged: nodes that watch for the loss of joy_out's publisher cannot notice it, but the robot must stop.
"""

from __future__ import annotations

import threading
from functools import partial
from typing import Any

from pyros1.msgs.sensor_msgs.msg import Joy
from pyros1.node import Node
from pyros1.robot_nodes.joy.remapping import Remapping
from pyros1.robot_nodes.shared.node_clock import check_regularly
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node

WATCH_PERIOD = 0.2
"""Seconds between checks that joy_in has a publisher."""


class JoyRemap:
    """Publishes a converted message for each state of the joystick.

    Args:
        node: the node.

    Raises:
        Error: a parameter is not a list of well-formed expressions.
    """

    def __init__(self, node: Node) -> None:
        values = PrivateParameters.of(node)
        axes, buttons = values.value("mappings/axes") or [], values.value("mappings/buttons") or []
        if not axes and not buttons:
            node.log.warn("~mappings/axes and ~mappings/buttons are not set, so the messages on joy_out are empty")
        self._node = node
        self._convert = Remapping(axes, buttons, partial(node.log.error, "%s", throttle=5))
        self._lock = threading.Lock()
        self._last: Any = None
        self._output = node.advertise("joy_out", Joy, queue_size=1)
        queue_size = values.integer("queue_size", 0, minimum=0) or None
        self._subscriber = node.subscribe("joy_in", Joy, self._receive, queue_size=queue_size)
        check_regularly(node, WATCH_PERIOD, self._check_publishers)

    def _receive(self, joy: Any) -> None:
        axes, buttons = self._convert(joy.axes, joy.buttons)
        with self._lock:
            self._last = Joy(header=joy.header, axes=axes, buttons=buttons)
            self._output.publish(self._last)

    def _check_publishers(self) -> None:
        with self._lock:
            if self._last is None or self._subscriber.num_connections:
                return
            released = Joy(axes=[0.0] * len(self._last.axes), buttons=[0] * len(self._last.buttons))
            released.header.stamp, released.header.frame_id = self._node.now(), self._last.header.frame_id
            self._last = None
            self._output.publish(released)
        self._node.log.error("nobody publishes %s any more: released all buttons", self._node.resolve("joy_in"))


def main(argv: list[str]) -> int:
    """Run joy_remap.py; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "joy_remap", JoyRemap)
