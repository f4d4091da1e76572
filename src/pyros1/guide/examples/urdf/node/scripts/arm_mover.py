#!/usr/bin/env python3
"""Waves the arm of urdf/arm.urdf, and opens and closes its gripper.

pyros1 launch my_package arm.launch              starts the arm and this program (arm_mover.py)
pyros1 web scene --open                          displays it
pyros1 tf echo base_link left_link
"""

import math

import pyros1
from pyros1.msgs.sensor_msgs.msg import JointState

with pyros1.Node("arm_mover") as node:
    publisher = node.advertise("wanted_joints", JointState, queue_size=1)
    rate = node.rate(20.0)  # Hz
    while node.ok():
        now = node.now()
        sine = math.sin(now.to_sec())
        target = JointState(name=["shoulder", "left_finger"], position=[sine, 0.015 * (1 + sine)])  # rad, m
        target.header.stamp = now
        publisher.publish(target)
        rate.sleep()
