#!/usr/bin/env python3
"""Prints where one frame is relative to another.

pyros1 run my_package tf_listener.py world laser
pyros1 tf static_transform_publisher 1 0 0.5 0 0 0 world laser     a frame, if nobody publishes any
"""

import argparse

import pyros1
from pyros1.tf import Buffer, TransformException, TransformListener

parser = argparse.ArgumentParser(description="Prints where one frame is relative to another.")
parser.add_argument("target", nargs="?", default="world", help="the frame in which the place is told")
parser.add_argument("source", nargs="?", default="laser", help="the frame whose place it is")

with pyros1.Node("tf_listener", anonymous=True) as node:
    frames = parser.parse_args(node.arguments.rest)
    buffer = Buffer()
    TransformListener(node, buffer)
    while node.ok():
        try:
            # The latest that there is; for the time of a message: time=message.header.stamp.
            found = buffer.lookup_transform(frames.target, frames.source, timeout=1.0)
        except TransformException as error:
            node.log.warn("not yet: %s", error)
        else:
            place = found.transform.translation
            node.log.info("%s is at x = %.2f, y = %.2f, z = %.2f m", frames.source, place.x, place.y, place.z)
        node.sleep(0.5)
