"""BufferClient: lookups in the buffer of another node."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rospy
import tf2_py as tf2

import pyros1.tf
import tf2_ros.buffer_interface
from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import NodeShutdownError
from pyros1.msgs.actionlib_msgs.msg import GoalStatus
from pyros1.msgs.tf2_msgs.msg import LookupTransformAction, LookupTransformGoal

_NO_WAIT = rospy.Duration(0.0)
_PADDING = rospy.Duration(2)


class BufferClient(tf2_ros.buffer_interface.BufferInterface):
    """Client of a buffer server, with the lookups of `Buffer`.

    Args:
        ns: name of the server's action, such as "tf2_buffer_server".
        check_frequency: no longer used.
        timeout_padding: maximum Duration of the communication, in addition to the lookup's timeout.
    """

    def __init__(self, ns: str, check_frequency: Any = None, timeout_padding: Any = _PADDING) -> None:
        super().__init__()
        if check_frequency is not None:
            rospy.logwarn("Argument check_frequency is deprecated and should not be used.")
        if PROCESS.node is None:
            raise rospy.ROSInitException("client code must call rospy.init_node() first")
        self.timeout_padding = timeout_padding
        self.client = pyros1.tf.BufferClient(PROCESS.node, rospy.remap_name(ns), timeout_padding, remap=False)

    def wait_for_server(self, timeout: Any = _NO_WAIT) -> bool:
        """Wait until the server is available, at most for a Duration (0 for no limit); return whether it is."""
        try:
            return self.client.wait_for_server(timeout if timeout else None)
        except NodeShutdownError:
            return False

    def lookup_transform(self, target_frame: str, source_frame: str, time: Any, timeout: Any = _NO_WAIT) -> Any:
        """Return the pose of ``source_frame`` in ``target_frame``; see `Buffer.lookup_transform`.

        Raises:
            TimeoutException: there was no response.
            TransformException: the server's buffer has no such transform.
        """
        return _call_server(lambda: self.client.lookup_transform(target_frame, source_frame, time, timeout))

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = _NO_WAIT,
    ) -> Any:
        """Return the pose of ``source_frame`` at one time in ``target_frame`` at another time.

        See `Buffer.lookup_transform_full`. Raises the same errors as `lookup_transform`.
        """
        arguments = (target_frame, target_time, source_frame, source_time, fixed_frame, timeout)
        return _call_server(lambda: self.client.lookup_transform_full(*arguments))

    def can_transform(self, target_frame: str, source_frame: str, time: Any, timeout: Any = _NO_WAIT) -> bool:
        """Return whether `lookup_transform` succeeds, now or within a timeout."""
        try:
            self.lookup_transform(target_frame, source_frame, time, timeout)
        except tf2.TransformException:
            return False
        return True

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = _NO_WAIT,
    ) -> bool:
        """Return whether `lookup_transform_full` succeeds, now or within a timeout."""
        try:
            self.lookup_transform_full(target_frame, target_time, source_frame, source_time, fixed_frame, timeout)
        except tf2.TransformException:
            return False
        return True


def _call_server(call: Callable[[], Any]) -> Any:
    try:
        return call()
    except (tf2.TimeoutException, NodeShutdownError):
        raise tf2.TimeoutException(
            "The LookupTransform goal sent to the BufferServer did not come back in the specified time. "
            "Something is likely wrong with the server"
        ) from None
