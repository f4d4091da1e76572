#!/usr/bin/env python3
"""Provides the action count, which counts down ten numbers per second until 0 or until it is cancelled.

pyros1 run my_package count_server.py
pyros1 run my_package count_client.py 20         in another terminal
"""

import actionlib
import rospy
from my_package.msg import CountAction, CountFeedback, CountResult  # generated from action/Count.action

PERIOD = 0.1  # s


class Counter:
    """The action server."""

    def __init__(self):
        self.server = actionlib.SimpleActionServer("count", CountAction, self.count, auto_start=False)
        self.server.start()

    def count(self, goal):
        if goal.start < 0:
            self.server.set_aborted(text="the start must not be negative")
            return
        for number in range(goal.start, 0, -1):
            if self.server.is_preempt_requested() or rospy.is_shutdown():
                self.server.set_preempted(CountResult(counted=goal.start - number))
                return
            self.server.publish_feedback(CountFeedback(now=number))
            rospy.sleep(PERIOD)
        self.server.set_succeeded(CountResult(counted=goal.start))


if __name__ == "__main__":
    rospy.init_node("count_server")
    counter = Counter()
    rospy.spin()
