"""twist_marker: shows commands on twist as an arrow on marker (https://wiki.ros.org/twist_mux)."""

from __future__ import annotations

from functools import partial
from typing import Any

from pyros1.msgs.geometry_msgs.msg import Point, Twist
from pyros1.msgs.visualization_msgs.msg import Marker
from pyros1.node import Node
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node


def make_marker(twist: Any, frame_id: str, scale: float, height: float) -> Any:
    """Return an arrow that points where a command drives the robot: a Marker.

    Args:
        twist: the command. The arrow's forward component is its linear x; the component to the left is its linear y or
            angular z, whichever is larger.
        frame_id: the frame of the robot.
        scale: a factor for the thickness of the arrow.
        height: the arrow's height above the frame's origin, in metres.
    """
    linear, angular = twist.linear, twist.angular
    sideways = linear.y if abs(linear.y) > abs(angular.z) else angular.z
    marker = Marker(type=Marker.ARROW, action=Marker.ADD)
    marker.header.frame_id = frame_id
    # rviz reports an error for arrows without length, so it points slightly up.
    marker.points = [Point(0.0, 0.0, 0.0), Point(linear.x, sideways, 0.01)]
    marker.pose.position.z, marker.pose.orientation.w = height, 1.0
    marker.scale.x, marker.scale.y = 0.05 * scale, 0.1 * scale
    marker.color.g = marker.color.a = 1.0
    return marker


def start(node: Node) -> None:
    """Publish an arrow for each command."""
    values = PrivateParameters.of(node)
    frame_id = values.text("frame_id", "base_footprint")
    scale, height = values.number("scale", 1.0, 0.0), values.number("vertical_position", 2.0)
    publisher = node.advertise("marker", Marker, queue_size=1, latch=True)
    show = partial(make_marker, frame_id=frame_id, scale=scale, height=height)
    node.subscribe("twist", Twist, lambda twist: publisher.publish(show(twist)), queue_size=1)


def main(argv: list[str]) -> int:
    """Run twist_marker; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "twist_marker", start)
