#!/usr/bin/env python3
"""Prints the messages on the topic chatter.

pyros1 launch my_package robot.launch
pyros1 run my_package listener.py --prefix heard chatter:=/r1/words
"""

import argparse

import pyros1
from pyros1.msgs.std_msgs.msg import String

parser = argparse.ArgumentParser(description="Prints messages.")
parser.add_argument("--prefix", default="received", help="text before each message")

with pyros1.Node("listener") as node:
    prefix = parser.parse_args(node.arguments.rest).prefix  # without ROS arguments such as chatter:=words
    node.subscribe("chatter", String, lambda message: node.log.info("%s: %s", prefix, message.data))
    node.spin()
