#!/usr/bin/env python3
"""Limits the speeds received on cmd_vel, as its parameters say.

pyros1 launch my_package speed_limiter.launch               with the limits of config/speed_limiter.yaml
pyros1 run my_package speed_limiter.py                      with the usual ones
pyros1 param set /speed_limiter/limits/linear 0.2           changes one while it runs
pyros1 topic pub -r 5 cmd_vel geometry_msgs/Twist "{linear: {x: 2.0}}"
pyros1 topic echo cmd_vel_limited
"""

import pyros1
from pyros1.msgs.geometry_msgs.msg import Twist

USUAL = {"linear": 1.0, "angular": 2.0}  # m/s, rad/s


def within(value, limit):
    return max(-limit, min(limit, value))


def received(twist):
    limits = {**USUAL, **node.params.cached("~limits", {})}  # a local copy: the master tells of changes
    twist.linear.x = within(twist.linear.x, limits["linear"])
    twist.angular.z = within(twist.angular.z, limits["angular"])
    limited.publish(twist)


with pyros1.Node("speed_limiter") as node:
    name = node.params.get("~name", "robot")
    wheels = node.params.get("~wheels", [])
    node.params["~wheel_count"] = len(wheels)  # others may read it
    node.params.on_update(lambda key, value: node.log.info("%s is now %s", key, value))
    node.params.cached("~limits", {})  # the master tells of changes from now on
    limited = node.advertise("cmd_vel_limited", Twist, queue_size=1)
    node.subscribe("cmd_vel", Twist, received, queue_size=1)
    node.log.info("%s has the wheels: %s", name, ", ".join(wheels) or "none")
    node.spin()
