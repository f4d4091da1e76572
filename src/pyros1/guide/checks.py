"""Checks the guide's exercises: inspects the reader's folder and the running system, and reports what is missing."""

from __future__ import annotations

import math
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from pyros1 import actions
from pyros1.bag.api import bag_topics
from pyros1.finding.library import Library
from pyros1.graph import Graph, SystemState
from pyros1.ground import terminal_text
from pyros1.ground.errors import Error, MasterUnreachableError, WaitTimeoutError
from pyros1.msgs import load_message, load_service
from pyros1.net.connectivity import is_loopback
from pyros1.net.hosts import interface_addresses
from pyros1.net.master_client import MasterClient
from pyros1.node import Node
from pyros1.observe.statistics import RateMeter
from pyros1.tf import Buffer, TransformException, TransformListener
from pyros1.urdf.description import robot_description
from pyros1.urdf.reading import read_robot

FLOAT_TYPE = "std_msgs/Float64"
DRIVE_ACTION_TYPE = "my_robot/Drive"
MESSAGE_TIMEOUT = 5.0
"""Seconds for which a check waits for messages or responses."""
POSITION_TOLERANCE = 0.005
"""Tolerance in metres when positions are compared."""
SECOND_MASTER_PORT = 11312
"""The port of the second master, which the reader starts in an exercise."""
MAX_TEST_SECONDS = 60.0
"""Maximum number of seconds that the reader's test may take."""
MAX_ERROR_LINES = 5
"""Maximum number of pytest's error lines that are reported."""


