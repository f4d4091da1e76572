"""Buffer: lookups that can wait, and the service ~tf2_frames."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import rosgraph
import rospy
import tf2_py as tf2

import tf2_ros.buffer_interface
from pyros1.msgs.tf2_msgs.srv import FrameGraph, FrameGraphResponse

DEFAULT_CAN_TRANSFORM_POLLING_SCALE = 0.01
_NO_WAIT = rospy.Duration(0.0)
_MAX_JUMP = rospy.Duration(3)
_MIN_POLL, _MAX_POLL = 0.001, 0.02
"""Seconds of wall time between checks of the node's time, while a lookup waits for a transform."""


class Buffer(tf2.BufferCore, tf2_ros.buffer_interface.BufferInterface):
    """Buffer of transforms, with lookups that wait.

    Args:
        cache_time: the Duration for which transforms are kept; None for 10 seconds.
        debug: whether to provide the service ~tf2_frames, unless the node already provides it.
    """

    def __init__(self, cache_time: Any = None, debug: bool = True) -> None:
        if cache_time is None:
            tf2.BufferCore.__init__(self)
        else:
            tf2.BufferCore.__init__(self, cache_time)
        tf2_ros.buffer_interface.BufferInterface.__init__(self)
        self.CAN_TRANSFORM_POLLING_SCALE = DEFAULT_CAN_TRANSFORM_POLLING_SCALE
        if debug:
            try:
                rosgraph.masterapi.Master(rospy.get_name()).lookupService("~tf2_frames")
            except (rosgraph.masterapi.Error, rosgraph.masterapi.Failure):
                self.frame_server = rospy.Service("~tf2_frames", FrameGraph, self.__get_frames)

    def __get_frames(self, req: Any) -> Any:
        return FrameGraphResponse(self.all_frames_as_yaml())

    def lookup_transform(self, target_frame: str, source_frame: str, time: Any, timeout: Any = _NO_WAIT) -> Any:
        """Return the pose of ``source_frame`` in ``target_frame``, as a geometry_msgs/TransformStamped.

        Args:
            target_frame: the target frame.
            source_frame: the source frame.
            time: a Time; 0 for the latest time at which all transforms between the two frames are known.
            timeout: maximum Duration to wait for the transform, in the node's time; shutdown interrupts the wait.

        Raises:
            TransformException: the transform is not available; one of the subclasses in tf2_py.
            ROSInitException: there is a timeout, but no node.
        """
        if timeout != _NO_WAIT:
            self.can_transform(target_frame, source_frame, time, timeout)
        return self.lookup_transform_core(target_frame, source_frame, time)

    def lookup_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = _NO_WAIT,
    ) -> Any:
        """Return the pose of ``source_frame`` at ``source_time`` in ``target_frame`` at ``target_time``.

        ``fixed_frame`` is assumed not to move between the two times. See `lookup_transform`.
        """
        if timeout != _NO_WAIT:
            self.can_transform_full(target_frame, target_time, source_frame, source_time, fixed_frame, timeout)
        return self.lookup_transform_full_core(target_frame, target_time, source_frame, source_time, fixed_frame)

    def can_transform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any = _NO_WAIT, return_debug_tuple: bool = False
    ) -> Any:
        """Return 1 if `lookup_transform` would succeed, now or within a timeout, else 0.

        Args:
            return_debug_tuple: whether to return (1 or 0, reason).
        """
        arguments = (target_frame, source_frame, time)
        if timeout != _NO_WAIT:
            _wait_in_node_time(timeout, lambda seconds: self._wait(seconds, *arguments))
        result = self.can_transform_core(*arguments)
        return result if return_debug_tuple else result[0]

    def can_transform_full(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any = _NO_WAIT,
        return_debug_tuple: bool = False,
    ) -> Any:
        """Return 1 if `lookup_transform_full` would succeed, now or within a timeout, else 0; see `can_transform`."""
        arguments = (target_frame, target_time, source_frame, source_time, fixed_frame)
        if timeout != _NO_WAIT:
            _wait_in_node_time(timeout, lambda seconds: self._wait_full(seconds, *arguments))
        result = self.can_transform_full_core(*arguments)
        return result if return_debug_tuple else result[0]


def _wait_in_node_time(timeout: Any, wait_for_transform: Callable[[float], bool]) -> None:
    """Wait in the node's time; stop if the node shuts down or time jumps back, as when a bag starts again."""
    start = now = rospy.Time.now()
    end = start + timeout
    while now < end and now + _MAX_JUMP >= start and not rospy.is_shutdown():
        if wait_for_transform(min(max((end - now).to_sec(), _MIN_POLL), _MAX_POLL)):
            return
        now = rospy.Time.now()
