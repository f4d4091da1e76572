#!/usr/bin/env python3
"""Switches a lamp on and off with a timer, and stops with a second timer, which fires only once.

pyros1 run my_package blinker.py
pyros1 run my_package blinker.py _period:=0.1 _duration:=3
pyros1 topic echo lamp                           in another terminal
"""

import rospy
from std_msgs.msg import Bool


class Blinker:
    """Makes a lamp blink for a while."""

    def __init__(self, period, duration):
        self.is_on = False
        self.lamp = rospy.Publisher("lamp", Bool, queue_size=1, latch=True)
        self.timer = rospy.Timer(rospy.Duration.from_sec(period), self.blink)
        rospy.Timer(rospy.Duration.from_sec(duration), self.stop, oneshot=True)

    def blink(self, event):
        self.is_on = not self.is_on
        self.lamp.publish(self.is_on)
        delay = (event.current_real - event.current_expected).to_sec()
        rospy.loginfo("%s, %.1f ms late", "on" if self.is_on else "off", 1000 * delay)

    def stop(self, event):
        self.timer.shutdown()
        self.lamp.publish(False)
        rospy.loginfo("blinked long enough")
        rospy.signal_shutdown("blinked long enough")


if __name__ == "__main__":
    rospy.init_node("blinker")
    blinker = Blinker(rospy.get_param("~period", 0.5), rospy.get_param("~duration", 60.0))  # s
    rospy.spin()
