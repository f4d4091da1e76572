"""actionlib on stock's modules and on ours: the same programs, and pairs of programs on both."""

from __future__ import annotations

import itertools
import signal
from pathlib import Path

import pytest
from faces import FACES, run, same, start
from harness import ROSCPP_PEER, Master, Process

MASTERS = ("ours",)
MODULES = [
    "action_client",
    "action_server",
    "exceptions",
    "goal_id_generator",
    "handle_tracker_deleter",
    "server_goal_handle",
    "simple_action_client",
    "simple_action_server",
    "status_tracker",
]
PAIRS = [pair for pair in itertools.product(FACES, FACES) if pair != ("stock", "stock")]

SURFACE = """
import importlib, inspect, sys, types
import actionlib, actionlib.msg
print(sorted(n for n in dir(actionlib) if n[0] != "_" and not isinstance(getattr(actionlib, n), types.ModuleType)
             and n not in ("g_goal_id", "annotations", "Any")))
print(sorted(n for n in dir(actionlib.msg) if n.startswith("Test") or n.startswith("Two")))
for name in sys.argv[1:]:
    module = importlib.import_module("actionlib." + name)
    starred = {}
    exec("from actionlib.%s import *" % name, starred)
    classes = {k: v for k, v in starred.items() if inspect.isclass(v) and v.__module__.startswith("actionlib.")
               and v.__module__.count(".") == 1}
    print(name, sorted(classes))
    for key, value in sorted(classes.items()):
        for member in sorted(vars(value)):
            what = getattr(value, member)
            if isinstance(what, property):
                continue  # what stock has in objects
            if member[0] != "_" or member in ("__init__", "__call__"):
                print(name, key, member, list(inspect.signature(what).parameters) if callable(what) else what)
"""


def test_names_and_arguments(master: Master) -> None:
    text = same(master, SURFACE, *MODULES)
    assert "simple_action_client SimpleActionClient send_goal_and_wait" in text


MACHINES = """
import random, sys
import rospy, actionlib
from actionlib.action_client import CommState, CommStateMachine, ClientGoalHandle
from actionlib.server_goal_handle import ServerGoalHandle
from actionlib.status_tracker import StatusTracker
from actionlib.msg import TestActionGoal, TestActionResult, TestActionFeedback, TestResult
from actionlib_msgs.msg import GoalID, GoalStatus, GoalStatusArray
rospy.init_node("machines")
for name in ("logerr", "logwarn"):
    def log(text, *args, name=name):
        print(name, (text % args if args else text).replace("_has_header", "PENDING"))  # a name of 0 in stock's classes
    setattr(rospy, name, log)
chance = random.Random(int(sys.argv[1]))
for _ in range(200):
    goal = TestActionGoal(goal_id=GoalID(id="g"))
    steps = []
    machine = CommStateMachine(goal, lambda gh: steps.append(CommState.to_string(gh.get_comm_state())),
                               lambda gh, feedback: steps.append(feedback.feedback), None,
                               lambda request: steps.append(request.id))
    handle = ClientGoalHandle(machine)
    for _ in range(chance.randrange(12)):
        status = GoalStatus(goal_id=GoalID(id=chance.choice("ggggh")), status=chance.randrange(11), text="t")
        what = chance.randrange(12)
        if what < 8:
            machine.update_status(GoalStatusArray(status_list=[GoalStatus(), status]))
        elif what == 8:
            machine.update_result(TestActionResult(status=status, result=TestResult(result=5)))
        elif what == 9:
            machine.update_feedback(TestActionFeedback(status=status))
        elif what == 10:
            handle.cancel()
        else:
            machine.update_status(GoalStatusArray())
        result = handle.get_result()
        print(steps, machine.state, handle.get_goal_status(), handle.get_goal_status_text(), result and result.result,
              GoalStatus.to_string(handle.get_goal_status() or GoalStatus.LOST))
    print(handle.get_terminal_state(), handle == ClientGoalHandle(machine), handle != None)


class Server:
    class lock:
        __enter__ = __exit__ = lambda *_: None
    lock = lock()
    ActionResultType = TestResult
    def publish_status(self):
        print("status")
    def publish_result(self, status, result):
        print("result", status.status, status.text, result.result)
    def publish_feedback(self, status, feedback):
        print("feedback", status.status)


for _ in range(200):
    tracker = StatusTracker(goal=TestActionGoal(goal_id=GoalID(id="g", stamp=rospy.Time(5))))
    handle = ServerGoalHandle(tracker, Server(), None)
    for _ in range(chance.randrange(6)):
        name = chance.choice(["accepted", "canceled", "rejected", "aborted", "succeeded", "cancel"])
        if name == "cancel":
            print(handle.set_cancel_requested())
        elif name == "accepted":
            handle.set_accepted("yes")
        else:
            getattr(handle, "set_" + name)(chance.choice([None, TestResult(result=7)]), "text")
        status = handle.get_goal_status()
        print(name, status.status, status.text, handle.get_goal_id().id, tracker.handle_destruction_time.is_zero())
nothing = ServerGoalHandle()
print(nothing.get_goal(), nothing == nothing, nothing != handle, nothing.get_goal_status().status)
"""


