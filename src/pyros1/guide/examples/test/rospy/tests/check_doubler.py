#!/usr/bin/env python3
"""Tests doubler.py, which doubler.test starts. rostest passes the results to pyros1 test.

pyros1 test my_package doubler.test
"""

import unittest

import rospy
import rostest
from std_msgs.msg import Float64


class DoublerTest(unittest.TestCase):
    def test_a_number_is_doubled(self):
        rospy.init_node("check_doubler")
        sender = rospy.Publisher("input", Float64, queue_size=1, latch=True)
        sender.publish(1.5)
        message = rospy.wait_for_message("output", Float64, timeout=20.0)  # s
        self.assertEqual(message.data, 3.0)


if __name__ == "__main__":
    rostest.rosrun("my_package", "check_doubler", DoublerTest)
