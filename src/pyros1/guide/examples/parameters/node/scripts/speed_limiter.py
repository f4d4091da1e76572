#!/usr/bin/env python3
"""Limits the speeds received on cmd_vel, according to its parameters.

pyros1 launch my_package speed_limiter.launch               with the limits of config/speed_limiter.yaml
pyros1 run my_package speed_limiter.py                      with the default limits
pyros1 param set /speed_limiter/limits/linear 0.2           changes one while it is running
pyros1 topic pub -r 5 cmd_vel geometry_msgs/Twist "{linear: {x: 2.0}}"
pyros1 topic echo cmd_vel_limited
"""

import pyros1
from pyros1.msgs.geometry_msgs.msg import Twist

DEFAULT_LIMITS = {"linear": 1.0, "angular": 2.0}  # m/s, rad/s


def clamp(value, limit):
    return max(-limit, min(limit, value))


def on_twist(twist):
    # The parameters are a local copy that the master keeps up to date.
    limits = {**DEFAULT_LIMITS, **node.params.cached("~limits", {})}
    twist.linear.x = clamp(twist.linear.x, limits["linear"])
    twist.angular.z = clamp(twist.angular.z, limits["angular"])
    publisher.publish(twist)


with pyros1.Node("speed_limiter") as node:
    name = node.params.get("~name", "robot")
    wheels = node.params.get("~wheels", [])
    node.params["~wheel_count"] = len(wheels)  # for other nodes
    node.params.on_update(lambda key, value: node.log.info("%s is now %s", key, value))
    node.params.cached("~limits", {})  # receive updates from the master from now on
    publisher = node.advertise("cmd_vel_limited", Twist, queue_size=1)
    node.subscribe("cmd_vel", Twist, on_twist, queue_size=1)
    node.log.info("%s has the wheels: %s", name, ", ".join(wheels) or "none")
    node.spin()
