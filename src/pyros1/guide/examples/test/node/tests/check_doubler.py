#!/usr/bin/env python3
"""Tests doubler.py, which doubler.test starts. rostest passes the results to pyros1 test.

pyros1 test my_package doubler.test
"""

import unittest

import rostest

import pyros1
from pyros1.msgs.std_msgs.msg import Float64


class DoublerTest(unittest.TestCase):
    def test_a_number_is_doubled(self):
        with pyros1.Node("check_doubler") as node:
            node.advertise("input", Float64, latch=True).publish(Float64(1.5))
            message = node.wait_for_message("output", Float64, timeout=20.0)  # s
            self.assertEqual(message.data, 3.0)


if __name__ == "__main__":
    rostest.rosrun("my_package", "check_doubler", DoublerTest)
