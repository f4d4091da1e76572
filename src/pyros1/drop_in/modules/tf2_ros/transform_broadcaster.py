"""TransformBroadcaster: publishes transforms of moving frames."""

from __future__ import annotations

from typing import Any

import rospy

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.tf2_msgs.msg import TFMessage


class TransformBroadcaster:
    """Publishes transforms on /tf.

    Attributes:
        pub_tf: the publisher.
    """

    def __init__(self) -> None:
        self.pub_tf = rospy.Publisher("/tf", TFMessage, queue_size=100)

    def sendTransform(self, transform: Any) -> None:
        """Publish a geometry_msgs/TransformStamped, or a list of them in one message."""
        self.pub_tf.publish(TFMessage(list(transform) if isinstance(transform, (list, tuple)) else [transform]))
