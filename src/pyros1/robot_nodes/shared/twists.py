"""Checks and publishes velocity commands (geometry_msgs/Twist), and stops the robot when the node ends."""

from __future__ import annotations

import threading
from math import isfinite
from typing import TYPE_CHECKING, Any

from pyros1.msgs.geometry_msgs.msg import Twist

if TYPE_CHECKING:
    from pyros1.node import Node


def components(twist: Any) -> tuple[float, float, float, float, float, float]:
    """Return a twist's linear x, y, z in m/s and angular x, y, z in rad/s."""
    linear, angular = twist.linear, twist.angular
    return linear.x, linear.y, linear.z, angular.x, angular.y, angular.z


def is_finite(twist: Any) -> bool:
    """Return whether all components of a twist are finite, so that a robot can follow it."""
    return all(map(isfinite, components(twist)))


class TwistOutput:
    """Publishes twists, and stops the robot with a single zero twist if the last one was not zero.

    It also stops the robot when the node shuts down, and publishes nothing afterwards: callbacks still run at that
    time, and could start the robot again. Thread-safe.

    Args:
        node: the node that publishes.
        topic: the topic to publish.
        latch: whether to latch the topic.
        ends_with_node: False if the owner replaces outputs, and calls `end` itself when the node shuts down.
    """

    def __init__(self, node: Node, topic: str, latch: bool = False, ends_with_node: bool = True) -> None:
        self.publisher = node.advertise(topic, Twist, queue_size=1, latch=latch)
        self._lock = threading.Lock()
        self._is_moving = False
        self._has_ended = False
        if ends_with_node:
            node.on_shutdown(self.end)

    def publish(self, twist: Any) -> None:
        """Publish a twist."""
        with self._lock:
            if not self._has_ended:
                self._is_moving = any(components(twist))
                self.publisher.publish(twist)

    def close(self) -> None:
        """Stop the robot, and unregister the publisher."""
        self.end()
        self.publisher.unregister()

    def end(self) -> None:
        """Stop the robot, and publish nothing afterwards; subscribers still get what was published."""
        with self._lock:
            self._has_ended = True
        self.stop()

    def stop(self) -> bool:
        """Publish a zero twist if the last one was not zero; return whether it was not."""
        with self._lock:
            was_moving, self._is_moving = self._is_moving, False
            if was_moving:
                self.publisher.publish(Twist())
            return was_moving
