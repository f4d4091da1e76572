"""TransformBroadcaster: publishes transforms on /tf."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import tf2_ros.transform_broadcaster

import pyros1.msgs.geometry_msgs.msg as geometry_msgs


class TransformBroadcaster:
    """Publishes transforms on /tf.

    Args:
        queue_size: not used; kept for old programs.
    """

    def __init__(self, queue_size: int = 100) -> None:
        self.tf2_broadcaster = tf2_ros.transform_broadcaster.TransformBroadcaster()

    def sendTransform(
        self, translation: Sequence[float], rotation: Sequence[float], time: Any, child: str, parent: str
    ) -> None:
        """Publish the transform of a frame.

        Args:
            translation: x, y, z in meters.
            rotation: a quaternion x, y, z, w.
            time: the stamp, a Time.
            child: the frame.
            parent: the parent frame.
        """
        message = geometry_msgs.TransformStamped()
        message.header.frame_id = parent
        message.header.stamp = time
        message.child_frame_id = child
        v, q = message.transform.translation, message.transform.rotation
        v.x, v.y, v.z = translation[0], translation[1], translation[2]
        q.x, q.y, q.z, q.w = rotation[0], rotation[1], rotation[2], rotation[3]
        self.sendTransformMessage(message)

    def sendTransformMessage(self, transform: Any) -> None:
        """Publish a geometry_msgs/TransformStamped."""
        self.tf2_broadcaster.sendTransform([transform])
