"""smach_ros by pyros1: states that use topics, services and actions, in programs as users write them."""

from __future__ import annotations

import queue
import signal
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import pytest
from programs import environment, run, start
from smach_modules import imported

from pyros1.msgs.smach_msgs.msg import SmachContainerInitialStatusCmd, SmachContainerStatus, SmachContainerStructure
from pyros1.node import Node

TOPICS_AND_SERVICES = """
import rospy, smach, smach_ros
from std_msgs.msg import Int32
from std_srvs.srv import SetBool, SetBoolRequest, SetBoolResponse
rospy.init_node("states")

@smach.cb_interface(output_keys=["heard"])
def below_three(userdata, message):
    userdata.heard = message.data
    return message.data < 3

@smach.cb_interface(outcomes=["maybe"])
def judge(userdata, response):
    return "maybe" if response.message == "perhaps" else None

def answer(request):
    if not request.data:
        raise ValueError("no")
    return SetBoolResponse(request.data, "perhaps")

publisher = rospy.Publisher("numbers", Int32, queue_size=10)
count = [0]
def tick(event):
    count[0] += 1
    publisher.publish(count[0])
rospy.Timer(rospy.Duration(0.02), tick)
rospy.Service("judge", SetBool, answer)
tries = []

sm = smach.StateMachine(outcomes=["end"], output_keys=["message"])
with sm:
    add = smach.StateMachine.add
    add("MONITOR", smach_ros.MonitorState("numbers", Int32, below_three), {"invalid": "VALID", "valid": "end",
        "preempted": "end"})
    add("VALID", smach_ros.MonitorState("numbers", Int32, lambda ud, message: True, 2), {"valid": "WAIT",
        "invalid": "end", "preempted": "end"})
    add("WAIT", smach_ros.ConditionState(lambda ud: tries.append(1) or len(tries) == 3, max_checks=5,
        poll_rate=rospy.Duration(0.01)), {"true": "NEVER", "false": "end", "preempted": "end"})
    add("NEVER", smach_ros.ConditionState(lambda ud: False, max_checks=2, poll_rate=rospy.Duration(0.01)),
        {"false": "CALL", "true": "end", "preempted": "end"})
    add("CALL", smach_ros.ServiceState("judge", SetBool, request_slots=["data"], response_slots=["message"],
        response_cb=judge), {"maybe": "FAIL", "succeeded": "end", "aborted": "end", "preempted": "end"})
    add("FAIL", smach_ros.ServiceState("judge", SetBool, request=SetBoolRequest(False)), {"succeeded": "CALLBACK",
        "aborted": "CALLBACK", "preempted": "end"})
    add("CALLBACK", smach_ros.ServiceState("judge", SetBool, request_cb=lambda ud, request: SetBoolRequest(True),
        response_key="all"), {"succeeded": "end", "aborted": "end", "preempted": "end"})
sm.userdata.data = True
trace = []
sm.register_transition_cb(lambda ud, active: trace.extend(active))
print("outcome", sm.execute(), trace)
print("userdata", sm.userdata.message, sm.userdata.heard >= 3, sm.userdata.all.success, len(tries))
"""


def test_topics_services_and_conditions(environ: dict[str, str]) -> None:
    out = run(TOPICS_AND_SERVICES, environ)
    assert "outcome end ['VALID', 'WAIT', 'NEVER', 'CALL', 'FAIL', 'CALLBACK']" in out
    assert "userdata perhaps True True 3" in out
    assert "State machine transitioning 'MONITOR':'invalid'-->'VALID'" in out  # rospy's log
    assert "Exception when calling service 'judge'" in out


