#!/usr/bin/env python3
"""Doubles the numbers received on input and publishes them on output. Its tests are in tests/.

pyros1 run my_package doubler.py
pyros1 test my_package doubler.test
python3 -m pytest my_package/tests
"""

import pyros1
from pyros1.msgs.std_msgs.msg import Float64

with pyros1.Node("doubler") as node:
    output = node.advertise("output", Float64, queue_size=10, latch=True)  # for late subscribers as well
    node.subscribe("input", Float64, lambda message: output.publish(Float64(2 * message.data)))
    node.spin()
