#!/usr/bin/env python3
"""Sends a goal to the action server count and prints the goal's progress. Ctrl-C cancels the goal.

pyros1 run my_package count_client.py 20
pyros1 run my_package count_client.py 20 --patience 1     cancels it after a second
"""

import argparse
import sys

import pyros1
from pyros1 import actions
from pyros1.msgs.my_package.msg import CountAction, CountGoal

parser = argparse.ArgumentParser(description="Lets a server count down.")
parser.add_argument("start", type=int)
parser.add_argument("--patience", type=float, default=60.0, help="seconds after which the goal is cancelled")

with pyros1.Node("count_client", anonymous=True) as node, actions.Client(node, "count", CountAction) as client:
    arguments = parser.parse_args(node.arguments.rest)
    try:
        goal = client.send(
            CountGoal(start=arguments.start), on_feedback=lambda feedback: print("now", feedback.now, flush=True)
        )
        node.on_shutdown(goal.cancel, early=True)
        if not goal.wait(arguments.patience):
            print("that takes too long")
            goal.cancel()
        print("counted", goal.result(timeout=10.0).counted)
    except pyros1.Error as error:
        sys.exit(f"not done: {error}")