ACTIONS = """
import threading
import rospy, smach, smach_ros, actionlib
from actionlib_tutorials.msg import FibonacciAction, FibonacciGoal, FibonacciFeedback, FibonacciResult
from actionlib_msgs.msg import GoalStatus
rospy.init_node("actions")
running = threading.Event()

def execute(goal):
    if goal.order < 0:
        server.set_aborted(FibonacciResult([goal.order]))
        return
    running.set()
    if goal.order == 98:
        server.set_preempted()
        return
    while goal.order == 99 and not server.is_preempt_requested():
        rospy.sleep(0.01)
    running.clear()
    if goal.order == 99:
        server.set_preempted()
    else:
        server.set_succeeded(FibonacciResult(list(range(goal.order))))

server = actionlib.SimpleActionServer("fibonacci", FibonacciAction, execute, auto_start=False)
server.start()

def once(result_cb=None, userdata=(), preempt=False, **options):
    machine = smach.StateMachine(outcomes=["succeeded", "aborted", "preempted", "long"])
    for key, value in userdata:
        machine.userdata[key] = value
    with machine:
        state = smach_ros.SimpleActionState("fibonacci", FibonacciAction, result_cb=result_cb, **options)
        smach.StateMachine.add("ACTION", state)
    if preempt:
        threading.Thread(target=lambda: running.wait(20) and machine.request_preempt()).start()
    outcome = machine.execute()
    print(outcome, {key: machine.userdata[key] for key in sorted(machine.userdata.keys())})

def goal_cb(userdata, goal, order):
    goal.order = order

@smach.cb_interface(outcomes=["long"], output_keys=["last"])
def result_cb(userdata, status, result):
    userdata.last = result.sequence[-1]
    return "long" if status == GoalStatus.SUCCEEDED and len(result.sequence) > 3 else None

once()
once(goal=FibonacciGoal(order=2), result_key="result")
once(goal_slots=["order"], userdata=[("order", 3)], result_slots=["sequence"])
once(goal_key="g", userdata=[("g", FibonacciGoal(order=1))])
once(goal_cb=goal_cb, goal_cb_args=[5], result_cb=result_cb)
once(goal_cb=lambda userdata, goal: FibonacciGoal(order=-1))
once(goal=FibonacciGoal(order=98))
once(goal=FibonacciGoal(order=99), exec_timeout=rospy.Duration(0.2))
once(goal=FibonacciGoal(order=99), preempt=True)

@smach.cb_interface(input_keys=["order"], output_keys=["sequence"], outcomes=["done", "refused"])
def count(userdata):
    userdata.sequence = [userdata.order] * 2
    return "done" if userdata.order > 0 else "refused"

class Stay(smach.State):
    def __init__(self):
        smach.State.__init__(self, ["stopped", "go"], input_keys=["action_goal"])
    def execute(self, userdata):
        if userdata.action_goal.order < 50:
            return "go"
        staying.set()
        while not self.preempt_requested():
            rospy.sleep(0.01)
        self.service_preempt()
        return "stopped"

staying = threading.Event()
sm = smach.StateMachine(outcomes=["done", "refused", "stopped"])
with sm:
    smach.StateMachine.add("STAY", Stay(), {"go": "COUNT"})
    smach.StateMachine.add("COUNT", smach.CBState(count))
wrapper = smach_ros.ActionServerWrapper("machine", FibonacciAction, wrapped_container=sm, succeeded_outcomes=["done"],
    aborted_outcomes=["refused"], preempted_outcomes=["stopped"], expand_goal_slots=True, pack_result_slots=True)
wrapper.run_server()
client = actionlib.SimpleActionClient("machine", FibonacciAction)
print("server", client.wait_for_server(rospy.Duration(20)))
for order in (4, -4, 50):
    client.send_goal(FibonacciGoal(order=order))
    if order == 50:
        staying.wait(20)
        while client.get_state() != GoalStatus.ACTIVE:  # before, an older list of statuses may come, without the goal
            rospy.sleep(0.01)
        client.cancel_goal()
    print("wrapped", client.wait_for_result(rospy.Duration(20)), client.get_state(), client.get_result().sequence)
try:
    smach_ros.ActionServerWrapper("other", FibonacciAction, sm, ["done"], ["done"])
except smach.InvalidStateError as error:
    print(error)
rospy.signal_shutdown("done")
"""


@pytest.mark.slow
def test_actions(environ: dict[str, str]) -> None:
    out = [line for line in run(ACTIONS, environ, timeout=60).splitlines() if not line.startswith(("[", "\t"))]
    assert out[0] == "succeeded {}"
    assert out[1].startswith("succeeded {'result': ") and "[0, 1]" in "".join(out[1:3])
    said = [line for line in out if line.startswith(("succeeded", "aborted", "preempted", "long", "server", "wrapped"))]
    assert said[2:] == [
        "succeeded {'order': 3, 'sequence': (0, 1, 2)}",
        said[3],
        "long {'last': 4}",
        "aborted {}",
        "aborted {}",
        "aborted {}",
        "preempted {}",
        "server True",
        "wrapped True 3 (4, 4)",
        "wrapped True 4 (-4, -4)",
        f"wrapped True 2 {said[-1].partition(' 2 ')[2]}",
    ]
    assert "In several: ['done']; in none: ['refused', 'stopped']" in out[-1]


