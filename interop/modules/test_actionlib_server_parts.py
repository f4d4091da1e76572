"""The parts of actionlib's servers, one by one, on stock's modules and on ours: what they answer, log, call and raise."""

from __future__ import annotations

import pytest
from action_programs import BEGIN, TOPICS
from faces import same
from harness import Master

MASTERS = ("ours",)

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
PROGRAMS = {
    "generator": (GENERATOR, "['me', '101']"),
    "trackers": (TRACKERS, "uninitialized"),
    "server": (SERVER, "cancel nowhere 200"),
    "started": (STARTED, "deprecated"),
    "simple_server": (SIMPLE_SERVER, "exception wrong"),
    "executing": (EXECUTING, "Exception in execute callback: wrong"),
}


@pytest.mark.parametrize("part", PROGRAMS)
def test_part(master: Master, part: str) -> None:
    text, expected = PROGRAMS[part]
    assert expected in same(master, BEGIN + text)
