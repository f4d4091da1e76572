"""The parts of actionlib, one by one, on stock's modules and on ours: what they answer, log, call and raise."""

from __future__ import annotations

import pytest
from faces import same
from harness import Master

MASTERS = ("ours",)

BEGIN = """
import re, threading
import rospy, actionlib
from actionlib.msg import (TestAction, TestActionFeedback, TestActionGoal, TestActionResult, TestFeedback, TestGoal,
                           TestResult)
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
rospy.init_node("parts")
for name in ("logdebug", "loginfo", "logwarn", "logerr"):
    def log(text, *args, name=name):
        text = (text % args if args else text).split("Traceback")[0].split(" with destruction time")[0].strip()
        text = re.sub(r"1\\d{9}[.\\d]*", "NOW", re.sub(r"nsecs: *\\d+", "nsecs", text))
        print("   ", name, text.replace("_has_header", "PENDING"))  # a name of 0 in stock's classes
    setattr(rospy, name, log)
def attempt(function, *args, **names):
    try:
        result = function(*args, **names)
        print("   ->", str(result).replace("\\n", " ") if "object at" not in str(result) else type(result).__name__)
    except Exception as error:
        print("    raises", type(error).__name__, error)
def status(number, name="g"):
    return GoalStatus(goal_id=GoalID(id=name), status=number, text="text")
"""

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
GENERATOR = """
import actionlib.goal_id_generator as module
from actionlib.goal_id_generator import GoalIDGenerator
generator = GoalIDGenerator()
print(generator.name, module.s_goalcount, module.s_goalcount_lock.locked())
made = generator.generate_ID()
print(made.id == "/parts-1-%d.%d" % (made.stamp.secs, made.stamp.nsecs), module.s_goalcount)
attempt(generator.set_name, "/other")
print(generator.generate_ID().id.split("-")[:2])
module.s_goalcount = 100
print(GoalIDGenerator(name="me").generate_ID().id.split("-")[:2])
"""
TRACKERS = """
from actionlib.status_tracker import StatusTracker
from actionlib.handle_tracker_deleter import HandleTrackerDeleter
from actionlib.server_goal_handle import ServerGoalHandle
def show(tracker):
    own = tracker.status
    print("   =", own.goal_id.id.split("-")[0], own.goal_id.stamp.secs if own.goal_id.stamp.secs < 99 else "now", own.status,
          own.text, tracker.goal is None, tracker.handle_tracker, tracker.handle_destruction_time.is_zero())
show(StatusTracker(GoalID(id="x", stamp=rospy.Time(4)), GoalStatus.RECALLING))
for goal_id in (GoalID(id="x", stamp=rospy.Time(4)), GoalID(id="x"), GoalID(stamp=rospy.Time(4)), GoalID()):
    message = TestActionGoal(goal_id=goal_id)
    show(StatusTracker(goal=message))
    print("   ", message.goal_id.id, message.goal_id.stamp.is_zero())
attempt(StatusTracker)
attempt(StatusTracker, None, 3)
class Server:
    lock = threading.RLock()
    ActionResultType = TestResult
    publish_status = lambda self: print("    publishes status")
    publish_result = lambda self, status, result: print("    publishes result", status.status, status.text, result.result)
    publish_feedback = lambda self, status, feedback: print("    publishes feedback", status.status, feedback.feedback)
def handle(number=0, name="g"):
    tracker = StatusTracker(goal=TestActionGoal(goal_id=GoalID(id=name, stamp=rospy.Time(5)), goal=TestGoal(7)))
    tracker.status.status = number
    return ServerGoalHandle(tracker, Server(), None)
for number in range(11):
    for name in ("set_accepted", "set_canceled", "set_rejected", "set_aborted", "set_succeeded", "set_cancel_requested"):
        print(name, number)
        made = handle(number)
        attempt(getattr(made, name))
        show(made.status_tracker)
made = handle()
attempt(made.set_accepted, text="begin")
show(made.status_tracker)
attempt(made.publish_feedback, TestFeedback(2))
attempt(made.set_succeeded, TestResult(9), "end")
show(made.status_tracker)
for ask in (made.get_goal, made.get_goal_id, made.get_goal_status, made.get_default_result):
    attempt(ask)
none, half, other = ServerGoalHandle(), ServerGoalHandle(made.status_tracker), handle(0, "h")
print(made == handle(), made != handle(), made == other, made == none, none == none, none != none, hash(made) == hash("g"))
attempt(lambda: made == 3)
attempt(lambda: none == 3)
for empty in (none, half):
    for ask in (empty.get_goal, empty.get_goal_id, empty.get_goal_status, empty.get_default_result, empty.set_accepted,
                empty.set_canceled, empty.set_rejected, empty.set_aborted, empty.set_succeeded,
                empty.set_cancel_requested):
        print(ask.__name__)
        attempt(ask)
    attempt(empty.publish_feedback, TestFeedback())
for server in (None, Server()):
    tracker = other.status_tracker
    attempt(HandleTrackerDeleter(server, tracker), None)
    print(tracker.handle_destruction_time.is_zero())
attempt(HandleTrackerDeleter(Server(), tracker))
"""
TOPICS = """
class Topic:
    def __init__(self, name):
        self.name = name
    def publish(self, message):
        print("    publishes", self.name, message.header.stamp.is_zero(), end=" ")
        if self.name == "status":
            print([(each.goal_id.id, each.status, each.text[:14]) for each in message.status_list])
        else:
            part = message.result if self.name == "result" else message.feedback
            print(message.status.goal_id.id, message.status.status, message.status.text, str(part).strip())
    def unregister(self):
        print("    unregisters", self.name)
    shutdown = unregister
def with_topics(server):
    for name in ("status_pub", "result_pub", "feedback_pub", "goal_sub", "cancel_sub", "status_timer"):
        setattr(server, name, Topic(name.partition("_")[0] if "_pub" in name else name))
    server.started = True
    server.status_list_timeout = rospy.Duration(1000)
    return server
"""
SERVER = (
    TOPICS
    + """
from actionlib.action_server import ActionServer, nop_cb
attempt(ActionServer, "x", TestGoal, print, print, False)
attempt(ActionServer, "x", TestAction, None, auto_start=False)
attempt(ActionServer, "x", 3, print, auto_start=False)
handles = []
def on_goal(handle):
    print("    goal", handle.get_goal_id().id, handle.get_goal_status().status)
    handles.append(handle)
def on_cancel(handle):
    print("    cancel", handle.get_goal_id().id, handle.get_goal_status().status)
server = ActionServer("act", TestAction, on_goal, on_cancel, False)
print(server.started, server.ns, server.ActionResultType is TestResult, server.status_list, server.last_cancel, server.goal_sub)
attempt(server.internal_goal_callback, TestActionGoal())
attempt(server.internal_cancel_callback, GoalID())
attempt(server.publish_status_async, None)
attempt(server.publish_status)
with_topics(server)
def goal(name, secs=0):
    print("goal", name, secs)
    attempt(server.internal_goal_callback, TestActionGoal(goal_id=GoalID(id=name, stamp=rospy.Time(secs)), goal=TestGoal(7)))
def cancel(name, secs=0):
    print("cancel", name, secs)
    attempt(server.internal_cancel_callback, GoalID(id=name, stamp=rospy.Time(secs)))
    print("    last", server.last_cancel.secs, [(each.status.goal_id.id, each.status.status) for each in server.status_list])
goal("a", 10)
goal("a", 10)
goal("b", 20)
goal("c", 30)
cancel("early")
cancel("a")
goal("a", 10)
cancel("", 20)
goal("late", 15)
goal("early", 50)
goal("early", 50)
goal("d", 40)
cancel("d", 35)
goal("timeless")
goal("f", 100)
cancel("")
cancel("nowhere", 200)
goal("g", 150)
goal("nowhere", 300)
for each in server.status_list:
    print(each.status.goal_id.id, each.status.status, each.goal is None, each.handle_tracker is None)
attempt(handles[0].set_accepted)
attempt(handles[1].set_canceled, TestResult(4), "stopped")
attempt(handles[2].publish_feedback, TestFeedback(9))
attempt(server.publish_result, status(3, "q"), TestResult(1))
attempt(server.publish_feedback, status(3, "q"), TestFeedback(1))
attempt(server.publish_status_async, "event")
for each in server.status_list[::2]:
    each.handle_destruction_time = rospy.Time(5)
server.status_list_timeout = rospy.Duration(2)
attempt(server.publish_status)
attempt(server.register_goal_callback, None)
attempt(server.register_cancel_callback, cancel_cb=None)
goal("w", 500)
cancel("w")
print(nop_cb(None), nop_cb.__name__)
attempt(server.stop)
print(server.started)
attempt(ActionServer("never", TestAction, on_goal, auto_start=False).stop)
"""
)
STARTED = """
def state(topic):
    return None if topic is None else topic.resolved_name
server = actionlib.ActionServer("act", TestAction, print, auto_start=False)
attempt(server.initialize)
print(server.started, server.status_frequency, server.status_list_timeout.to_sec(), server.pub_queue_size, server.sub_queue_size)
print([state(topic) for topic in (server.status_pub, server.result_pub, server.feedback_pub, server.goal_sub, server.cancel_sub)])
attempt(server.stop)
for name, value in (("act/status_frequency", 7), ("act/status_frequency", 0), ("/actionlib_status_frequency", 2.5),
                    ("act/status_list_timeout", 2), ("actionlib_server_pub_queue_size", 3),
                    ("actionlib_server_pub_queue_size", -3), ("actionlib_server_sub_queue_size", 4),
                    ("actionlib_server_sub_queue_size", 0), ("actionlib_server_pub_queue_size", "x"),
                    ("act/status_frequency", "x")):
    print(name, value)
    rospy.set_param(name, value)
    server = actionlib.ActionServer("act", TestAction, print, auto_start=False)
    attempt(server.start)
    print(server.started, getattr(server, "status_frequency", None), server.status_list_timeout.to_sec(),
          server.pub_queue_size, getattr(server, "sub_queue_size", "none"))
    rospy.delete_param(name)
print("client")
for name, value in (("actionlib_client_pub_queue_size", 3), ("actionlib_client_pub_queue_size", -3),
                    ("actionlib_client_sub_queue_size", 4), ("actionlib_client_sub_queue_size", 0),
                    ("actionlib_client_sub_queue_size", "x")):
    rospy.set_param(name, value)
    try:
        client = actionlib.ActionClient("act", TestAction)
        print(client.pub_queue_size, client.sub_queue_size, state(client.pub_goal), state(client.pub_cancel),
              [state(topic) for topic in (client.status_sub, client.result_sub, client.feedback_sub)])
        print(client.ns, client.ActionSpec is TestAction)
        client.stop()
    except Exception as error:
        print(type(error).__name__)
    rospy.delete_param(name)
client = actionlib.ActionClient("nobody", TestAction)
attempt(client.wait_for_action_server_to_start, rospy.Duration(0.1))
attempt(client.wait_for_server, timeout=rospy.Duration(0.1))
attempt(client.wait_for_server, 0.1)
"""
SIMPLE_SERVER = (
    TOPICS
    + """
from actionlib.simple_action_server import SimpleActionServer
server = SimpleActionServer("act", TestAction, auto_start=False)
below = with_topics(server.action_server)
def show():
    def name(handle):
        return handle.goal and (handle.goal.goal_id.id, handle.get_goal_status().status)
    print("   =", name(server.current_goal), name(server.next_goal), server.new_goal, server.preempt_request,
          server.new_goal_preempt_request, server.is_active(), server.is_preempt_requested(), server.is_new_goal_available())
def do(name, *args):
    print(name)
    attempt(getattr(server, name), *args)
    show()
def goal(name, secs):
    print("goal", name, secs)
    message = TestActionGoal(goal_id=GoalID(id=name, stamp=rospy.Time(secs)), goal=TestGoal(secs))
    attempt(below.internal_goal_callback, message)
    show()
def cancel(name, secs=0):
    print("cancel", name, secs)
    attempt(below.internal_cancel_callback, GoalID(id=name, stamp=rospy.Time(secs)))
    show()
def wrong():
    raise ValueError("wrong")
for name in ("get_default_result", "set_aborted", "set_succeeded", "set_preempted", "accept_new_goal"):
    do(name)
do("publish_feedback", TestFeedback(2))
def on_goal():
    print("    goal callback", server.is_new_goal_available(), server.is_preempt_requested())
def on_preempt():
    print("    preempt callback", server.is_new_goal_available(), server.is_preempt_requested())
do("register_goal_callback", on_goal)
do("register_preempt_callback", on_preempt)
goal("a", 10)
goal("b", 20)
goal("old", 15)
cancel("b")
goal("c", 30)
do("accept_new_goal")
cancel("c")
do("accept_new_goal")
do("publish_feedback", TestFeedback(2))
do("set_preempted", TestResult(1), "stopped")
goal("d", 40)
do("accept_new_goal")
goal("e", 50)
goal("e2", 45)
cancel("e")
do("accept_new_goal")
do("set_succeeded")
goal("f", 60)
do("accept_new_goal")
do("set_aborted", None, "sorry")
do("set_aborted")
goal("g", 70)
cancel("g")
do("accept_new_goal")
do("set_aborted", TestResult(5))
goal("h", 80)
do("accept_new_goal")
goal("i", 80)
do("accept_new_goal")
goal("j", 75)
cancel("", 80)
do("set_preempted")
goal("k", 90)
do("accept_new_goal")
do("set_succeeded", TestResult(3), "good")
goal("l", 88)
do("register_goal_callback", wrong)
do("register_preempt_callback", wrong)
goal("n", 100)
do("accept_new_goal")
goal("o", 110)
cancel("o")
cancel("n")
do("register_goal_callback", None)
do("register_preempt_callback", None)
goal("p", 120)
do("accept_new_goal")
cancel("p")
empty = actionlib.ServerGoalHandle()
do("internal_preempt_callback", empty)
do("internal_goal_callback", empty)
"""
)
EXECUTING = (
    TOPICS
    + """
from actionlib.simple_action_server import SimpleActionServer
came = threading.Semaphore(0)
def execute(goal):
    print("    executes", goal.goal, server.is_active(), threading.current_thread() is server.execute_thread)
    if goal.goal == 1:
        server.set_succeeded(TestResult(1))
    elif goal.goal == 2:
        raise ValueError("wrong")
    elif goal.goal == 4:
        server.set_preempted()
    elif goal.goal == 5:
        server.set_aborted()
class Waking(Topic):
    def publish(self, message):
        Topic.publish(self, message)
        if message.status.goal_id.id != "6":
            came.release()
server = SimpleActionServer("act", TestAction, execute_cb=execute, auto_start=False)
below = with_topics(server.action_server)
below.result_pub = Waking("result")
attempt(server.register_goal_callback, print)
print(server.goal_callback, server.execute_thread.is_alive(), server.execute_thread.daemon, server.executeLoop.__name__)
for number in range(1, 6):
    message = TestActionGoal(goal_id=GoalID(id=str(number), stamp=rospy.Time(number)), goal=TestGoal(number))
    below.internal_goal_callback(message)
    assert came.acquire(timeout=20)
    with below.lock:  # the status is published, too
        print("    active", server.is_active())
rospy.signal_shutdown("done")
server.execute_thread.join(20)
print(server.execute_thread.is_alive(), server.need_to_terminate)
"""
)
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
    "generator": (GENERATOR, "['me', '101']"),
    "trackers": (TRACKERS, "uninitialized"),
    "server": (SERVER, "cancel nowhere 200"),
    "started": (STARTED, "deprecated"),
    "simple_server": (SIMPLE_SERVER, "exception wrong"),
    "executing": (EXECUTING, "Exception in execute callback: wrong"),
    "simple_client": (SIMPLE_CLIENT, "received DONE twice"),
    "connected": (CONNECTED, "feedback_sub False"),
}


@pytest.mark.parametrize("part", PROGRAMS)
def test_part(master: Master, part: str) -> None:
    text, expected = PROGRAMS[part]
    assert expected in same(master, BEGIN + text)