WATCHED = """
import threading
import rospy, smach, smach_ros
from std_msgs.msg import Empty
rospy.init_node("watched")
go = threading.Event()
rospy.Subscriber("go", Empty, lambda message: go.set())

class Wait(smach.State):
    def __init__(self):
        smach.State.__init__(self, ["done", "preempted"], output_keys=["lock"])
    def execute(self, userdata):
        userdata.lock = go  # which cannot be sent
        while not go.wait(0.01):
            if self.preempt_requested():
                self.service_preempt()
                return "preempted"
        go.clear()
        return "done"

top = smach.StateMachine(["succeeded", "preempted"])
top.userdata.number = 5
with top:
    inner = smach.StateMachine(["done", "preempted"])
    with inner:
        smach.StateMachine.add("ONE", Wait(), {"done": "TWO"})
        smach.StateMachine.add("TWO", Wait())
    smach.StateMachine.add("INNER", inner, {"done": "succeeded"})
server = smach_ros.IntrospectionServer("watch", top, "/SM_ROOT")
server.start()
smach_ros.set_preempt_handler(top)
rospy.Subscriber("begin", Empty, lambda message: begin.set())
begin = threading.Event()
rospy.loginfo("ready")
thread = threading.Thread(target=lambda: begin.wait(30) and print("outcome", top.execute(), flush=True))
thread.start()
rospy.spin()
thread.join()
server.stop()
print("stopped", flush=True)
"""


@pytest.mark.slow
def test_introspection_and_ctrl_c(make_node: Callable[..., Node], environ: dict[str, str]) -> None:
    from pyros1.msgs.std_msgs.msg import Empty

    program = start(WATCHED, environ)
    try:
        node = make_node("watcher")
        heard: queue.Queue[Any] = queue.Queue()
        node.subscribe("/watch/smach/container_status", SmachContainerStatus, heard.put)

        def status(**wanted: Any) -> Any:
            while True:
                message = heard.get(timeout=15)
                if all(getattr(message, key) == value for key, value in wanted.items()):
                    return message

        structure = node.wait_for_message("/watch/smach/container_structure", SmachContainerStructure, 15)
        assert structure.path in ("/SM_ROOT", "/SM_ROOT/INNER")
        found = status(path="/SM_ROOT/INNER", info="HEARTBEAT")
        assert (found.initial_states, found.active_states) == (["ONE"], ["None"])
        command = SmachContainerInitialStatusCmd(path="/SM_ROOT/INNER", initial_states=["TWO"])
        node.advertise("/watch/smach/container_init", SmachContainerInitialStatusCmd, latch=True).publish(command)
        status(path="/SM_ROOT/INNER", info="INITIAL STATE", initial_states=["TWO"])
        node.advertise("/begin", Empty, latch=True).publish(Empty())
        found = status(path="/SM_ROOT/INNER", info="START")
        assert found.active_states == ["TWO"]
        echo = [sys.executable, "-m", "pyros1", "topic", "echo", "-n1", "/watch/smach/container_status"]
        said = subprocess.run(echo, env=environment(environ), capture_output=True, text=True, timeout=30, check=True)
        assert "path: " in said.stdout and "SM_ROOT" in said.stdout and "HEARTBEAT" in said.stdout
        program.send_signal(signal.SIGINT)
        out, _ = program.communicate(timeout=20)
        assert "outcome preempted\n" in out and "stopped\n" in out and "Traceback" not in out
    finally:
        program.kill()
        program.communicate(timeout=10)


IN_THE_MAIN_THREAD = """
import rospy, smach, smach_ros
rospy.init_node("machine")

class Wait(smach.State):
    def __init__(self):
        smach.State.__init__(self, ["preempted"])
    def execute(self, userdata):
        print("waiting", flush=True)
        while not self.preempt_requested():
            rospy.rostime.wallsleep(0.01)
        self.service_preempt()
        return "preempted"

sm = smach.StateMachine(["preempted"])
with sm:
    smach.StateMachine.add("WAIT", Wait())
smach_ros.set_preempt_handler(sm)
print("outcome", sm.execute())
"""


