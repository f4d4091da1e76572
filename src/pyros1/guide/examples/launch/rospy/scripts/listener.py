#!/usr/bin/env python3
"""Prints the messages on the topic chatter.

pyros1 launch my_package robot.launch
pyros1 run my_package listener.py --prefix heard chatter:=/r1/words
"""

import argparse

import rospy
from std_msgs.msg import String


def main():
    parser = argparse.ArgumentParser(description="Prints messages.")
    parser.add_argument("--prefix", default="received", help="text before each message")
    prefix = parser.parse_args(rospy.myargv()[1:]).prefix  # without ROS arguments such as chatter:=words
    rospy.init_node("listener")
    rospy.Subscriber("chatter", String, lambda message: rospy.loginfo("%s: %s", prefix, message.data))
    rospy.spin()


if __name__ == "__main__":
    main()
