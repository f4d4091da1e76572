"""marker_server: converts the pose of a dragged marker to ~cmd_vel.

See https://wiki.ros.org/interactive_marker_twist_server. The marker is on the topics twist_marker_server/update_full,
update and feedback (https://wiki.ros.org/interactive_markers).

The robot is stopped when the marker is released, and when the program that drags it falls silent; with stock, the robot
must notice this itself.
"""

from __future__ import annotations

import threading
from math import isfinite
from typing import Any

from pyros1.ground.terminal_text import one_line
from pyros1.msgs.visualization_msgs.msg import (
    InteractiveMarkerFeedback,
    InteractiveMarkerInit,
    InteractiveMarkerPose,
    InteractiveMarkerUpdate,
)
from pyros1.node import Node
from pyros1.robot_nodes.interactive_marker_twist_server.handle import make_marker, read_settings, twist_for
from pyros1.robot_nodes.shared.node_clock import NodeClock, check_regularly
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.robot_nodes.shared.twists import TwistOutput

TOPIC = "twist_marker_server"
KEEP_ALIVE_PERIOD = 0.5
"""Seconds between keep-alive messages."""
MAX_SILENCE = 1.0
"""Seconds without feedback until the robot is stopped. rviz sends it every 0.25 s while the marker is held."""


class MarkerServer:
    """Provides the marker, and publishes a command for each feedback.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._clock = NodeClock(node)
        self._settings = read_settings(PrivateParameters.of(node))
        self._marker = make_marker(self._settings)
        self._lock = threading.Lock()
        self._sequence_number = 0
        self._received = 0.0
        self._output = TwistOutput(node, "~cmd_vel")
        self._all = node.advertise(f"{TOPIC}/update_full", InteractiveMarkerInit, latch=True)
        self._updates = node.advertise(f"{TOPIC}/update", InteractiveMarkerUpdate)
        self._all.publish(server_id=node.name, seq_num=0, markers=[self._marker])
        node.subscribe(f"{TOPIC}/feedback", InteractiveMarkerFeedback, self._receive, queue_size=100)
        check_regularly(node, KEEP_ALIVE_PERIOD, self._keep_alive)

    def _receive(self, feedback: Any) -> None:
        pose, frame_id = feedback.pose, feedback.header.frame_id.lstrip("/")
        if feedback.marker_name != self._settings.marker_name:
            return
        if frame_id != self._settings.link.lstrip("/"):
            shown = one_line(frame_id, 100)
            self._node.log.error("ignored a pose in %s, which is not %s", shown, self._settings.link, throttle=10)
            return
        position, turn = pose.position, pose.orientation
        if not all(map(isfinite, (position.x, position.y, position.z, turn.x, turn.y, turn.z, turn.w))):
            return
        with self._lock:
            self._received = self._clock.seconds()
            if feedback.event_type == InteractiveMarkerFeedback.MOUSE_UP:
                self._output.stop()
            else:
                self._output.publish(twist_for(pose, self._settings))
            self._snap_back()

    def _snap_back(self) -> None:
        """Move the marker back to the robot, where the next drag begins."""
        self._sequence_number += 1
        pose = InteractiveMarkerPose(self._marker.header, self._marker.pose, self._marker.name)
        common = {"server_id": self._node.name, "seq_num": self._sequence_number}
        self._updates.publish(**common, type=InteractiveMarkerUpdate.UPDATE, poses=[pose])
        self._all.publish(**common, markers=[self._marker])

    def _keep_alive(self) -> None:
        with self._lock:
            self._updates.publish(
                server_id=self._node.name, seq_num=self._sequence_number, type=InteractiveMarkerUpdate.KEEP_ALIVE
            )
            is_silent = not 0 <= self._clock.seconds() - self._received <= MAX_SILENCE
            if is_silent and self._output.stop():
                self._node.log.error("stopped the robot, since no more feedback comes for the marker")


def main(argv: list[str]) -> int:
    """Run marker_server; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "marker_server", MarkerServer)
