"""actionlib by pyros1, in programs as users write them."""

from __future__ import annotations

import pytest
from programs import run, start

SERVER = """
import rospy
import actionlib
import actionlib_tutorials.msg

class FibonacciAction(object):
    _feedback = actionlib_tutorials.msg.FibonacciFeedback()
    _result = actionlib_tutorials.msg.FibonacciResult()

    def __init__(self, name):
        self._action_name = name
        self._as = actionlib.SimpleActionServer(self._action_name, actionlib_tutorials.msg.FibonacciAction,
                                                execute_cb=self.execute_cb, auto_start=False)
        self._as.start()

    def execute_cb(self, goal):
        rate = rospy.Rate(100)
        success = True
        self._feedback.sequence = [0, 1]
        for i in range(1, goal.order):
            if self._as.is_preempt_requested():
                rospy.loginfo("%s: Preempted", self._action_name)
                self._as.set_preempted()
                success = False
                break
            self._feedback.sequence.append(self._feedback.sequence[i] + self._feedback.sequence[i - 1])
            self._as.publish_feedback(self._feedback)
            rate.sleep()
        if success:
            self._result.sequence = self._feedback.sequence
            rospy.loginfo("%s: Succeeded", self._action_name)
            self._as.set_succeeded(self._result)

rospy.init_node("fibonacci")
server = FibonacciAction(rospy.get_name())
rospy.spin()
"""
CLIENT = """
import sys
import rospy
import actionlib
import actionlib_tutorials.msg
rospy.init_node("fibonacci_client")
client = actionlib.SimpleActionClient("fibonacci", actionlib_tutorials.msg.FibonacciAction)
assert client.wait_for_server(rospy.Duration(20))
client.send_goal(actionlib_tutorials.msg.FibonacciGoal(order=int(sys.argv[1])))
if len(sys.argv) > 2:
    while client.get_state() != actionlib.GoalStatus.ACTIVE:
        rospy.sleep(0.01)
    client.cancel_goal()
client.wait_for_result(rospy.Duration(20))
print(actionlib.GoalStatus.to_string(client.get_state()), client.get_result().sequence)
"""


@pytest.mark.slow
def test_fibonacci(environ: dict[str, str]) -> None:
    server = start(SERVER, environ)
    try:
        assert run(CLIENT, environ, "5") == "SUCCEEDED (0, 1, 1, 2, 3, 5)\n"
        assert run(CLIENT, environ, "2000", "cancel") == "PREEMPTED ()\n"
    finally:
        server.terminate()
        out, _ = server.communicate(timeout=10)
    assert "/fibonacci: Succeeded" in out
    assert "/fibonacci: Preempted" in out
    assert server.returncode == 0


NO_ACTION = """
import actionlib, actionlib.action_client, rospy
from std_msgs.msg import String
rospy.init_node("me")
try:
    actionlib.ActionClient("x", String)
except actionlib.ActionException as error:
    print(error)
try:
    actionlib.transitions
except AttributeError as error:
    print(error)
"""


def test_what_is_no_action(environ: dict[str, str]) -> None:
    out = run(NO_ACTION, environ)
    assert "Type is not an action spec: <class 'std_msgs.msg._String.String'>" in out
    assert "pyros1 has no actionlib.transitions" in out


CHAIN = """
import threading
import actionlib, rospy
from actionlib.msg import TestAction, TestGoal, TestResult
rospy.init_node("chain")
def execute(goal):
    server.set_succeeded(TestResult(goal.goal))
server = actionlib.SimpleActionServer("count", TestAction, execute, False)
server.start()
client = actionlib.SimpleActionClient("count", TestAction)
assert client.wait_for_server(rospy.Duration(20))
results, last = [], threading.Event()
def done(state, result):
    results.append((state, result.result))
    if len(results) < 5:
        client.send_goal(TestGoal(len(results)), done)  # stock's client loses it
    else:
        last.set()
client.send_goal(TestGoal(0), done)
assert client.wait_for_result(rospy.Duration(20)) and last.wait(20)
assert results == [(3, number) for number in range(5)], results
assert client.wait_for_result(rospy.Duration(20)) and client.get_state() == 3 and client.get_result().result == 4
rospy.signal_shutdown("done")
"""


def test_goals_that_are_sent_at_the_end_of_others(environ: dict[str, str]) -> None:
    run(CHAIN, environ)


COUNTDOWN = """
import faulthandler, threading, time
import rospy, actionlib
from actionlib.msg import TestAction, TestGoal
from rosgraph_msgs.msg import Clock
faulthandler.dump_traceback_later(25, exit=True)
rospy.set_param("/use_sim_time", True)
rospy.init_node("counts", disable_signals=True)
clock = rospy.Publisher("/clock", Clock, queue_size=10)
server = actionlib.SimpleActionServer("work", TestAction, lambda goal: time.sleep(30), False)
server.start()
client = actionlib.SimpleActionClient("work", TestAction)
assert client.wait_for_server()
seconds, ticking = [100.0], threading.Event()
def tick():
    while not ticking.wait(0.01):
        seconds[0] += 0.05
        clock.publish(Clock(rospy.Time(seconds[0])))
ticker = threading.Thread(target=tick, daemon=True)
ticker.start()
while not rospy.get_time():
    time.sleep(0.01)
client.send_goal(TestGoal())
threading.Timer(0.2, seconds.__setitem__, (0, 1.0)).start()  # the bag is played again
print(client.wait_for_result(rospy.Duration(3)), rospy.get_time() < 50)
ticking.set()
ticker.join()
rospy.on_shutdown(lambda: print("hook", client.wait_for_result(rospy.Duration(1000))))
rospy.signal_shutdown("the simulation has ended")
import os, sys
sys.stdout.flush()
os._exit(0)
"""


@pytest.mark.slow
def test_waits_end_when_simulated_time_begins_again_or_has_gone(environ: dict[str, str]) -> None:
    lines = run(COUNTDOWN, environ).splitlines()
    assert [line for line in lines if line[0] != "["] == ["False True", "hook False"]
