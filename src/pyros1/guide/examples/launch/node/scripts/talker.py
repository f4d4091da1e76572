#!/usr/bin/env python3
"""Publishes a greeting on the topic chatter. The launch file sets its name, rate and greeting.

pyros1 launch my_package robot.launch
pyros1 run my_package talker.py _greeting:=hi
"""

import pyros1
from pyros1.msgs.std_msgs.msg import String

with pyros1.Node("talker") as node:
    publisher = node.advertise("chatter", String, queue_size=10)
    greeting = node.params.get("~greeting", "this is")
    rate = node.rate(node.params.get("~rate", 1.0))  # Hz
    while node.ok():
        publisher.publish(String(f"{greeting} {node.name}"))
        rate.sleep()