@pytest.mark.parametrize("seed", range(3))
def test_states_of_random_goals(master: Master, seed: int) -> None:
    assert "SUCCEEDED" in same(master, MACHINES, str(seed))


SERVER = """
import sys, threading
import rospy, actionlib
from actionlib.msg import TestRequestAction, TestRequestFeedback, TestRequestGoal, TestRequestResult

def execute(goal):
    rate = rospy.Rate(100)
    if goal.pause_status.to_sec() < 0:
        while not server.is_preempt_requested() and not rospy.is_shutdown():
            rate.sleep()
        server.set_preempted(TestRequestResult(the_result=goal.the_result), "stopped")
        return
    for _ in range(3):
        server.publish_feedback(TestRequestFeedback())
    result = TestRequestResult(the_result=goal.the_result, is_simple_server=True)
    kind = goal.terminate_status
    if kind == TestRequestGoal.TERMINATE_SUCCESS:
        server.set_succeeded(result, goal.result_text)
    elif kind == TestRequestGoal.TERMINATE_ABORTED:
        server.set_aborted(result, goal.result_text)
    elif kind == TestRequestGoal.TERMINATE_EXCEPTION:
        raise Exception(goal.result_text)

rospy.init_node("server")
server = actionlib.SimpleActionServer("action", TestRequestAction, execute, False)
server.start()
print("ready", flush=True)
rospy.spin()
"""
CLIENT = """
import sys, threading
import rospy, actionlib
from actionlib_msgs.msg import GoalStatus
from actionlib.msg import TestRequestAction, TestRequestGoal
rospy.init_node("client")
client = actionlib.SimpleActionClient("action", TestRequestAction)
print(client.get_state(), client.get_result(), client.get_goal_status_text(), client.wait_for_result())
assert client.wait_for_server(rospy.Duration(20))
LIMIT = rospy.Duration(20)
for kind in range(6):
    goal = TestRequestGoal(terminate_status=kind, the_result=10 + kind, result_text="text %d" % kind)
    called, done = [], threading.Event()
    def ended(state, result):
        called.append(("done", state, result.the_result))
        done.set()
    with client.action_client.manager.list_mutex:  # stock loses an end that comes before send_goal has returned
        client.send_goal(goal, ended, None, lambda feedback: called.append("feedback"))
    assert client.wait_for_result(LIMIT)
    assert done.wait(20)
    print(kind, called[-1], set(map(str, called)) <= {"feedback", str(called[-1])})
    print(GoalStatus.to_string(client.get_state()), repr(client.get_goal_status_text()), client.get_result())
forever = TestRequestGoal(pause_status=rospy.Duration(-1), the_result=3)
state = client.send_goal_and_wait(forever, rospy.Duration(0.5), LIMIT)
print("cancelled", GoalStatus.to_string(state), client.get_goal_status_text(), client.get_result().the_result)
for cancel in ("cancel_all_goals", "cancel_goals_at_and_before_time"):
    client.send_goal(forever)
    while client.get_state() != GoalStatus.ACTIVE:  # stock's active_cb is lost if the server is quick
        rospy.sleep(0.01)
    getattr(client, cancel)(*([rospy.Time.now()] if "time" in cancel else []))
    assert client.wait_for_result(LIMIT)
    print(cancel, GoalStatus.to_string(client.get_state()))
client.stop_tracking_goal()
client.cancel_goal()
print(client.get_state())
"""


