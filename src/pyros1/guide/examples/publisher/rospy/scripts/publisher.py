#!/usr/bin/env python3
"""Publishes a sine wave on the topic numbers.

pyros1 run my_package publisher.py               publishes ten numbers per second
pyros1 run my_package publisher.py _rate:=50     publishes fifty
pyros1 topic echo numbers                        prints them, in another terminal
"""

import math

import rospy
from std_msgs.msg import Float64

FREQUENCY = 0.5  # Hz, of the sine


def main():
    rospy.init_node("publisher")
    publisher = rospy.Publisher("numbers", Float64, queue_size=10)
    rate = rospy.Rate(rospy.get_param("~rate", 10.0))  # Hz
    while not rospy.is_shutdown():
        seconds = rospy.get_time()
        publisher.publish(math.sin(2 * math.pi * FREQUENCY * seconds))
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C during sleep