def test_ctrl_c_while_the_main_thread_runs_a_machine(environ: dict[str, str]) -> None:
    with start(IN_THE_MAIN_THREAD, environ) as program:
        try:
            assert program.stdout is not None
            while "waiting" not in program.stdout.readline():
                assert program.poll() is None
            program.send_signal(signal.SIGINT)
            out, _ = program.communicate(timeout=20)
            assert "outcome preempted" in out and "Traceback" not in out
        finally:
            program.kill()


# As https://docs.ros.org/en/noetic/api/smach_ros has them.
SIGNATURES = """
import inspect, smach_ros
for name, words in {
    "SimpleActionState": "action_name action_spec goal goal_key goal_slots goal_cb goal_cb_args goal_cb_kwargs"
        " result_key result_slots result_cb result_cb_args result_cb_kwargs input_keys output_keys outcomes"
        " exec_timeout preempt_timeout server_wait_timeout",
    "ServiceState": "service_name service_spec request request_cb request_cb_args request_cb_kwargs request_key"
        " request_slots response_cb response_cb_args response_cb_kwargs response_key response_slots input_keys"
        " output_keys outcomes",
    "MonitorState": "topic msg_type cond_cb max_checks input_keys output_keys",
    "ConditionState": "cond_cb input_keys poll_rate timeout max_checks",
    "ActionServerWrapper": "server_name action_spec wrapped_container succeeded_outcomes aborted_outcomes"
        " preempted_outcomes goal_key feedback_key result_key goal_slots_map feedback_slots_map result_slots_map"
        " expand_goal_slots pack_result_slots",
    "IntrospectionServer": "server_name state path",
    "IntrospectionClient.set_initial_state": "self server path initial_states initial_userdata timeout",
    "set_preempt_handler": "sc",
}.items():
    thing = smach_ros
    for part in name.split("."):
        thing = getattr(thing, part)
    assert " ".join(inspect.signature(thing).parameters) == words, name
try:
    smach_ros.RosState
except AttributeError as error:
    print(error)
"""


def test_signatures(environ: dict[str, str]) -> None:
    assert run(SIGNATURES, environ) == "pyros1 has no smach_ros.RosState: it belongs to ROS 2\n"


CLIENT = """
import rospy, smach, smach_ros
rospy.init_node("client")
top = smach.Concurrence(["done"], "done")
with top:
    inner = smach.StateMachine(["done"])
    with inner:
        smach.StateMachine.add("ONE", smach.CBState(lambda ud: "done", outcomes=["done"]))
        smach.StateMachine.add("TWO", smach.CBState(lambda ud: "done", outcomes=["done"]))
    smach.Concurrence.add("INNER", inner)
server = smach_ros.IntrospectionServer("/robot", top, "/TOP")
server.start()
client = smach_ros.IntrospectionClient()
data = smach.UserData()
data.speed = [1, 2.5]
print(client.get_servers(), client.set_initial_state("/robot", "/TOP/INNER", ["TWO"], data, rospy.Duration(20)))
print(inner.get_initial_states(), inner.userdata.speed)
print(client.set_initial_state("/robot", "/TOP/INNER", ["THREE"], timeout=rospy.Duration(0.3)),
      inner.get_initial_states())
server.stop()
"""


@pytest.mark.slow
def test_the_initial_state_is_chosen_elsewhere(environ: dict[str, str]) -> None:
    out = run(CLIENT, environ)
    assert "['/robot'] True\n['TWO'] [1, 2.5]\n" in out
    assert "False ['TWO']\n" in out and "Cannot begin with states" in out


