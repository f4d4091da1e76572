"""StaticTransformBroadcaster: publishes transforms that do not change."""

from __future__ import annotations

import copy
import threading
from typing import Any

import rospy

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.tf2_msgs.msg import TFMessage


class StaticTransformBroadcaster:
    """Publishes transforms on /tf_static, latched.

    New subscribers receive only the last message, so each message repeats the earlier transforms (stock's broadcaster
    loses them). A new transform for the same child frame replaces the old one.

    Attributes:
        pub_tf: the publisher.
    """

    def __init__(self) -> None:
        self.pub_tf = rospy.Publisher("/tf_static", TFMessage, queue_size=100, latch=True)
        self._lock = threading.RLock()  # a signal handler may send as well
        self._transforms: dict[str, Any] = {}
        self._changes = 0

    def sendTransform(self, transform: Any) -> None:
        """Publish a geometry_msgs/TransformStamped, or a list of them."""
        with self._lock:
            for item in transform if isinstance(transform, (list, tuple)) else [transform]:
                self._transforms[item.child_frame_id] = copy.deepcopy(item)  # programs may change the object later
            self._changes += 1
            published = 0
            while published != self._changes:  # a signal handler added transforms while this thread was publishing
                published = self._changes
                self.pub_tf.publish(TFMessage(list(self._transforms.values())))
