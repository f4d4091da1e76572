"""The programs of the tf2 tutorials: one publishes a turtle's frame, and one makes a second turtle follow the first.

https://wiki.ros.org/tf2/Tutorials/Introduction%20to%20tf2
"""

from __future__ import annotations

from math import atan2, cos, hypot, sin
from typing import Any

from pyros1.ground.errors import ServiceError
from pyros1.msgs.geometry_msgs.msg import TransformStamped, Twist
from pyros1.msgs.turtlesim.msg import Pose
from pyros1.msgs.turtlesim.srv import Spawn
from pyros1.node import Node
from pyros1.tf import Buffer, TransformBroadcaster, TransformException, TransformListener

_STEPS_PER_SECOND = 10.0
_WORLD = "world"


class Broadcaster:
    """Publishes a turtle's frame relative to the world frame, whenever the turtle's pose arrives.

    Args:
        node: the node that publishes.
        turtle: the turtle's name, which is also the frame's.
    """

    def __init__(self, node: Node, turtle: str) -> None:
        self._node = node
        self._frame = turtle.strip("/")
        self._broadcaster = TransformBroadcaster(node)
        node.subscribe(f"{turtle}/pose", Pose, self._send_transform, queue_size=1)

    def _send_transform(self, pose: Any) -> None:
        transform = TransformStamped()
        transform.header.stamp, transform.header.frame_id = self._node.now(), _WORLD
        transform.child_frame_id = self._frame
        transform.transform.translation.x, transform.transform.translation.y = pose.x, pose.y
        transform.transform.rotation.z, transform.transform.rotation.w = sin(pose.theta / 2), cos(pose.theta / 2)
        self._broadcaster.send_transform(transform)


class Follower:
    """Makes a turtle follow another turtle, whose frames a `Broadcaster` publishes.

    Args:
        node: the node that publishes the follower's speed.
        turtle: name of the turtle that follows.
        leader: name of the turtle that is followed.
    """

    def __init__(self, node: Node, turtle: str, leader: str) -> None:
        self._frames = turtle.strip("/"), leader.strip("/")
        self._buffer = Buffer()
        TransformListener(node, self._buffer)
        self._publisher = node.advertise(f"{turtle}/cmd_vel", Twist, queue_size=1)

    def step(self) -> bool:
        """Publish the follower's next speed; return False if the position of either turtle is unknown."""
        try:
            offset = self._buffer.lookup_transform(*self._frames).transform.translation
        except TransformException:
            return False
        twist = Twist()
        twist.linear.x, twist.angular.z = chase_speeds(offset.x, offset.y)
        self._publisher.publish(twist)
        return True


def chase_speeds(x: float, y: float) -> tuple[float, float]:
    """Return the speed (units/s) and the angular speed (rad/s) with which to follow a point.

    Args:
        x, y: the point in the follower's frame, in units; x is ahead, y to the left.
    """
    return 0.5 * hypot(x, y), 4.0 * atan2(y, x)


def broadcast(argv: list[str]) -> int:
    """Run turtle_tf2_broadcaster; return its exit code.

    The turtle's name is the first argument or, without arguments, the parameter ``~turtle``.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("turtle_tf2_broadcaster", argv=argv[1:]) as node:
        arguments = node.arguments.rest
        turtle = arguments[0] if arguments else node.params.get("~turtle")
        if not isinstance(turtle, str) or not turtle.strip("/"):
            node.log.fatal("no turtle given: run turtle_tf2_broadcaster turtle1, or set the parameter ~turtle")
            return 1
        Broadcaster(node, turtle)
        node.spin()
    return 0


def follow(argv: list[str]) -> int:
    """Run turtle_tf2_listener, which spawns turtle2 (or ``~turtle``), and makes it follow turtle1 (or ``~target``).

    Args:
        argv: the command line, with the program's name.

    Returns:
        The exit code.
    """
    with Node("turtle_tf2_listener", argv=argv[1:]) as node:
        turtle = str(node.params.get("~turtle", "turtle2"))
        follower = Follower(node, turtle, str(node.params.get("~target", "turtle1")))
        node.wait_for_service("spawn")
        try:
            node.service("spawn", Spawn)(4.0, 2.0, 0.0, turtle)
        except ServiceError as error:  # the turtle already exists
            node.log.warn("%s", error)
        rate = node.rate(_STEPS_PER_SECOND)
        while node.ok():
            follower.step()
            rate.sleep()
    return 0
