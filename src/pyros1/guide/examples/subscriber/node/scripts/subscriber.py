#!/usr/bin/env python3
"""Prints the numbers received on the topic numbers and their mean.

pyros1 run my_package subscriber.py
pyros1 topic pub -r 2 numbers std_msgs/Float64 1.5     publishes numbers, in another terminal
"""

import pyros1
from pyros1.msgs.std_msgs.msg import Float64


class Mean:
    """Computes the mean of all received numbers."""

    def __init__(self, node):
        self.node = node
        self.count = 0
        self.sum = 0.0
        node.subscribe("numbers", Float64, self.on_number, queue_size=10)

    def on_number(self, message):
        self.count += 1
        self.sum += message.data
        self.node.log.info("%.3f, the mean of %d numbers is %.3f", message.data, self.count, self.sum / self.count)


with pyros1.Node("subscriber") as node:
    Mean(node)
    node.spin()  # until Ctrl-C; on_number() is called for each message
