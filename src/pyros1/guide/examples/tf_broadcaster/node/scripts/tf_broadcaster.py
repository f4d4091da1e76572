#!/usr/bin/env python3
"""Publishes the frames of a robot that circles the origin of the world and carries a laser.

pyros1 run my_package tf_broadcaster.py
pyros1 tf tree                                   world -> base_link -> laser
pyros1 tf echo world laser
"""

import math

import pyros1
from pyros1.msgs.geometry_msgs.msg import Quaternion, TransformStamped
from pyros1.tf import StaticTransformBroadcaster, TransformBroadcaster

RADIUS = 2.0  # m
SPEED = 0.5  # rad/s


def make_transform(parent, child, x, y, z, yaw):
    """Return a transform, stamped with the current time: the child's pose relative to its parent, in m and rad."""
    message = TransformStamped(child_frame_id=child)
    message.header.frame_id = parent
    message.header.stamp = node.now()
    position = message.transform.translation
    position.x, position.y, position.z = x, y, z
    message.transform.rotation = Quaternion(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    return message


with pyros1.Node("tf_broadcaster") as node:
    static_broadcaster = StaticTransformBroadcaster(node)
    static_broadcaster.send_transform(make_transform("base_link", "laser", 0.2, 0.0, 0.3, 0.0))
    broadcaster = TransformBroadcaster(node)
    rate = node.rate(20.0)  # Hz
    while node.ok():
        angle = SPEED * node.now().to_sec() % (2 * math.pi)
        x, y = RADIUS * math.cos(angle), RADIUS * math.sin(angle)
        broadcaster.send_transform(make_transform("world", "base_link", x, y, 0.0, angle + math.pi / 2))
        rate.sleep()
