"""The parts of actionlib's clients, one by one, on stock's modules and on ours: what they answer, log, call and raise."""

from __future__ import annotations

import pytest
from action_programs import BEGIN
from faces import same
from harness import Master

MASTERS = ("ours",)

STATES = """
from actionlib.action_client import ClientGoalHandle, CommState, CommStateMachine
def machine(state):
    made = CommStateMachine(
        TestActionGoal(goal_id=GoalID(id="g")), lambda handle: print("    now", handle.get_comm_state()),
        lambda handle, feedback: print("    feedback", feedback.feedback, handle.get_comm_state()), None,
        lambda request: print("    asked to cancel", request.id, request.stamp.is_zero()))
    made.state = state
    return made
def show(made):
    latest = made.latest_goal_status
    print("   =", made.state, latest.status, latest.text, made.latest_result and made.latest_result.result.result)
for state in (CommState.WAITING_FOR_GOAL_ACK, CommState.PENDING, CommState.ACTIVE, CommState.WAITING_FOR_RESULT,
              CommState.WAITING_FOR_CANCEL_ACK, CommState.RECALLING, CommState.PREEMPTING, CommState.DONE,
              CommState.LOST):
    for number in range(11):
        print(CommState.to_string(state), number)
        made = machine(state)
        attempt(made.update_status, GoalStatusArray(status_list=[status(3, "other"), status(number)]))
        show(made)
        made = machine(state)
        attempt(made.update_result, TestActionResult(status=status(number), result=TestResult(5)))
        show(made)
        made = machine(state)
        made.latest_goal_status = status(number)
        handle = ClientGoalHandle(made)
        for ask in (handle.get_terminal_state, handle.get_goal_status, handle.get_goal_status_text, handle.get_result):
            attempt(ask)
        attempt(handle.cancel)
        show(made)
    made = machine(state)
    attempt(made.update_status, GoalStatusArray())
    show(made)
    made = machine(state)
    attempt(made.update_feedback, TestActionFeedback(status=status(1), feedback=TestFeedback(8)))
    attempt(made.update_feedback, TestActionFeedback(status=status(1, "other")))
    attempt(made.update_result, TestActionResult(status=status(3, "other")))
    show(made)
    attempt(made.set_state, CommState.PREEMPTING)
    attempt(made.transition_to, CommState.RECALLING)
"""

HANDLES = """
from actionlib.action_client import *
one, other = (CommStateMachine(TestActionGoal(goal_id=GoalID(id=name)), None, None, None, None) for name in "ab")
attempt(one.transition_to, CommState.PENDING)
attempt(one.update_feedback, TestActionFeedback(status=status(1, "a")))
a, again, b, empty = ClientGoalHandle(one), ClientGoalHandle(one), ClientGoalHandle(other), ClientGoalHandle(None)
print(a == again, a != again, a == b, a != b, a == None, a != None, empty == ClientGoalHandle(None), hash(a) == hash(again))
print(one == one, one == other, len({one, other, a.comm_state_machine}), a in [b, again])
for wrong in (3, "a", empty):
    attempt(lambda: a == wrong)
    attempt(lambda: one == wrong)
for ask in (empty.get_comm_state, empty.get_goal_status, empty.get_goal_status_text, empty.get_result,
            empty.get_terminal_state, empty.cancel):
    attempt(ask)
for names in (CommState, TerminalState, actionlib.SimpleGoalState):
    print([names.to_string(number) for number in range(-1, 11)])
print(get_name_of_constant(GoalStatus, 3), get_name_of_constant(GoalStatus, 33), GoalStatus.to_string(6))
print(NO_TRANSITION, INVALID_TRANSITION, g_goal_id, actionlib.g_goal_id, rospy.__name__, threading.__name__)
"""

MANAGER = """
import actionlib.action_client
from actionlib.action_client import GoalManager
for wrong in (TestGoal, 3, None):
    attempt(GoalManager, wrong)
manager = GoalManager(TestAction)
print(manager.statuses, manager.ActionSpec is TestAction, manager.ActionGoal is TestActionGoal)
attempt(manager.init_goal, TestGoal(1))
sent = []
attempt(manager.register_send_goal_fn, sent.append)
attempt(manager.register_cancel_fn, lambda request: print("    asked to cancel", request.id == name))
first = actionlib.action_client.g_goal_id
handle = manager.init_goal(goal=TestGoal(7), transition_cb=lambda handle: print("    now", handle.get_comm_state()),
                           feedback_cb=lambda handle, feedback: print("    feedback", feedback.feedback))
name = sent[0].goal_id.id
begin, number, time = name.split("-")
print(begin, int(number) == first, actionlib.action_client.g_goal_id == first + 1, len(time.partition(".")[2]))
print(sent[0].goal.goal, sent[0].goal_id.stamp.is_zero(), sent[0].header.stamp.is_zero(), len(manager.statuses))
plain = manager.init_goal(TestGoal(8))
attempt(manager.update_statuses, GoalStatusArray(status_list=[status(1, name)]))
attempt(manager.update_feedbacks, TestActionFeedback(status=status(1, name), feedback=TestFeedback(4)))
attempt(handle.cancel)
attempt(manager.update_results, TestActionResult(status=status(2, name), result=TestResult(3)))
print(handle.get_result(), plain.get_comm_state(), handle.get_goal_status_text())
del handle
attempt(manager.update_results, TestActionResult(status=status(2, name)))  # no one holds it any more
"""