def test_userdata_of_messages() -> None:
    import base64
    import pickle

    with imported("smach_ros.local_data") as module:
        values = {"a": [1, {"b": (2.5, "c")}], "d": None}
        assert module.decode(module.encode(values)) == values
        assert module.decode(module.encode({"a": 1, "f": lambda: 0})) == {"a": 1}
        assert module.decode("") == {}
        shared = tuple([("x", 1)] * 100)
        values = {"a": {("k", (1, 2)): [shared, shared]}, "b": {1, 2}, "c": [[[shared] * 10]], "d": 2**70}
        values.update(e=b"x\xff", f=b"", g=frozenset("x"))
        assert module.decode(module.encode(values)) == values
        for protocol in range(pickle.HIGHEST_PROTOCOL + 1):
            assert module.decode(base64.b64encode(pickle.dumps(values, protocol)).decode()) == values
        deep = b"\x80\x02})" + 1_000_000 * b"\x85" + b"Ns."
        often = b"\x80\x02})" + 60 * b"2\x86" + b"Ns."
        bads = (b"cos\nsystem\n(S'true'\ntR.", b"\x80\x02r\xff\xff\xff\x7f.", pickle.dumps([1]), b"\x80\x02", b"0.")
        for bad in (*bads, deep, often):
            with pytest.raises(ValueError, match="cannot read userdata"):
                module.decode(base64.b64encode(bad).decode())


JUST_BEFORE = """
import actionlib.simple_action_server, smach, smach_ros
from actionlib_tutorials.msg import FibonacciAction, FibonacciGoal

class Work(smach.State):
    def __init__(self):
        smach.State.__init__(self, ["done", "stopped"])
    def execute(self, userdata):
        return "stopped" if self.preempt_requested() else "done"

class Machine(smach.StateMachine):
    ready = False
    def check_consistency(self):
        super().check_consistency()
        if self.ready:
            wrapper.preempt_cb()  # a cancel comes just before it runs

class Server:
    def __init__(self, *arguments, **options):
        pass
    def start(self):
        pass
    def register_preempt_callback(self, callback):
        pass
    def is_active(self):
        return False
    def is_preempt_requested(self):
        return False
    def set_succeeded(self, result):
        print("succeeded")
    def set_preempted(self, result):
        print("preempted")
    set_aborted = set_succeeded

actionlib.simple_action_server.SimpleActionServer = Server
machine = Machine(["done", "stopped"])
with machine:
    smach.StateMachine.add("WORK", Work())
wrapper = smach_ros.ActionServerWrapper("x", FibonacciAction, machine, ["done"], [], ["stopped"])
wrapper.run_server()
machine.ready = True
wrapper.execute_cb(FibonacciGoal())
"""


def test_a_cancel_that_comes_just_before_the_machine_runs(environ: dict[str, str]) -> None:
    assert "preempted" in run(JUST_BEFORE, environ).splitlines()


STOPPED = """
import rospy, smach, smach_ros
rospy.init_node("stopped")

class Work(smach.State):
    def __init__(self):
        smach.State.__init__(self, ["done"])
    def execute(self, userdata):
        return "done"

machine = smach.StateMachine(["done"])
with machine:
    smach.StateMachine.add("WORK", Work())
server = smach_ros.IntrospectionServer("look", machine, "/top")
server.start()
server.stop()
print(machine.execute())
rospy.signal_shutdown("done")
"""


def test_a_machine_goes_on_without_its_introspection(environ: dict[str, str]) -> None:
    out = run(STOPPED, environ)
    assert "done" in out.splitlines() and "Could not" not in out and "NoneType" not in out


AGAIN = """
import threading
import rospy, smach_ros
from rosgraph_msgs.msg import Clock
rospy.set_param("/use_sim_time", True)
rospy.init_node("again")
clock = rospy.Publisher("/clock", Clock, queue_size=1)
asked = threading.Event()
wait, pause = rospy.Duration(5), rospy.Duration(0.5)
state = smach_ros.ConditionState(lambda ud: asked.set(), max_checks=-1, timeout=wait, poll_rate=pause)
ended = []
thread = threading.Thread(target=lambda: ended.append((state.execute({}), rospy.get_time())))
def tick(seconds):
    while rospy.get_time() != seconds:  # the first messages may come before the connection
        clock.publish(rospy.Time.from_sec(seconds))
        thread.join(0.001) if thread.ident else None
tick(100)
thread.start()
asked.wait(20)
tick(101)
seconds = 10
while thread.is_alive() and seconds < 90:
    tick(seconds)
    thread.join(0.005)
    seconds += 0.25
print(ended[0][0], 15 < ended[0][1] < 60)
"""


def test_a_condition_times_out_though_the_clock_begins_again(environ: dict[str, str]) -> None:
    assert run(AGAIN, environ).splitlines()[-1] == "false True"
