#!/usr/bin/env python3
"""Provides the action count, which counts down ten numbers per second until 0 or until it is cancelled.

pyros1 run my_package count_server.py
pyros1 run my_package count_client.py 20         in another terminal
"""

import pyros1
from pyros1 import actions
from pyros1.msgs.my_package.msg import CountAction, CountFeedback, CountResult  # from action/Count.action

PERIOD = 0.1  # s


def count(goal):
    start = goal.goal.start
    if start < 0:
        return goal.abort(text="the start must not be negative")
    for number in range(start, 0, -1):
        if goal.cancel_requested:
            return goal.cancel(CountResult(counted=start - number))
        goal.feedback(CountFeedback(now=number))
        node.sleep(PERIOD)
    return CountResult(counted=start)


with pyros1.Node("count_server") as node, actions.SimpleServer(node, "count", CountAction, count):
    node.spin()
