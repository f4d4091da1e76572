#!/usr/bin/env python3
"""Limits the speeds received on cmd_vel, as its parameters say.

pyros1 launch my_package speed_limiter.launch               with the limits of config/speed_limiter.yaml
pyros1 run my_package speed_limiter.py                      with the usual ones
pyros1 param set /speed_limiter/limits/linear 0.2           changes one while it runs
pyros1 topic pub -r 5 cmd_vel geometry_msgs/Twist "{linear: {x: 2.0}}"
pyros1 topic echo cmd_vel_limited
"""

import rospy
from geometry_msgs.msg import Twist

USUAL = {"linear": 1.0, "angular": 2.0}  # m/s, rad/s


def within(value, limit):
    return max(-limit, min(limit, value))


def received(twist, limited):
    limits = {**USUAL, **rospy.get_param_cached("~limits", {})}  # a local copy: the master tells of changes
    twist.linear.x = within(twist.linear.x, limits["linear"])
    twist.angular.z = within(twist.angular.z, limits["angular"])
    limited.publish(twist)


def main():
    rospy.init_node("speed_limiter")
    name = rospy.get_param("~name", "robot")
    wheels = rospy.get_param("~wheels", [])
    rospy.set_param("~wheel_count", len(wheels))  # others may read it
    limited = rospy.Publisher("cmd_vel_limited", Twist, queue_size=1)
    rospy.Subscriber("cmd_vel", Twist, received, limited, queue_size=1)
    rospy.loginfo("%s has the wheels: %s", name, ", ".join(wheels) or "none")
    rospy.spin()


if __name__ == "__main__":
    main()
