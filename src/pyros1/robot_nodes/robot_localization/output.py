"""Makes the messages that ekf_localization_node publishes. Pure."""

from __future__ import annotations

from typing import Any

from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import AccelWithCovarianceStamped, TransformStamped
from pyros1.msgs.nav_msgs.msg import Odometry
from pyros1.robot_nodes.robot_localization.ekf import Ekf
from pyros1.robot_nodes.robot_localization.motion import Array
from pyros1.tf.rotation import Transform, from_angles


def estimated_pose(state: Array) -> Transform:
    """Return the pose of a state (15,)."""
    x, y, z, roll, pitch, yaw = state[:6].tolist()
    return (x, y, z, *from_angles(roll, pitch, yaw))


def make_odometry(ekf: Ekf, stamp: Time, world: str, base: str) -> Any:
    """Return the estimate as a nav_msgs/Odometry: the pose in the frame `world`, velocities in the frame `base`."""
    message = Odometry(child_frame_id=base)
    message.header.stamp, message.header.frame_id = stamp, world
    position, rotation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y, position.z, rotation.x, rotation.y, rotation.z, rotation.w = estimated_pose(ekf.state)
    message.pose.covariance = ekf.covariance[:6, :6].ravel().tolist()
    linear, angular = message.twist.twist.linear, message.twist.twist.angular
    linear.x, linear.y, linear.z, angular.x, angular.y, angular.z = ekf.state[6:12].tolist()
    message.twist.covariance = ekf.covariance[6:12, 6:12].ravel().tolist()
    return message


def make_acceleration(ekf: Ekf, stamp: Time, base: str) -> Any:
    """Return the estimated acceleration as a geometry_msgs/AccelWithCovarianceStamped."""
    message = AccelWithCovarianceStamped()
    message.header.stamp, message.header.frame_id = stamp, base
    linear = message.accel.accel.linear
    linear.x, linear.y, linear.z = ekf.state[12:].tolist()
    covariance = [0.0] * 36
    for row in range(3):
        covariance[6 * row : 6 * row + 3] = ekf.covariance[12 + row, 12:].tolist()
    message.accel.covariance = covariance
    return message


def make_transform(pose: Transform, stamp: Time, parent: str, child: str) -> Any:
    """Return a pose as a geometry_msgs/TransformStamped."""
    message = TransformStamped(child_frame_id=child)
    message.header.stamp, message.header.frame_id = stamp, parent
    position, rotation = message.transform.translation, message.transform.rotation
    position.x, position.y, position.z, rotation.x, rotation.y, rotation.z, rotation.w = pose
    return message
