"""draw_square: turtle1 repeatedly walks around a square (https://wiki.ros.org/turtlesim)."""

from __future__ import annotations

from math import cos, hypot, pi, sin
from typing import Any

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.msgs.turtlesim.msg import Pose
from pyros1.node import Node
from pyros1.turtlesim.turtle import PERIOD, Position, normalize_angle

SIDE = 2.0
"""Length of a side in units."""
SPEED = 1.0
ANGULAR_SPEED = 0.4
_MAX_STANDSTILL_SPEED = 1e-4
_ANGLE_TOLERANCE = 0.01


class Square:
    """Computes movements from the turtle's pose: walk along a side, stop, turn, stop, and so on (pure).

    Args:
        x, y, theta: initial pose of the turtle.
    """

    def __init__(self, x: float, y: float, theta: float) -> None:
        self._walking = True
        self._stopping = False
        self._theta = theta
        self._start = Position(x, y)
        self.goal = self._next_corner()
        """Target position and target angle."""

    def next_speeds(self, x: float, y: float, theta: float, moving: bool) -> tuple[float, float]:
        """Return the next speed (units/s) and angular speed (rad/s).

        Args:
            x, y, theta: current pose of the turtle.
            moving: whether the turtle is moving.
        """
        if self._stopping:
            if moving:
                return 0.0, 0.0
            self._stopping = False
            self._walking = not self._walking
            if self._walking:
                self._start, self._theta = Position(x, y), theta
                self.goal = self._next_corner()
            else:
                position, heading = self.goal
                self.goal = position, normalize_angle(heading + pi / 2)
        if self._walking:
            if hypot(x - self._start.x, y - self._start.y) < SIDE:
                return SPEED, 0.0
        elif normalize_angle(self.goal[1] - theta) > _ANGLE_TOLERANCE:
            return 0.0, ANGULAR_SPEED
        self._stopping = True
        return 0.0, 0.0

    def _next_corner(self) -> tuple[Position, float]:
        x, y = self._start
        return Position(x + cos(self._theta) * SIDE, y + sin(self._theta) * SIDE), self._theta


def main(argv: list[str]) -> int:
    """Run the program; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    with Node("draw_square", argv=argv[1:]) as node:
        latest_pose: list[Any] = []

        def on_pose(pose: Any) -> None:
            latest_pose[:] = [pose]

        node.subscribe("turtle1/pose", Pose, on_pose, queue_size=1)
        publisher = node.advertise("turtle1/cmd_vel", Twist, queue_size=1)
        node.wait_for_service("reset")
        node.service("reset", Empty)()
        latest_pose.clear()
        square: Square | None = None
        goal: Any = None
        rate = node.rate(1 / PERIOD)
        while node.ok():
            for pose in tuple(latest_pose):
                square = square or Square(pose.x, pose.y, pose.theta)
                moving = max(abs(pose.linear_velocity), abs(pose.angular_velocity)) > _MAX_STANDSTILL_SPEED
                twist = Twist()
                twist.linear.x, twist.angular.z = square.next_speeds(pose.x, pose.y, pose.theta, moving)
                publisher.publish(twist)
                if square.goal != goal:
                    if goal is not None:
                        node.log.info("Reached goal")
                    goal = square.goal
                    node.log.info("New goal [%f %f, %f]", goal[0].x, goal[0].y, goal[1])
            rate.sleep()
    return 0
