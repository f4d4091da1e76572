#!/usr/bin/env python3
"""Prints the position of one frame relative to another.

pyros1 run my_package tf_listener.py world laser
pyros1 tf static_transform_publisher 1 0 0.5 0 0 0 world laser     publishes a frame if you have none
"""

import argparse

import pyros1
from pyros1.tf import Buffer, TransformException, TransformListener

parser = argparse.ArgumentParser(description="Prints the position of one frame relative to another.")
parser.add_argument("target", nargs="?", default="world", help="the frame in which the position is given")
parser.add_argument("source", nargs="?", default="laser", help="the frame whose position is printed")

with pyros1.Node("tf_listener", anonymous=True) as node:
    frames = parser.parse_args(node.arguments.rest)
    buffer = Buffer()
    TransformListener(node, buffer)
    while node.ok():
        try:
            # This is the latest transform; for the transform at a message's time, add time=message.header.stamp.
            transform = buffer.lookup_transform(frames.target, frames.source, timeout=1.0)
        except TransformException as error:
            node.log.warn("no position yet: %s", error)
        else:
            position = transform.transform.translation
            node.log.info("%s is at x = %.2f, y = %.2f, z = %.2f m", frames.source, position.x, position.y, position.z)
        node.sleep(0.5)