def end(process: Process) -> None:
    process.signal(signal.SIGINT)
    assert process.wait() == 0


def test_simple_clients_and_servers_in_all_pairs(launcher: Master) -> None:
    said = {}
    for serving in FACES:
        server = start(serving, launcher, SERVER)
        server.wait_line("ready")
        for asking in FACES:
            said[serving, asking] = run(asking, launcher, CLIENT)
        end(server)
    assert "cancelled PREEMPTED stopped 3" in said["stock", "stock"]
    assert set(said.values()) == {said["stock", "stock"]}


LOW_SERVER = """
import rospy, actionlib
from actionlib.msg import TwoIntsAction, TwoIntsResult
waiting = []
def on_goal(handle):
    a = handle.get_goal().a
    if a % 5 == 0:
        handle.set_rejected(None, "no")
    elif a % 5 == 1:
        waiting.append(handle)
    else:
        handle.set_accepted("go")
        if a % 5 == 2:
            handle.set_succeeded(TwoIntsResult(a), "sum")
        elif a % 5 == 3:
            handle.set_aborted(TwoIntsResult(a), "sorry")
        else:
            waiting.append(handle)
def on_cancel(handle):
    handle.set_canceled(TwoIntsResult(handle.get_goal().a), "cancelled")
rospy.init_node("server")
server = actionlib.ActionServer("many", TwoIntsAction, on_goal, on_cancel, False)
server.start()
print("ready", flush=True)
rospy.spin()
"""
LOW_CLIENT = """
import sys, threading
import rospy, actionlib
from actionlib_msgs.msg import GoalStatus
from actionlib import CommState
from actionlib.msg import TwoIntsAction, TwoIntsGoal
rospy.init_node("client")
client = actionlib.ActionClient("many", TwoIntsAction)
assert client.wait_for_server(rospy.Duration(20))
changed = threading.Condition()
def changes(handle):
    with changed:
        changed.notify_all()
def reach(handles, states):
    with changed:
        assert changed.wait_for(lambda: all(h.get_comm_state() in states for h in handles), 20), [
            CommState.to_string(h.get_comm_state()) for h in handles]
probe = None
while probe is None or probe.get_comm_state() != CommState.DONE:  # stock's server may lose the first goal's result
    probe = client.send_goal(TwoIntsGoal(a=3, b=1), changes)
    with changed:
        changed.wait_for(lambda: probe.get_comm_state() == CommState.DONE, 5)
handles = []
for a in range(10):  # so few that no queue overflows
    handles.append(client.send_goal(TwoIntsGoal(a=a, b=1), changes))
reach([h for a, h in enumerate(handles) if a % 5 not in (1, 4)], [CommState.DONE])
reach([h for a, h in enumerate(handles) if a % 5 == 1], [CommState.PENDING])
reach([h for a, h in enumerate(handles) if a % 5 == 4], [CommState.ACTIVE])
handles[1].cancel()
reach([handles[1]], [CommState.DONE])
client.cancel_all_goals()
reach(handles, [CommState.DONE])
for a, handle in enumerate(handles):
    print(a, handle.get_terminal_state(),
          handle.get_goal_status_text(), handle.get_result().sum)
"""


def test_many_goals_in_all_pairs(launcher: Master) -> None:
    said = {}
    for serving in FACES:
        server = start(serving, launcher, LOW_SERVER)
        server.wait_line("ready")
        for asking in FACES:
            said[serving, asking] = run(asking, launcher, LOW_CLIENT)
        end(server)
    assert "9 2 cancelled 9" in said["stock", "stock"]
    assert set(said.values()) == {said["stock", "stock"]}


