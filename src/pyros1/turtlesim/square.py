"""draw_square: makes turtle1 walk around a square again and again (https://wiki.ros.org/turtlesim)."""

from __future__ import annotations

from math import cos, hypot, pi, sin
from typing import Any

from pyros1.msgs.geometry_msgs.msg import Twist
from pyros1.msgs.std_srvs.srv import Empty
from pyros1.msgs.turtlesim.msg import Pose
from pyros1.node import Node
from pyros1.turtlesim.turtle import STEP_PERIOD, Position, normalize_angle

SIDE_LENGTH = 2.0
"""Length of the square's sides, in units."""
WALKING_SPEED = 1.0
TURNING_SPEED = 0.4
_MIN_MOVING_SPEED = 1e-4
_ANGLE_TOLERANCE = 0.01


class Square:
    """Computes speeds from the turtle's pose: the turtle walks along a side, stops, turns, stops, and so on (no I/O).

    Args:
        x, y, theta: the turtle's initial pose.
    """

    def __init__(self, x: float, y: float, theta: float) -> None:
        self._is_walking = True
        self._is_stopping = False
        self._theta = theta
        self._start = Position(x, y)
        self.goal = self._next_corner()
        """The position and the heading to reach next."""

    def next_speeds(self, x: float, y: float, theta: float, moving: bool) -> tuple[float, float]:
        """Return the next speed (units/s) and angular speed (rad/s).

        Args:
            x, y, theta: the turtle's current pose.
            moving: whether the turtle is moving.
        """
        if self._is_stopping:
            if moving:
                return 0.0, 0.0
            self._is_stopping = False
            self._is_walking = not self._is_walking
            if self._is_walking:
                self._start, self._theta = Position(x, y), theta
                self.goal = self._next_corner()
            else:
                position, heading = self.goal
                self.goal = position, normalize_angle(heading + pi / 2)
        if self._is_walking:
            if hypot(x - self._start.x, y - self._start.y) < SIDE_LENGTH:
                return WALKING_SPEED, 0.0
        elif normalize_angle(self.goal[1] - theta) > _ANGLE_TOLERANCE:
            return 0.0, TURNING_SPEED
        self._is_stopping = True
        return 0.0, 0.0

    def _next_corner(self) -> tuple[Position, float]:
        x, y = self._start
        return Position(x + cos(self._theta) * SIDE_LENGTH, y + sin(self._theta) * SIDE_LENGTH), self._theta


def main(argv: list[str]) -> int:
    """Run draw_square; return its exit code.

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
        rate = node.rate(1 / STEP_PERIOD)
        while node.ok():
            for pose in tuple(latest_pose):
                square = square or Square(pose.x, pose.y, pose.theta)
                moving = max(abs(pose.linear_velocity), abs(pose.angular_velocity)) > _MIN_MOVING_SPEED
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
