#!/usr/bin/env python3
"""Publishes a greeting on the topic chatter. The launch file sets its name, rate and greeting.

pyros1 launch my_package robot.launch
pyros1 run my_package talker.py _greeting:=hi
"""

import rospy
from std_msgs.msg import String


def main():
    rospy.init_node("talker")
    publisher = rospy.Publisher("chatter", String, queue_size=10)
    greeting = rospy.get_param("~greeting", "this is")
    rate = rospy.Rate(rospy.get_param("~rate", 1.0))  # Hz
    while not rospy.is_shutdown():
        publisher.publish(f"{greeting} {rospy.get_name()}")
        rate.sleep()


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException:
        pass  # Ctrl-C during sleep