RACES = """
import threading
import rospy, actionlib
from actionlib.msg import TestAction, TestActionGoal, TestActionResult, TestGoal, TestResult
from actionlib_msgs.msg import GoalID, GoalStatusArray
rospy.init_node("races", disable_signals=True)
came = threading.Condition()
results, statuses, events = [], [], []
def event(text):
    with came:
        events.append(text)
        came.notify_all()
def on_result(message):
    with came:
        results.append(message)
        came.notify_all()
def on_status(message):
    with came:
        statuses.append({s.goal_id.id: s.status for s in message.status_list})
        came.notify_all()
def wait(what):
    with came:
        assert came.wait_for(what, 20), (what, events, [(r.status.goal_id.id, r.status.status) for r in results])
go_on = threading.Event()
def execute(goal):
    event("begin %d" % goal.goal)
    while not server.is_preempt_requested() and goal.goal != 4:
        go_on.wait(0.01)
    event("end %d" % goal.goal)
    if goal.goal == 4:
        server.set_succeeded(TestResult(4), "four")
    elif goal.goal != 2:
        server.set_preempted(TestResult(goal.goal), "preempted")
    # goal 2 gets no end
server = actionlib.SimpleActionServer("race", TestAction, execute, False)
server.register_preempt_callback(lambda: event("preempt"))
server.start()
server.register_goal_callback(lambda: event("never"))
goals = rospy.Publisher("race/goal", TestActionGoal, queue_size=10)
cancels = rospy.Publisher("race/cancel", GoalID, queue_size=10)
rospy.Subscriber("race/result", TestActionResult, on_result)
rospy.Subscriber("race/status", GoalStatusArray, on_status)
rate = rospy.Rate(100)
while not (goals.get_num_connections() and cancels.get_num_connections() and statuses):
    rate.sleep()
while not server.action_server.result_pub.get_num_connections():
    rate.sleep()
def send(name, seconds):
    message = TestActionGoal(goal=TestGoal(int(name)))
    message.goal_id = GoalID(id=name, stamp=rospy.Time(seconds))
    goals.publish(message)
send("1", 100)
wait(lambda: "begin 1" in events)
send("2", 101)  # preempts 1
wait(lambda: len(results) == 1 and "begin 2" in events)
send("3", 50)  # older than the present one: cancelled at once
wait(lambda: len(results) == 2)
send("2", 101)  # again: known
cancels.publish(GoalID(id="2"))
wait(lambda: len(results) == 3)
cancels.publish(GoalID(id="5"))  # comes before its goal
wait(lambda: statuses[-1].get("5") == 7)
send("5", 102)
wait(lambda: len(results) == 4)
send("4", 103)
wait(lambda: len(results) == 5)
cancels.publish(GoalID(stamp=rospy.Time(200)))
cancels.publish(GoalID(id="6"))
wait(lambda: statuses[-1].get("6") == 7)
send("7", 150)  # older than the request to cancel
wait(lambda: len(results) == 6)
send("8", 300)
wait(lambda: "begin 8" in events)
before = events.count("preempt")
send("9", 301)
wait(lambda: events.count("preempt") > before)  # a request to cancel that comes before its goal leaves 8 running
cancels.publish(GoalID(id="9"))  # cancelled while it waits, or once it has begun
wait(lambda: len(results) == 8)
for message in results:
    print(message.status.goal_id.id, message.status.status, message.status.text, message.result.result)
print([each for each in events if each != "preempt"])
print("preempt" in events, server.is_active(), server.is_new_goal_available())
print(server.accept_new_goal())
print(server.execute_thread.is_alive())
rospy.signal_shutdown("done")
server.execute_thread.join(20)
print(server.execute_thread.is_alive())
"""


def test_races_in_a_simple_server(launcher: Master) -> None:
    text = same(launcher, RACES)
    assert "No terminal state was set." in text
    assert "its timestamp is before the timestamp" in text


