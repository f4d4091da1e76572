"""Transformer and TransformListener: look up transforms as lists, and transform messages."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy
import rospy
import tf2_ros
import yaml

import pyros1.msgs.geometry_msgs.msg as geometry_msgs
import pyros1.msgs.sensor_msgs.msg as sensor_msgs
from tf import transformations
from tf._twist import mean_twist


def strip_leading_slash(s: str) -> str:
    """Return a frame's name without a leading slash."""
    return s[1:] if s.startswith("/") else s


class Transformer:
    """A buffer for the transforms of the last few seconds. Frame names may have a leading slash.

    Args:
        interpolate: not used; kept for old programs.
        cache_time: the Duration for which transforms are kept; None for 10 seconds.
    """

    def __init__(self, interpolate: bool = True, cache_time: Any = None) -> None:
        self._buffer = tf2_ros.Buffer(cache_time, debug=False)
        self._using_dedicated_thread = False

    def allFramesAsDot(self, current_time: Any = None) -> str:
        """Return the tree in Graphviz's dot language, with ages if a time is passed."""
        if current_time:
            return self._buffer._allFramesAsDot(current_time)
        return self._buffer._allFramesAsDot()

    def allFramesAsString(self) -> str:
        """Return a string with a line for each frame that has a parent."""
        return self._buffer.all_frames_as_string()

    def setTransform(self, transform: Any, authority: str = "default_authority") -> None:
        """Add a geometry_msgs/TransformStamped from the node ``authority``."""
        self._buffer.set_transform(transform, authority)

    def canTransform(self, target_frame: str, source_frame: str, time: Any) -> Any:
        """Return whether `lookupTransform` would succeed (1 or 0)."""
        return self._buffer.can_transform(strip_leading_slash(target_frame), strip_leading_slash(source_frame), time)

    def canTransformFull(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> Any:
        """Return whether `lookupTransformFull` would succeed (1 or 0)."""
        target, source, fixed = map(strip_leading_slash, (target_frame, source_frame, fixed_frame))
        return self._buffer.can_transform_full(target, target_time, source, source_time, fixed)

    def waitForTransform(
        self, target_frame: str, source_frame: str, time: Any, timeout: Any, polling_sleep_duration: Any = None
    ) -> None:
        """Wait until `lookupTransform` succeeds.

        Args:
            timeout: maximum Duration to wait.
            polling_sleep_duration: not used; the wait ends as soon as the transform is available.

        Raises:
            tf.Exception: the transform did not become available in time, or no other thread fills this buffer.
        """
        self._check_listening()
        names = strip_leading_slash(target_frame), strip_leading_slash(source_frame)
        _require_transform(*self._buffer.can_transform(*names, time, timeout, return_debug_tuple=True))

    def waitForTransformFull(
        self,
        target_frame: str,
        target_time: Any,
        source_frame: str,
        source_time: Any,
        fixed_frame: str,
        timeout: Any,
        polling_sleep_duration: Any = None,
    ) -> None:
        """Wait until `lookupTransformFull` succeeds; see `waitForTransform`."""
        self._check_listening()
        target, source, fixed = map(strip_leading_slash, (target_frame, source_frame, fixed_frame))
        arguments = (target, target_time, source, source_time, fixed, timeout)
        _require_transform(*self._buffer.can_transform_full(*arguments, return_debug_tuple=True))

    def _check_listening(self) -> None:
        if not self._using_dedicated_thread:
            raise tf2_ros.TransformException(
                "cannot wait for transform without a dedicated thread that listens to incoming TF messages"
            )

    def chain(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> list[str]:
        """Return the names of the frames from source through ``fixed_frame`` to target, including both."""
        return self._buffer._chain(target_frame, target_time, source_frame, source_time, fixed_frame)

    def clear(self) -> None:
        """Remove all transforms except static ones."""
        self._buffer.clear()

    def frameExists(self, frame_id: str) -> bool:
        """Return whether a frame has a parent; its name must be given without a leading slash."""
        return frame_id in self.getFrameStrings()

    def getFrameStrings(self) -> Any:
        """Return the names of the frames that have a parent."""
        return list(yaml.safe_load(self._buffer.all_frames_as_yaml()))

    def getLatestCommonTime(self, source_frame: str, dest_frame: str) -> Any:
        """Return the latest time at which all transforms between two frames are known."""
        return self._buffer.get_latest_common_time(strip_leading_slash(source_frame), strip_leading_slash(dest_frame))

    def lookupTransform(self, target_frame: str, source_frame: str, time: Any) -> tuple[list[float], list[float]]:
        """Return the pose of ``source_frame`` in ``target_frame``.

        Args:
            time: a Time; 0 for the latest time at which all transforms between the two are known.

        Returns:
            Translation [x, y, z] and rotation [x, y, z, w].

        Raises:
            tf.Exception: the transform is not available: LookupException, ConnectivityException or
                ExtrapolationException.
        """
        names = strip_leading_slash(target_frame), strip_leading_slash(source_frame)
        return _to_lists(self._buffer.lookup_transform(*names, time))

    def lookupTransformFull(
        self, target_frame: str, target_time: Any, source_frame: str, source_time: Any, fixed_frame: str
    ) -> tuple[list[float], list[float]]:
        """Return the pose of ``source_frame`` at ``source_time`` in ``target_frame`` at ``target_time``.

        See `lookupTransform`.
        """
        target, source, fixed = map(strip_leading_slash, (target_frame, source_frame, fixed_frame))
        return _to_lists(self._buffer.lookup_transform_full(target, target_time, source, source_time, fixed))

    def lookupTwist(self, tracking_frame: str, observation_frame: str, time: Any, averaging_interval: Any) -> Any:
        """Return the mean velocity of a frame's origin in another frame; see `lookupTwistFull`."""
        return self.lookupTwistFull(
            tracking_frame, observation_frame, observation_frame, (0, 0, 0), tracking_frame, time, averaging_interval
        )

    def lookupTwistFull(
        self,
        tracking_frame: str,
        observation_frame: str,
        reference_frame: str,
        ref_point: Any,
        reference_point_frame: str,
        time: Any,
        averaging_interval: Any,
    ) -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        """Return a frame's mean velocity in another frame over an interval. The linear velocity differs from stock's.

        Args:
            tracking_frame: the frame that moves.
            observation_frame: the frame relative to which it moves.
            reference_frame: the frame of the results.
            ref_point: the point (3,) that moves with the tracked frame.
            reference_point_frame: the frame of that point.
            time: a Time; 0 for the latest.
            averaging_interval: a Duration, centred at that time.

        Returns:
            Linear velocity in m/s, and angular velocity in rad/s.
        """
        return mean_twist(
            self,
            tracking_frame,
            observation_frame,
            reference_frame,
            ref_point,
            reference_point_frame,
            time,
            averaging_interval,
        )

    def setUsingDedicatedThread(self, value: bool) -> None:
        """Declare whether another thread fills this buffer. If none does, waiting raises an exception."""
        self._using_dedicated_thread = value

    def getTFPrefix(self) -> str:
        """Return the prefix of frames, which is always empty."""
        return ""


def _to_lists(message: Any) -> tuple[list[float], list[float]]:
    v, q = message.transform.translation, message.transform.rotation
    return [v.x, v.y, v.z], [q.x, q.y, q.z, q.w]


def _require_transform(is_available: Any, reason: str) -> None:
    if not is_available:
        raise tf2_ros.TransformException(reason or "no such transformation: ")


def xyz_to_mat44(pos: Any) -> Any:
    """Return the matrix (4, 4) that translates by a point or vector message."""
    return transformations.translation_matrix((pos.x, pos.y, pos.z))


def xyzw_to_mat44(ori: Any) -> Any:
    """Return the matrix (4, 4) of a quaternion message."""
    return transformations.quaternion_matrix((ori.x, ori.y, ori.z, ori.w))


class TransformerROS(Transformer):
    """A Transformer that can also transform messages."""

    def asMatrix(self, target_frame: str, hdr: Any) -> Any:
        """Return the matrix (4, 4) that transforms from a header's frame, at its time, to another frame."""
        return self.fromTranslationRotation(*self.lookupTransform(target_frame, hdr.frame_id, hdr.stamp))

    def fromTranslationRotation(self, translation: Sequence[float], rotation: Sequence[float]) -> Any:
        """Return the matrix (4, 4) of a translation (3,) and a quaternion (4,)."""
        return numpy.dot(transformations.translation_matrix(translation), transformations.quaternion_matrix(rotation))

    def transformPoint(self, target_frame: str, ps: Any) -> Any:
        """Transform a geometry_msgs/PointStamped to another frame."""
        point = ps.point
        moved = numpy.dot(self.asMatrix(target_frame, ps.header), (point.x, point.y, point.z, 1.0))[:3]
        result = geometry_msgs.PointStamped()
        _set_header(result, target_frame, ps)
        result.point = geometry_msgs.Point(*moved.tolist())
        return result

    def transformVector3(self, target_frame: str, v3s: Any) -> Any:
        """Transform a geometry_msgs/Vector3Stamped to another frame, by rotating it."""
        vector = v3s.vector
        rotation = self.asMatrix(target_frame, v3s.header)[:3, :3]
        result = geometry_msgs.Vector3Stamped()
        _set_header(result, target_frame, v3s)
        result.vector = geometry_msgs.Vector3(*numpy.dot(rotation, (vector.x, vector.y, vector.z)).tolist())
        return result

    def transformQuaternion(self, target_frame: str, ps: Any) -> Any:
        """Transform a geometry_msgs/QuaternionStamped to another frame."""
        turned = numpy.dot(self.asMatrix(target_frame, ps.header), xyzw_to_mat44(ps.quaternion))
        result = geometry_msgs.QuaternionStamped()
        _set_header(result, target_frame, ps)
        result.quaternion = geometry_msgs.Quaternion(*transformations.quaternion_from_matrix(turned).tolist())
        return result

    def transformPose(self, target_frame: str, ps: Any) -> Any:
        """Transform a geometry_msgs/PoseStamped to another frame."""
        pose = numpy.dot(xyz_to_mat44(ps.pose.position), xyzw_to_mat44(ps.pose.orientation))
        moved = numpy.dot(self.asMatrix(target_frame, ps.header), pose)
        result = geometry_msgs.PoseStamped()
        _set_header(result, target_frame, ps)
        position = geometry_msgs.Point(*moved[:3, 3].tolist())
        orientation = geometry_msgs.Quaternion(*transformations.quaternion_from_matrix(moved).tolist())
        result.pose = geometry_msgs.Pose(position, orientation)
        return result

    def transformPointCloud(self, target_frame: str, point_cloud: Any) -> Any:
        """Transform a sensor_msgs/PointCloud to another frame; the channels do not change."""
        matrix = self.asMatrix(target_frame, point_cloud.header)
        points = numpy.array([(p.x, p.y, p.z) for p in point_cloud.points], numpy.float64).reshape(-1, 3)
        moved = points @ matrix[:3, :3].T + matrix[:3, 3]
        result = sensor_msgs.PointCloud()
        _set_header(result, target_frame, point_cloud)
        result.points = [geometry_msgs.Point32(*point) for point in moved.tolist()]
        result.channels = point_cloud.channels
        return result


def _set_header(message: Any, frame: str, other: Any) -> None:
    """Set the frame of a message, and copy the stamp from another message."""
    message.header.stamp = other.header.stamp
    message.header.frame_id = frame


class TransformListener(TransformerROS):
    """A TransformerROS that is filled from /tf and /tf_static; for the arguments see `Transformer`.

    Raises:
        ROSInitException: the node has not been started.
    """

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._listener = tf2_ros.TransformListener(self._buffer)
        self.setUsingDedicatedThread(True)
