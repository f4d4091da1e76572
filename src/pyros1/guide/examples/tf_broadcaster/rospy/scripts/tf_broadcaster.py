#!/usr/bin/env python3
"""Publishes where a robot is: it circles the world's origin, with a laser fixed to it.

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


def transform(parent, child, x, y, z, yaw):
    """Return where the child is relative to its parent now, in m and rad."""
    found = TransformStamped()
    found.header.frame_id = parent
    found.header.stamp = rospy.Time.now()
    found.child_frame_id = child
    place = found.transform.translation
    place.x, place.y, place.z = x, y, z
    found.transform.rotation = Quaternion(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return found


def main():
    rospy.init_node("tf_broadcaster")
    fixed = tf2_ros.StaticTransformBroadcaster()
    fixed.sendTransform(transform("base_link", "laser", 0.2, 0.0, 0.3, 0.0))
    moving = tf2_ros.TransformBroadcaster()
    rate = rospy.Rate(20.0)  # Hz
    while not rospy.is_shutdown():
        angle = SPEED * rospy.get_time() % (2 * math.pi)
        x, y = RADIUS * math.cos(angle), RADIUS * math.sin(angle)
        moving.sendTransform(transform("world", "base_link", x, y, 0.0, angle + math.pi / 2))
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C, while it slept