EXCEPTIONS = """
import rospy, actionlib
from actionlib.msg import TestGoal
rospy.init_node("exceptions")
for make in (lambda: actionlib.SimpleActionClient("x", TestGoal), lambda: actionlib.ActionClient("x", TestGoal),
             lambda: actionlib.ActionServer("x", TestGoal, print, print, False),
             lambda: actionlib.SimpleActionServer("x", TestGoal, None, False),
             lambda: actionlib.ActionServer("x", actionlib.msg.TestAction, None)):
    try:
        make()
    except Exception as error:
        print(type(error).__name__, str(error).split("'")[0])
from actionlib.goal_id_generator import GoalIDGenerator
made = GoalIDGenerator("me").generate_ID()
print(made.id.split("-")[0], made.id.endswith("%d.%d" % (made.stamp.secs, made.stamp.nsecs)))
client = actionlib.SimpleActionClient("nobody", actionlib.msg.TestAction)
print(client.wait_for_server(rospy.Duration(0.1)))
client.action_client.stop()
"""


def test_exceptions_and_waits(launcher: Master) -> None:
    assert "ActionException" in same(launcher, EXCEPTIONS)


LOST_CLIENT = """
import threading
import rospy, actionlib
from actionlib_msgs.msg import GoalStatus
from actionlib.msg import TwoIntsAction, TwoIntsGoal
rospy.init_node("client")
client = actionlib.SimpleActionClient("many", TwoIntsAction)
assert client.wait_for_server(rospy.Duration(20))
done = threading.Event()
client.send_goal(TwoIntsGoal(a=4), lambda state, result: (print("lost", state, result, flush=True), done.set()))
while client.get_state() != GoalStatus.ACTIVE:
    rospy.sleep(0.01)
print("active", flush=True)
assert done.wait(40)
print(GoalStatus.to_string(client.get_state()), flush=True)
client.send_goal(TwoIntsGoal(a=2))
assert client.wait_for_server(rospy.Duration(20))
"""


@pytest.mark.parametrize(("serving", "asking"), PAIRS)
def test_a_server_that_is_killed_and_restarted_has_lost_its_goal(launcher: Master, serving: str, asking: str) -> None:
    server = start(serving, launcher, LOW_SERVER)
    server.wait_line("ready")
    client = start(asking, launcher, LOST_CLIENT)
    client.wait_line("active")
    server.signal(signal.SIGKILL)
    server.wait()
    again = start(serving, launcher, LOW_SERVER)
    again.wait_line("ready")
    client.wait_line("lost 9 None")
    client.wait_line("LOST")
    assert client.wait() == 0
    end(again)


OURS = """
import sys
import pyros1
from pyros1 import actions
from pyros1.msgs.actionlib.msg import TwoIntsAction, TwoIntsGoal
with pyros1.Node("ours") as node, actions.Client(node, "many", TwoIntsAction) as client:
    while not client.send(TwoIntsGoal(a=3), timeout=20).wait(5):
        pass  # stock's server may lose the first goal's result
    for a in range(4):
        goal = client.send(TwoIntsGoal(a=a), timeout=20)
        if a == 1:
            goal.cancel()
        try:
            print(goal.result(20).sum, goal.text)
        except actions.GoalError as error:
            print(error.status.name, error.text, error.result.sum)
    goals = [client.send(TwoIntsGoal(a=4)) for _ in range(8)]
    while any(goal.stage is not actions.Stage.ACTIVE for goal in goals):
        node.sleep(0.01)  # a request that overtakes a goal does not cancel it
    client.cancel_all()
    for goal in goals:
        assert goal.wait(20)
        print(goal.done)
"""
OUR_SERVER = """
import pyros1
from pyros1 import actions
from pyros1.msgs.actionlib.msg import TestRequestAction, TestRequestFeedback, TestRequestGoal, TestRequestResult
def execute(goal):
    want = goal.goal
    result = TestRequestResult(the_result=want.the_result, is_simple_server=True)
    if want.pause_status.to_sec() < 0:
        while not goal.cancel_requested and node.sleep(0.01):
            pass
        return goal.cancel(result, "stopped")
    for _ in range(3):
        goal.feedback(TestRequestFeedback())
    if want.terminate_status == 0:
        return goal.succeed(result, want.result_text)
    if want.terminate_status == 1:
        return goal.abort(result, want.result_text)
    if want.terminate_status == 5:
        return goal.abort(text="Exception in execute callback: " + want.result_text)
    goal.abort(text="No terminal state was set.")
with pyros1.Node("server") as node, actions.SimpleServer(node, "action", TestRequestAction, execute):
    print("ready", flush=True)
    node.spin()
"""


