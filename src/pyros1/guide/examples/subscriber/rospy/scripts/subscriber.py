#!/usr/bin/env python3
"""Prints the numbers received on the topic numbers and their mean.

pyros1 run my_package subscriber.py
pyros1 topic pub -r 2 numbers std_msgs/Float64 1.5     publishes numbers, in another terminal
"""

import rospy
from std_msgs.msg import Float64


class Mean:
    """Computes the mean of all received numbers."""

    def __init__(self):
        self.count = 0
        self.sum = 0.0
        rospy.Subscriber("numbers", Float64, self.on_number, queue_size=10)

    def on_number(self, message):
        self.count += 1
        self.sum += message.data
        rospy.loginfo("%.3f, the mean of %d numbers is %.3f", message.data, self.count, self.sum / self.count)


if __name__ == "__main__":
    rospy.init_node("subscriber")
    mean = Mean()
    rospy.spin()  # until Ctrl-C; on_number() is called for each message
