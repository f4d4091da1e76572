#!/usr/bin/env python3
"""Writes a bag with a one-minute drive of a robot that stops twice. It needs no master.

pyros1 run my_package write_bag.py drive.bag
pyros1 bag info drive.bag
"""

import math
import sys

import pyros1.bag
from pyros1.msgs.nav_msgs.msg import Odometry

RATE = 20  # Hz
SECONDS = 60
BEGIN = 1700000000.0  # s since 1970

if len(sys.argv) != 2:
    sys.exit("usage: write_bag.py FILE")
with pyros1.bag.open(sys.argv[1], "w") as bag:
    x = 0.0
    for number in range(RATE * SECONDS):
        seconds = number / RATE
        odometry = Odometry(child_frame_id="base_link")
        odometry.header.frame_id = "odom"
        odometry.header.stamp = pyros1.Time.from_sec(BEGIN + seconds)
        odometry.twist.twist.linear.x = max(0.0, math.sin(2 * math.pi * seconds / 30))  # m/s
        odometry.pose.pose.position.x = x
        x += odometry.twist.twist.linear.x / RATE
        bag.write("/odom", odometry, odometry.header.stamp)
print(f"wrote {sys.argv[1]}")