SIMPLE_CLIENT = """
from actionlib.simple_action_client import SimpleActionClient, SimpleGoalState
client = SimpleActionClient("act", TestAction)
below = client.action_client
print(client.simple_state == SimpleGoalState.DONE, client.gh)
for ask in (client.get_state, client.get_result, client.get_goal_status_text, client.wait_for_result, client.cancel_goal,
            client.stop_tracking_goal):
    attempt(ask)
sent = []
below.manager.register_send_goal_fn(sent.append)
below.manager.register_cancel_fn(lambda request: print("    asked to cancel", request.id == sent[-1].goal_id.id))
def on_done(state, result):
    print("    done", state, result, SimpleGoalState.to_string(client.simple_state))
def send(*callbacks):
    client.send_goal(TestGoal(len(sent)), *callbacks)
    return client.gh.comm_state_machine
def on_active():
    print("    active", SimpleGoalState.to_string(client.simple_state))
def now(number, name=None):
    return status(number, name or sent[-1].goal_id.id)
quiet = rospy.logdebug
rospy.logdebug = lambda *args: None  # names of goals differ
for before in range(3):
    for state in range(9):
        for callbacks in ((on_done, on_active), ()):
            machine = send(*callbacks)
            client.simple_state = before
            print(SimpleGoalState.to_string(before), state)
            attempt(machine.transition_to, state)
            print("   =", client.simple_state)
for number in range(11):
    machine = send()
    machine.latest_goal_status = now(number)
    print(number, client.get_state(), client.get_goal_status_text(), client.get_result())
def wrong(*args):
    raise ValueError("wrong")
machine = send(wrong, wrong, wrong)
attempt(machine.transition_to, 2)
attempt(machine.transition_to, 7)
attempt(below.manager.update_feedbacks, TestActionFeedback(status=now(1)))
print(client.simple_state)
machine = send(on_done, on_active, lambda feedback: print("    feedback", feedback.feedback))
attempt(below.manager.update_statuses, GoalStatusArray(status_list=[now(1)]))
attempt(below.manager.update_feedbacks, TestActionFeedback(status=now(1), feedback=TestFeedback(6)))
attempt(client.wait_for_result, rospy.Duration(0.05))
attempt(client.cancel_goal)
attempt(below.manager.update_results, TestActionResult(status=now(2), result=TestResult(4)))
attempt(client.wait_for_result, timeout=rospy.Duration(0.05))
attempt(client.wait_for_result)
print(client.get_state(), client.get_result(), client.get_goal_status_text())
kept = client.gh
send(on_done)
attempt(kept.comm_state_machine.transition_to, 2)  # of a goal that is followed no more
rospy.logdebug = quiet
attempt(client.stop_tracking_goal)
attempt(client.wait_for_server, rospy.Duration(0.05))
attempt(client.wait_for_result, 0.1)
send()
attempt(client.wait_for_result, 0.1)
rospy.logdebug = lambda text, *args: print("   ", text % args) if "reempt" in text or "ancel" in text else None
attempt(client.send_goal_and_wait, TestGoal(), rospy.Duration(0.05), rospy.Duration(0.05))
attempt(client.send_goal_and_wait, TestGoal(), execute_timeout=rospy.Duration(0.05), preempt_timeout=rospy.Duration(0.05))
def cancelled(request):
    below.manager.update_results(TestActionResult(status=now(2)))
below.manager.register_cancel_fn(cancelled)
attempt(client.send_goal_and_wait, TestGoal(), rospy.Duration(0.05), rospy.Duration(5))
below.manager.register_send_goal_fn(lambda goal: None)
requests = []
below.pub_cancel.publish = requests.append
attempt(client.cancel_all_goals)
attempt(client.cancel_goals_at_and_before_time, rospy.Time(3))
attempt(below.cancel_all_goals)
attempt(below.cancel_goals_at_and_before_time, time=rospy.Time(4))
print([(each.id, each.stamp.secs) for each in requests])
"""

CONNECTED = """
class Link:
    def __init__(self, callerid_pub):
        self.callerid_pub = callerid_pub
class Topic:
    def __init__(self, peer):
        self.impl = self
        self.connections = [Link("/another"), Link(peer)]
        self.peer = peer
    def has_connection(self, peer):
        return peer == self.peer
    def unregister(self):
        pass
client = actionlib.ActionClient("act", TestAction)
topics = ("pub_goal", "pub_cancel", "status_sub", "result_sub", "feedback_sub")
message = GoalStatusArray()
setattr(message, "_connection" + "_header", {"callerid": "/server"})
for absent in (None,) + topics:
    for name in topics:
        setattr(client, name, Topic("/server" if name != absent else "/nobody"))
    for known in (None, message):
        client.last_status_msg = known
        print(absent, known is None)
        attempt(client.wait_for_server, rospy.Duration(0.05))
rospy.signal_shutdown("done")
client.last_status_msg = None
attempt(client.wait_for_server)
attempt(client.wait_for_action_server_to_start)
"""
PROGRAMS = {
    "states": (STATES, "WAITING_FOR_RESULT 7"),
    "handles": (HANDLES, "NO_SUCH_STATE_-1"),
    "manager": (MANAGER, "Type is not an action spec"),
    "simple_client": (SIMPLE_CLIENT, "received DONE twice"),
    "connected": (CONNECTED, "feedback_sub False"),
}


@pytest.mark.parametrize("part", PROGRAMS)
def test_part(master: Master, part: str) -> None:
    text, expected = PROGRAMS[part]
    assert expected in same(master, BEGIN + text)