class CheckContext:
    """The context of a check: the reader's folder, and a node that inspects the running system.

    The node is only created when it is used, so that checks of files need no master.

    Args:
        environ: the environment variables.
        folder: the folder in which the reader works.
    """

    def __init__(self, environ: Mapping[str, str], folder: Path) -> None:
        self.environ = environ
        self.folder = folder
        self._node: Node | None = None

    def __enter__(self) -> CheckContext:
        return self

    def __exit__(
        self,
        exception_type: type[BaseException] | None,
        exception: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        if self._node is not None:
            self._node.shutdown()

    @property
    def node(self) -> Node:
        """The node through which the check inspects the running system.

        Raises:
            MasterUnreachableError: the master does not respond.
        """
        if self._node is None:
            self._node = Node("guide", anonymous=True, argv=[], environ=self.environ, rosout=False, wait_for_master=0.0)
        return self._node

    def state(self) -> SystemState:
        """Return the publishers, subscribers and services that the master knows."""
        return Graph(self.node.master).state()

    def wait_for_message(
        self, topic: str, matches: Callable[[Any], bool] = lambda _: True, type_name: str = FLOAT_TYPE
    ) -> Any:
        """Return the first matching message on a topic; None if none arrives in time."""
        deadline = time.monotonic() + MESSAGE_TIMEOUT
        while (remaining := deadline - time.monotonic()) > 0:
            try:
                message: Any = self.node.wait_for_message(topic, type_name, remaining)
            except Error:
                return None
            if matches(message):
                return message
        return None

    def measure_rate(self, topic: str, seconds: float = 2.0) -> float:
        """Measure the rate of a std_msgs/Float64 topic, and return it in Hz; 0 if fewer than two messages arrive.

        Args:
            topic: the topic.
            seconds: the duration of the measurement.
        """
        meter = RateMeter()
        subscriber: Any = self.node.subscribe(topic, FLOAT_TYPE, lambda _: meter.add(time.monotonic()))
        self.node.sleep(seconds)
        subscriber.unregister()
        measurement = meter.measurement()
        return measurement[0] if measurement else 0.0

    def call_service(self, service: str, type_name: str) -> Any:
        """Call a service with an empty request, and return the response.

        Raises:
            WaitTimeoutError: the service does not respond in time.
        """
        service_class: Any = load_service(type_name)
        return self.node.service(service, service_class).call(service_class._request_class(), MESSAGE_TIMEOUT)


Check = Callable[[CheckContext], str]
"""Checks one exercise: returns what is missing and what to do; an empty string if the exercise is done."""


def check_package(context: CheckContext) -> str:
    library = Library(context.environ)
    if not library.has_package("my_messages"):
        return "there is no package my_messages here: pyros1 pkg create my_messages std_msgs"
    if "Pair" not in library.messages("my_messages"):
        return "the package has no message type Pair: create the file my_messages/msg/Pair.msg"
    fields = [(field.type, field.name) for field in library.message("my_messages/Pair").fields]
    if sorted(fields) != [("float64", "a"), ("float64", "b")]:
        return f"Pair should have the fields float64 a and float64 b, but it has {_format_fields(fields)}"
    return ""


def check_publisher(context: CheckContext) -> str:
    missing = _missing_publisher(context, "/topic2")
    if missing:
        return missing
    rate = context.measure_rate("/topic2")
    return "" if 8.0 < rate < 12.0 else f"/topic2 should be published at 10 Hz, but its rate is {rate:.1f} Hz"


def check_manual_publication(context: CheckContext) -> str:
    missing = _missing_publisher(context, "/topic1")
    if missing:
        return missing
    if "/minimal_subscriber" not in context.state().subscribers.get("/topic1", []):
        return "the minimal_subscriber is not running: pyros1 run minimal_nodes minimal_subscriber"
    received = context.wait_for_message("/topic1", lambda message: message.data == 3.5)
    return "" if received else "no node publishes 3.5 on /topic1: pyros1 topic pub -r 1 topic1 std_msgs/Float64 3.5"


def check_launch_file(context: CheckContext) -> str:
    nodes = context.state().publishers.get("/left/topic1", [])
    if "/left/second" in nodes:
        return ""
    if nodes:
        return f"/left/topic1 is published by {', '.join(nodes)}, but the node in the group should be named second"
    return 'no node publishes /left/topic1: put <group ns="left"> around <node name="second" ...>, and launch the file'


def check_logger_level(context: CheckContext) -> str:
    if "/minimal_subscriber" not in context.state().nodes():
        return "the minimal_subscriber is not running: pyros1 run minimal_nodes minimal_subscriber"
    response = context.call_service("/minimal_subscriber/get_loggers", "roscpp/GetLoggers")
    level = {logger.name: logger.level.lower() for logger in response.loggers}.get("rosout", "unknown")
    return "" if level == "error" else f"the logger's level is {level}: pyros1 log set /minimal_subscriber rosout error"


def check_recording(context: CheckContext) -> str:
    path = context.folder / "both.bag"
    if not path.exists():
        hint = (
            " It is still being recorded: press Ctrl-C to stop recording."
            if path.with_suffix(".bag.active").exists()
            else ""
        )
        return f"there is no both.bag in this folder.{hint}"
    topics = bag_topics(path)
    for topic in ("/topic1", "/rosout"):
        if not topics.get(topic, ("", 0, 0))[1]:
            return f"{topic} is not in both.bag: pyros1 bag record -O both topic1 /rosout, while a publisher is running"
    return ""


def check_robot_stopped(context: CheckContext) -> str:
    missing = _missing_publisher(context, "/velocity")
    if missing:
        return f"{missing}: pyros1 launch minimal_simulator.launch"
    command = context.wait_for_message("/vel_cmd")
    if command is None:
        return "no node publishes /vel_cmd: pyros1 topic pub -r 10 vel_cmd std_msgs/Float64 0.0"
    if command.data != 0.0:
        return f"the commanded velocity is {command.data:g} m/s: stop the publisher of /vel_cmd, and publish 0.0"
    if context.wait_for_message("/velocity", lambda message: abs(message.data) < 0.05):
        return ""
    return "the mass is still moving: is the old command still being published? pyros1 topic info vel_cmd"


def check_parameter(context: CheckContext) -> str:
    rate = context.node.params.get("/minimal_publisher/rate", None)
    if rate != 5:
        value_text = "not set" if rate is None else rate
        return f"/minimal_publisher/rate is {value_text}: pyros1 run minimal_nodes minimal_publisher _rate:=5"
    missing = _missing_publisher(context, "/topic1")
    if missing:
        return missing
    measured_rate = context.measure_rate("/topic1")
    if 4.0 < measured_rate < 6.0:
        return ""
    other_publishers = [node for node in context.state().publishers["/topic1"] if node != "/minimal_publisher"]
    hint = (
        f"other nodes publish on /topic1, too; stop {', '.join(other_publishers)}"
        if other_publishers
        else "start the publisher again"
    )
    return f"the rate of /topic1 is {measured_rate:.1f} Hz: {hint}"


def check_service(context: CheckContext) -> str:
    services = context.state().services
    for name in ("/stopwatch/read", "/stopwatch/reset"):
        if name not in services:
            return f"there is no service {name}: does my_robot/scripts/stopwatch advertise it, and is it running?"
    context.call_service("/stopwatch/reset", "std_srvs/Empty")
    response = context.call_service("/stopwatch/read", "std_srvs/Trigger")
    return (
        ""
        if response.message.startswith("0")
        else f"after a reset, /stopwatch/read should return 0, but it returns {response.message!r}"
    )


def check_camera(context: CheckContext) -> str:
    buffer = Buffer()
    with TransformListener(context.node, buffer):
        try:
            position = buffer.lookup_transform("lamp", "camera", timeout=MESSAGE_TIMEOUT).transform.translation
        except TransformException:
            missing = [name for name in ("lamp", "camera") if not buffer.has_frame(name)]
            if missing:
                frame_names = ", ".join(buffer.frames()) or "none"
                return f"no node publishes the frame {missing[0]}; the frames are: {frame_names}"
            return "lamp and camera are not connected: pyros1 tf tree"
    parent = {state.name: state.parent for state in buffer.states()}["camera"]
    if parent != "lamp":
        return f"the parent of camera should be lamp, but it is {parent}"
    if math.dist((position.x, position.y, position.z), (0.0, 0.0, 0.1)) < POSITION_TOLERANCE:
        return ""
    return f"camera should be at 0 0 0.1 in lamp, but it is at {position.x:g} {position.y:g} {position.z:g}"


def check_robot_arm(context: CheckContext) -> str:
    robot = read_robot(robot_description(context.node))
    for link in ("arm", "hand"):
        if link not in robot.links:
            return f"the robot has no link {link}, only {', '.join(robot.links)}: launch the new description"
    wrist = robot.joints.get("wrist")
    if wrist is None:
        return f"the robot has no joint wrist, only {', '.join(robot.joints) or 'none'}"
    comparisons = {
        "type": (wrist.type, "continuous"), "parent": (wrist.parent, "arm"), "child": (wrist.child, "hand"),
        "axis": (_format_numbers(wrist.axis), "0 1 0"), "origin": (_format_numbers(wrist.origin[:3]), "0.5 0 0"),
    }  # fmt: skip
    for attribute, (actual, correct) in comparisons.items():
        if actual != correct:
            return f"the {attribute} of wrist should be {correct}, but it is {actual}"
    buffer = Buffer()
    with TransformListener(context.node, buffer):
        if buffer.can_transform("base", "hand", timeout=MESSAGE_TIMEOUT):
            return ""
    return "no node publishes the position of the hand: are robot_state_publisher and joint_state_publisher running?"


def check_aborted_goal(context: CheckContext) -> str:
    type_name = Graph(context.node.master).topic_types().get("/drive/goal", "")
    if "/drive/goal" not in context.state().subscribers:
        return "there is no server for the action drive: pyros1 run my_robot driver"
    if type_name != f"{DRIVE_ACTION_TYPE}ActionGoal":
        return f"goals of drive should have the type {DRIVE_ACTION_TYPE}ActionGoal, but their type is {type_name}"
    goal_class: Any = load_message(f"{DRIVE_ACTION_TYPE}Goal")
    with actions.Client(context.node, "/drive", DRIVE_ACTION_TYPE) as client:
        aborted_goal = client.send(goal_class(-1), timeout=MESSAGE_TIMEOUT)
        if not aborted_goal.wait(MESSAGE_TIMEOUT) or aborted_goal.status is not actions.Status.ABORTED:
            return f"a goal of -1 m should be aborted, but {_describe_outcome(aborted_goal.status)}"
        if not aborted_goal.text:
            return "the driver does not say why it aborts the goal: goal.abort(text=...)"
        accepted_goal = client.send(goal_class(1), timeout=MESSAGE_TIMEOUT)
        if not accepted_goal.wait(MESSAGE_TIMEOUT) or accepted_goal.status is not actions.Status.SUCCEEDED:
            return f"a goal of 1 m should succeed, but {_describe_outcome(accepted_goal.status)}"
    return ""


def check_second_master(context: CheckContext) -> str:
    core_command = f"pyros1 core -p {SECOND_MASTER_PORT} --bind 127.0.0.1"
    client = MasterClient("/guide", f"http://127.0.0.1:{SECOND_MASTER_PORT}")
    try:
        publishers = Graph(client).state().publishers.get("/topic1", [])
    except MasterUnreachableError:
        return f"there is no master on port {SECOND_MASTER_PORT}: {core_command}"
    finally:
        client.close()
    for address in interface_addresses():
        if not is_loopback(address) and accepts_connections(address, SECOND_MASTER_PORT):
            return f"other machines can reach the second master at {address}: start it with {core_command}"
    if "/minimal_publisher" in publishers:
        return ""
    run_command = "pyros1 run minimal_nodes minimal_publisher"
    return (
        "no minimal_publisher uses the second master: "
        f"ROS_MASTER_URI=http://127.0.0.1:{SECOND_MASTER_PORT} {run_command}"
    )


def check_test(context: CheckContext) -> str:
    path = context.folder / "my_robot" / "tests" / "test_stopwatch.py"
    if not path.exists():
        return "there is no my_robot/tests/test_stopwatch.py in this folder"
    text = path.read_text(encoding="utf-8", errors="replace")
    for required_text in ("def test_", "ros_run", "/stopwatch/reset", "/stopwatch/read", "assert"):
        if required_text not in text:
            return f"the test does not contain {required_text}"
    command = [sys.executable, "-m", "pytest", "-q", "--tb=short", str(path)]
    with subprocess.Popen(
        command, cwd=context.folder, env=dict(context.environ), stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        text=True, errors="replace", start_new_session=True,
    ) as child:  # fmt: skip
        try:
            stdout, stderr = child.communicate(timeout=MAX_TEST_SECONDS)
        except subprocess.TimeoutExpired:
            _kill_process_group(child)
            return f"the test did not finish within {MAX_TEST_SECONDS:g} s"
        except BaseException:
            _kill_process_group(child)
            raise
    if "No module named pytest" in stderr:
        return "pytest is not installed: pip install pytest"
    if child.returncode == 0:
        return ""
    lines = [terminal_text.one_line(line) for line in stdout.strip().splitlines()] or ["no output"]
    error_lines = [line for line in lines if line.startswith("E ")][-MAX_ERROR_LINES:]
    return "\n".join([f"python3 -m pytest my_robot/tests/test_stopwatch.py: {lines[-1]}", *error_lines])


def check_driven_robot(context: CheckContext) -> str:
    sources = context.node.params.get("/twist_mux/topics", None)
    if not isinstance(sources, list):
        return "there is no twist_mux with topics: pyros1 launch my_robot drive.launch"
    priorities = {each.get("topic"): each.get("priority") for each in sources if isinstance(each, dict)}
    if "nav_vel" not in priorities:
        return "the twist_mux has no topic nav_vel: add it to my_robot/config/mux.yaml, and launch drive.launch again"
    planner, keyboard = priorities["nav_vel"], priorities.get("key_vel")
    if not isinstance(planner, int) or not isinstance(keyboard, int) or planner >= keyboard:
        return f"the priority of nav_vel, {planner}, should be lower than that of key_vel, {keyboard}"
    if not context.state().publishers.get("/nav_vel"):
        command = "'{linear: {x: 0.2}, angular: {z: 0.5}}'"
        return f"no node publishes /nav_vel: pyros1 topic pub -r 10 nav_vel geometry_msgs/Twist {command}"
    if context.wait_for_message("/odom", lambda odom: abs(odom.twist.twist.linear.x) > 0.1, "nav_msgs/Odometry"):
        return ""
    return "the robot does not move: is the emergency stop released, and is the robot free of walls?"


def _kill_process_group(child: subprocess.Popen[str]) -> None:
    """Kill a process, and the programs that it has started."""
    if hasattr(os, "killpg"):
        os.killpg(child.pid, signal.SIGKILL)
    else:
        child.kill()


CHECKS: tuple[Check, ...] = (
    check_package, check_publisher, check_manual_publication, check_launch_file, check_logger_level, check_recording,
    check_robot_stopped, check_parameter, check_service,
    check_camera, check_robot_arm, check_aborted_goal, check_second_master, check_test, check_driven_robot,
)  # fmt: skip
"""The checks, in the order of the steps."""


def check(number: int, environ: Mapping[str, str] = os.environ, folder: Path | None = None) -> str:
    """Check the exercise of a step; return what is missing and what to do, or an empty string if the exercise is done.

    Args:
        number: the step's number, starting at 1.
        environ: the environment variables.
        folder: the folder in which the reader works; None for the working directory.
    """
    with CheckContext(environ, folder or Path.cwd()) as context:
        try:
            return CHECKS[number - 1](context)
        except WaitTimeoutError as error:
            return str(error)


def _missing_publisher(context: CheckContext, topic: str) -> str:
    """Check that a std_msgs/Float64 topic is published; return what is missing, or an empty string if nothing is."""
    if not context.state().publishers.get(topic):
        return f"no node publishes {topic}"
    type_name = Graph(context.node.master).topic_types().get(topic, FLOAT_TYPE)
    return "" if type_name == FLOAT_TYPE else f"{topic} should have the type {FLOAT_TYPE}, but its type is {type_name}"


def _describe_outcome(status: actions.Status) -> str:
    """Return how a goal ended, worded as the end of a sentence."""
    if status is actions.Status.SUCCEEDED:
        return "it succeeded"
    if status in (actions.Status.PENDING, actions.Status.ACTIVE):
        return "it is still active"
    return f"it was {status.name.lower()}"


def _format_fields(fields: list[tuple[str, str]]) -> str:
    return ", ".join(f"{type_name} {name}" for type_name, name in fields) or "none"


def _format_numbers(numbers: Iterable[float]) -> str:
    return " ".join(f"{number:.4g}" for number in numbers)


def accepts_connections(address: str, port: int) -> bool:
    """Return whether a server accepts connections at an address and port."""
    try:
        with socket.create_connection((address, port), 1.0):
            return True
    except OSError:
        return False
