#!/usr/bin/env python3
"""Doubles the numbers received on input and publishes them on output. Its tests are in tests/.

pyros1 run my_package doubler.py
pyros1 test my_package doubler.test
python3 -m pytest my_package/tests
"""

import rospy
from std_msgs.msg import Float64

if __name__ == "__main__":
    rospy.init_node("doubler")
    output = rospy.Publisher("output", Float64, queue_size=10, latch=True)  # for late subscribers as well
    rospy.Subscriber("input", Float64, lambda message: output.publish(2 * message.data))
    rospy.spin()
