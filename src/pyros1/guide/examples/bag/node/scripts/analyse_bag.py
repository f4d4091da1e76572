#!/usr/bin/env python3
"""Analyses the odometry in a bag with pandas. It needs no master.

pyros1 run my_package analyse_bag.py drive.bag
pyros1 run my_package analyse_bag.py drive.bag /robot1/odom
pyros1 run my_package write_bag.py drive.bag     writes a bag if you have none
"""

import sys

import pyros1.bag

try:
    import pandas
except ImportError:
    sys.exit("this needs pandas: pip install pandas")

X, SPEED = "pose.pose.position.x", "twist.twist.linear.x"


def read_odometry(path, topic):
    """Return the odometry in a bag as a table, indexed by the time in s since the first message."""
    with pyros1.bag.open(path) as bag:
        frame = pandas.DataFrame(bag.arrays(topic, [X, SPEED]))
    frame["time"] -= frame["time"].iloc[0]
    return frame.set_index("time")


if not 2 <= len(sys.argv) <= 3:
    sys.exit("usage: analyse_bag.py FILE [TOPIC]")
try:
    frame = read_odometry(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "/odom")
except (OSError, pyros1.Error) as error:
    sys.exit(str(error))
print(frame.rename(columns={X: "x in m", SPEED: "speed in m/s"}).describe().round(3))
print(f"driven: {frame[X].diff().abs().sum():.2f} m")
print(f"stood still: {(frame[SPEED] == 0).mean():.0%} of the time")
mean_speeds = frame[SPEED].groupby(frame.index // 10 * 10).mean()
print("mean speed, every 10 s:", ", ".join(f"{speed:.2f}" for speed in mean_speeds), "m/s")
