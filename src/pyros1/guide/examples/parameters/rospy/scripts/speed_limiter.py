#!/usr/bin/env python3
"""Limits the speeds received on cmd_vel, according to its parameters.

pyros1 launch my_package speed_limiter.launch               with the limits of config/speed_limiter.yaml
pyros1 run my_package speed_limiter.py                      with the default limits
pyros1 param set /speed_limiter/limits/linear 0.2           changes one while it is running
pyros1 topic pub -r 5 cmd_vel geometry_msgs/Twist "{linear: {x: 2.0}}"
pyros1 topic echo cmd_vel_limited
"""

import rospy
from geometry_msgs.msg import Twist

DEFAULT_LIMITS = {"linear": 1.0, "angular": 2.0}  # m/s, rad/s


def clamp(value, limit):
    return max(-limit, min(limit, value))


def on_twist(twist, publisher):
    # The parameters are a local copy that the master keeps up to date.
    limits = {**DEFAULT_LIMITS, **rospy.get_param_cached("~limits", {})}
    twist.linear.x = clamp(twist.linear.x, limits["linear"])
    twist.angular.z = clamp(twist.angular.z, limits["angular"])
    publisher.publish(twist)


def main():
    rospy.init_node("speed_limiter")
    name = rospy.get_param("~name", "robot")
    wheels = rospy.get_param("~wheels", [])
    rospy.set_param("~wheel_count", len(wheels))  # for other nodes
    publisher = rospy.Publisher("cmd_vel_limited", Twist, queue_size=1)
    rospy.Subscriber("cmd_vel", Twist, on_twist, publisher, queue_size=1)
    rospy.loginfo("%s has the wheels: %s", name, ", ".join(wheels) or "none")
    rospy.spin()


if __name__ == "__main__":
    main()