def test_pyros1_actions_with_stock(launcher: Master) -> None:
    """The room below our face: its client with stock's server, its server with stock's client."""
    server = start("stock", launcher, LOW_SERVER)
    server.wait_line("ready")
    lines = run("ours", launcher, OURS).splitlines()
    end(server)
    assert lines[0] == "REJECTED no 0"
    assert lines[1] in ("RECALLED cancelled 1", "RECALLED  0")
    assert lines[2:4] == ["2 sum", "ABORTED sorry 3"]
    expecting = start("stock", launcher, SERVER)
    expecting.wait_line("ready")
    expected = run("stock", launcher, CLIENT)
    end(expecting)
    server = start("ours", launcher, OUR_SERVER)
    server.wait_line("ready")
    assert run("stock", launcher, CLIENT) == expected
    end(server)


@pytest.fixture
def roscpp_peer() -> str:
    """The roscpp program; interop/setup builds it."""
    program = ROSCPP_PEER.with_name("action_peer")
    if not program.exists():
        pytest.skip("action_peer is not built: run interop/setup")
    return str(program)


@pytest.mark.parametrize("text", [SERVER, OUR_SERVER], ids=["actionlib", "pyros1"])
def test_a_roscpp_client(launcher: Master, roscpp_peer: str, text: str) -> None:
    server = start("ours", launcher, text)
    server.wait_line("ready")
    client = launcher.run([roscpp_peer, "client"])
    for expected in ("ended SUCCEEDED 10 text", "ended ABORTED 11 text", "cancelled PREEMPTED 11 stopped"):
        client.wait_line(expected)
    client.wait_line("cancelled PREEMPTED 11 stopped")
    assert client.wait() == 0
    end(server)


CPP_CLIENT = CLIENT.replace("in range(6)", "in range(2)")


def test_a_roscpp_server(launcher: Master, roscpp_peer: str) -> None:
    server = launcher.run([roscpp_peer, "server"])
    server.wait_line("ready")
    said = [run(face, launcher, CPP_CLIENT) for face in FACES]
    assert "cancelled PREEMPTED stopped 3" in said[0]
    assert said[1] == said[0]
    server.signal(signal.SIGINT)
    server.wait()


TOOLS = """
import sys
sys.path.insert(0, sys.argv[1])
import rospy
from actionlib_tools.library import to_yaml, yaml_msg_str, yaml_msgs_str
from actionlib_tools.dynamic_action import DynamicAction
from actionlib.msg import TestRequestGoal
from actionlib_msgs.msg import GoalStatus
print(to_yaml(TestRequestGoal(the_result=4, result_text="x")))
made = yaml_msg_str(TestRequestGoal, "{the_result: 7, pause_status: {secs: 1, nsecs: 2}}")
print(made.the_result, made.pause_status.to_sec(), to_yaml(GoalStatus(text="t")))
action = DynamicAction("actionlib/TestRequestAction")
print([getattr(action, name).__name__ for name in ("action", "goal", "feedback", "result")])
"""


def test_the_library_of_actionlib_tools(launcher: Master, tmp_path: Path) -> None:
    """Debian's actionlib_tools, unmodified, on our modules (its two programs need a window)."""
    (tmp_path / "actionlib_tools").symlink_to("/usr/lib/python3/dist-packages/actionlib_tools")
    assert "'TestRequestGoal'" in same(launcher, TOOLS, str(tmp_path))
