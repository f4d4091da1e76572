#!/usr/bin/env python3
"""Analyses the odometry in a bag with pandas. It needs no master.

pyros1 run my_package analyse_bag.py drive.bag
pyros1 run my_package analyse_bag.py drive.bag /robot1/odom
pyros1 run my_package write_bag.py drive.bag     writes a bag if you have none
"""

import sys

import rosbag

try:
    import pandas
except ImportError:
    sys.exit("this needs pandas: pip install pandas")


def read_odometry(path, topic):
    """Return the odometry in a bag as a table, indexed by the time in s since the first message."""
    with rosbag.Bag(path) as bag:
        rows = [
            (time.to_sec(), message.pose.pose.position.x, message.twist.twist.linear.x)
            for _, message, time in bag.read_messages([topic])
        ]
    if not rows:
        sys.exit(f"{path} has no messages on {topic}")
    frame = pandas.DataFrame(rows, columns=["time", "x in m", "speed in m/s"])
    frame["time"] -= frame["time"].iloc[0]
    return frame.set_index("time")


if not 2 <= len(sys.argv) <= 3:
    sys.exit("usage: analyse_bag.py FILE [TOPIC]")
try:
    frame = read_odometry(sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "/odom")
except (OSError, rosbag.ROSBagException) as error:
    sys.exit(str(error))
speed = frame["speed in m/s"]
print(frame.describe().round(3))
print(f"driven: {frame['x in m'].diff().abs().sum():.2f} m")
print(f"stood still: {(speed == 0).mean():.0%} of the time")
mean_speeds = speed.groupby(frame.index // 10 * 10).mean()
print("mean speed, every 10 s:", ", ".join(f"{mean:.2f}" for mean in mean_speeds), "m/s")
