#!/usr/bin/env python3
"""Sends a goal to the action server count and prints the goal's progress. Ctrl-C cancels the goal.

pyros1 run my_package count_client.py 20
pyros1 run my_package count_client.py 20 --patience 1     cancels it after a second
"""

import argparse
import sys

import actionlib
import rospy
from my_package.msg import CountAction, CountGoal


def main():
    parser = argparse.ArgumentParser(description="Lets a server count down.")
    parser.add_argument("start", type=int)
    parser.add_argument("--patience", type=float, default=60.0, help="seconds after which the goal is cancelled")
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("count_client", anonymous=True)
    client = actionlib.SimpleActionClient("count", CountAction)
    if not client.wait_for_server(rospy.Duration(10)):
        sys.exit("not done: there is no server of the action count")
    client.send_goal(
        CountGoal(start=arguments.start), feedback_cb=lambda feedback: print("now", feedback.now, flush=True)
    )
    rospy.on_shutdown(client.cancel_goal)
    finished = client.wait_for_result(rospy.Duration.from_sec(arguments.patience))
    if rospy.is_shutdown():
        sys.exit("not done: stopped")
    if not finished:
        print("that takes too long")
        client.cancel_goal()
        client.wait_for_result(rospy.Duration(10))
    if client.get_state() != actionlib.GoalStatus.SUCCEEDED:
        state = actionlib.GoalStatus.to_string(client.get_state())
        sys.exit(f"not done: {state} {client.get_goal_status_text()}".rstrip())
    print("counted", client.get_result().counted)


if __name__ == "__main__":
    main()
