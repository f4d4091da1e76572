#!/usr/bin/env python3
"""Doubles numbers: it receives them on input, and publishes on output. tests/ has tests for it.

pyros1 run my_package doubler.py
pyros1 test my_package doubler.test
python3 -m pytest my_package/tests
"""

import pyros1
from pyros1.msgs.std_msgs.msg import Float64

with pyros1.Node("doubler") as node:
    output = node.advertise("output", Float64, queue_size=10, latch=True)  # also for those who come later
    node.subscribe("input", Float64, lambda message: output.publish(Float64(2 * message.data)))
    node.spin()
