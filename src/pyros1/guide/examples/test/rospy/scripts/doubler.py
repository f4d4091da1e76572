#!/usr/bin/env python3
"""Doubles numbers: it receives them on input, and publishes on output. tests/ has tests for it.

pyros1 run my_package doubler.py
pyros1 test my_package doubler.test
python3 -m pytest my_package/tests
"""

import rospy
from std_msgs.msg import Float64

if __name__ == "__main__":
    rospy.init_node("doubler")
    output = rospy.Publisher("output", Float64, queue_size=10, latch=True)  # also for those who come later
    rospy.Subscriber("input", Float64, lambda message: output.publish(2 * message.data))
    rospy.spin()
