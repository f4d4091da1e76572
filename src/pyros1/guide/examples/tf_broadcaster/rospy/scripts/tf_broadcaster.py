#!/usr/bin/env python3
"""Publishes the frames of a robot that circles the origin of the world and carries a laser.

pyros1 run my_package tf_broadcaster.py
pyros1 tf tree                                   world -> base_link -> laser
pyros1 tf echo world laser
"""

import math

import rospy
import tf2_ros
from geometry_msgs.msg import Quaternion, TransformStamped

RADIUS = 2.0  # m
SPEED = 0.5  # rad/s


def make_transform(parent, child, x, y, z, yaw):
    """Return a transform, stamped with the current time: the child's pose relative to its parent, in m and rad."""
    message = TransformStamped()
    message.header.frame_id = parent
    message.header.stamp = rospy.Time.now()
    message.child_frame_id = child
    position = message.transform.translation
    position.x, position.y, position.z = x, y, z
    message.transform.rotation = Quaternion(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return message


def main():
    rospy.init_node("tf_broadcaster")
    static_broadcaster = tf2_ros.StaticTransformBroadcaster()
    static_broadcaster.sendTransform(make_transform("base_link", "laser", 0.2, 0.0, 0.3, 0.0))
    broadcaster = tf2_ros.TransformBroadcaster()
    rate = rospy.Rate(20.0)  # Hz
    while not rospy.is_shutdown():
        angle = SPEED * rospy.get_time() % (2 * math.pi)
        x, y = RADIUS * math.cos(angle), RADIUS * math.sin(angle)
        broadcaster.sendTransform(make_transform("world", "base_link", x, y, 0.0, angle + math.pi / 2))
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C during sleep
