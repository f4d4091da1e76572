#!/usr/bin/env python3
"""Publishes a sine wave on the topic numbers.

pyros1 run my_package publisher.py               publishes ten numbers per second
pyros1 run my_package publisher.py _rate:=50     publishes fifty
pyros1 topic echo numbers                        prints them, in another terminal
"""

import math

import pyros1
from pyros1.msgs.std_msgs.msg import Float64

FREQUENCY = 0.5  # Hz, of the sine

with pyros1.Node("publisher") as node:
    publisher = node.advertise("numbers", Float64, queue_size=10)
    rate = node.rate(node.params.get("~rate", 10.0))  # Hz
    while node.ok():
        seconds = node.now().to_sec()
        publisher.publish(Float64(math.sin(2 * math.pi * FREQUENCY * seconds)))
        rate.sleep()
