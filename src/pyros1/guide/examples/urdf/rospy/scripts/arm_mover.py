#!/usr/bin/env python3
"""Waves the arm of urdf/arm.urdf, and opens and closes its gripper.

pyros1 launch my_package arm.launch              starts the arm and this program (arm_mover.py)
pyros1 web scene --open                          displays it
pyros1 tf echo base_link left_link
"""

import math

import rospy
from sensor_msgs.msg import JointState


def main():
    rospy.init_node("arm_mover")
    publisher = rospy.Publisher("wanted_joints", JointState, queue_size=1)
    rate = rospy.Rate(20.0)  # Hz
    while not rospy.is_shutdown():
        now = rospy.Time.now()
        sine = math.sin(now.to_sec())
        target = JointState(name=["shoulder", "left_finger"], position=[sine, 0.015 * (1 + sine)])  # rad, m
        target.header.stamp = now
        publisher.publish(target)
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C during sleep
