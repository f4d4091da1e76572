"""joint_state_publisher: publishes a robot's joint states on joint_states.

See https://wiki.ros.org/joint_state_publisher.
"""

from __future__ import annotations

import sys
import threading
from typing import Any

from pyros1.ground.errors import Error
from pyros1.msgs.sensor_msgs.msg import JointState
from pyros1.node import Node
from pyros1.urdf.description import make_parameter_getter, robot_description
from pyros1.urdf.joints import SLIDERS_TOPIC, JointStates, read_options
from pyros1.urdf.reading import read_robot

_QUEUE_SIZE = 100


class JointStatePublisher:
    """Publishes the states of a robot's joints, and updates them from other topics.

    Args:
        node: the node that publishes.
        states: the joints' states.
    """

    def __init__(self, node: Node, states: JointStates) -> None:
        self._node = node
        self._states = states
        self._lock = threading.Lock()
        self._publisher = node.advertise("joint_states", JointState, queue_size=_QUEUE_SIZE)
        own_topic = node.resolve("joint_states")
        for source in (*states.options.source_list, f"~{SLIDERS_TOPIC}"):
            if node.resolve(source) == own_topic:
                node.log.error("%s in source_list is ignored, since this node itself publishes on it", own_topic)
                continue
            node.subscribe(source, JointState, self._receive, queue_size=_QUEUE_SIZE)

    def _receive(self, message: Any) -> None:
        with self._lock:
            self._states.apply(message.name, message.position, message.velocity, message.effort)

    def publish(self) -> None:
        """Publish the joints' states once."""
        with self._lock:
            self._states.step()
            names, positions, velocities, efforts = self._states.message_fields()
        if not names:
            return  # as in stock ROS, nothing is published for a robot without movable joints
        message = JointState(name=names, position=positions, velocity=velocities, effort=efforts)
        message.header.stamp = self._node.now()
        self._publisher.publish(message)

    def run(self) -> None:
        """Publish the joints' states periodically until the node shuts down."""
        rate = self._node.rate(self._states.options.rate)
        while self._node.ok():
            self.publish()
            rate.sleep()


def make_publisher(node: Node) -> JointStatePublisher:
    """Create a publisher as described by a node's parameters, and log warnings about problems in them.

    Raises:
        UrdfError: the description or a parameter is invalid.
    """
    states = JointStates(read_robot(robot_description(node)), read_options(make_parameter_getter(node)))
    for warning in states.warnings:
        node.log.warn("%s", warning)
    return JointStatePublisher(node, states)


def main(argv: list[str]) -> int:
    """Run joint_state_publisher; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("joint_state_publisher", argv=argv[1:]) as node:
        try:
            publisher = make_publisher(node)
        except Error as error:
            node.log.fatal("%s", error)
            return 1
        if node.params.get("~use_gui", False):
            node.log.warn("the parameter use_gui does nothing: sliders are in joint_state_publisher_gui now")
        publisher.run()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv))
