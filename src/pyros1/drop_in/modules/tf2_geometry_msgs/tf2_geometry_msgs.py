"""Transforms geometry_msgs messages to other frames, and registers the functions with tf2_ros.

Unlike stock, this needs no PyKDL. As in stock ROS, the results have the transform's header.
"""

from __future__ import annotations

import copy
from typing import Any

import rospy
import tf2_ros

from pyros1.msgs.geometry_msgs.msg import PointStamped, PoseStamped, Vector3Stamped, WrenchStamped
from tf2_geometry_msgs._rotation import Matrix, from_quaternion, multiply, rotate, to_quaternion, transform_point


def to_msg_msg(msg: Any) -> Any:
    """Return the message unchanged: it needs no conversion."""
    return msg


def from_msg_msg(msg: Any) -> Any:
    """Return the message unchanged: it needs no conversion."""
    return msg


for _message_class in (Vector3Stamped, PoseStamped, PointStamped):
    tf2_ros.ConvertRegistration().add_to_msg(_message_class, to_msg_msg)
    tf2_ros.ConvertRegistration().add_from_msg(_message_class, from_msg_msg)


def transform_to_kdl(t: Any) -> Any:
    """Return a geometry_msgs/TransformStamped as PyKDL.Frame.

    Raises:
        ImportError: PyKDL is not installed.
    """
    try:
        import PyKDL  # type: ignore[import-not-found]
    except ImportError:
        raise ImportError("transform_to_kdl needs PyKDL, which is not installed; pyros1 itself does without") from None
    v, q = t.transform.translation, t.transform.rotation
    return PyKDL.Frame(PyKDL.Rotation.Quaternion(q.x, q.y, q.z, q.w), PyKDL.Vector(v.x, v.y, v.z))


def do_transform_point(point: Any, transform: Any) -> Any:
    """Return a PointStamped in another frame, with the header of the TransformStamped."""
    result = PointStamped()
    p, target = point.point, result.point
    target.x, target.y, target.z = transform_point(transform.transform, (p.x, p.y, p.z))
    result.header = transform.header
    return result


def do_transform_vector3(vector3: Any, transform: Any) -> Any:
    """Return a Vector3Stamped in another frame: it is only rotated."""
    result = Vector3Stamped()
    _rotate(result.vector, vector3.vector, _rotation_matrix(transform))
    result.header = transform.header
    return result


def do_transform_pose(pose: Any, transform: Any) -> Any:
    """Return a PoseStamped in another frame, with the header of the TransformStamped."""
    result = PoseStamped()
    p, q = pose.pose.position, pose.pose.orientation
    position, orientation = result.pose.position, result.pose.orientation
    position.x, position.y, position.z = transform_point(transform.transform, (p.x, p.y, p.z))
    rotation = multiply(_rotation_matrix(transform), from_quaternion(q.x, q.y, q.z, q.w))
    orientation.x, orientation.y, orientation.z, orientation.w = to_quaternion(rotation)
    result.header = transform.header
    return result


def do_transform_wrench(wrench: Any, transform: Any) -> Any:
    """Return a WrenchStamped in another frame: force and torque are rotated, but the point of application is not
    moved.
    """
    result = WrenchStamped()
    rotation = _rotation_matrix(transform)
    _rotate(result.wrench.force, wrench.wrench.force, rotation)
    _rotate(result.wrench.torque, wrench.wrench.torque, rotation)
    result.header = transform.header
    return result


def _rotation_matrix(transform: Any) -> Matrix:
    q = transform.transform.rotation
    return from_quaternion(q.x, q.y, q.z, q.w)


def _rotate(target: Any, vector: Any, rotation: Matrix) -> None:
    target.x, target.y, target.z = rotate(rotation, (vector.x, vector.y, vector.z))


tf2_ros.TransformRegistration().add(PointStamped, do_transform_point)
tf2_ros.TransformRegistration().add(Vector3Stamped, do_transform_vector3)
tf2_ros.TransformRegistration().add(PoseStamped, do_transform_pose)
tf2_ros.TransformRegistration().add(WrenchStamped, do_transform_wrench)
