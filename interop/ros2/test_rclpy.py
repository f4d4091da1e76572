"""Stock ROS 1 nodes and nodes of ROS 2 itself, with `pyros1 bridge ros2 --via rclpy` between them.

They run only where PYROS1_ROS2_PYTHON names a Python that has rclpy and pyros1, so not in CI. ROS 2 comes as wheels,
for Linux on x86_64::

    python -m venv ros2
    ros2/bin/pip install ros-kilted-rclpy ros-kilted-rmw-fastrtps-cpp ros-kilted-common-interfaces
    ros2/bin/pip install ros-kilted-test-msgs -e .
    PYROS1_ROS2_PYTHON=ros2/bin/python python -m pytest interop/ros2/test_rclpy.py

Feature: topics of ROS 2 nodes, through rclpy -- with stock's rospy and with rclpy; by hand, since CI has no ROS 2
Feature: services of ROS 2 nodes, through rclpy -- with stock's rospy and with rclpy; by hand, since CI has no ROS 2
Feature: actions of ROS 2 nodes, through rclpy -- with rclpy's actions of both kinds; by hand, since CI has no ROS 2
"""

from __future__ import annotations

import os
import random
import signal
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from harness import STOCK_PYTHON, Master, Process, until
from ros2_sides import SERVER, START, Sides, await_new

from pyros1.guide.documents import pages

MASTERS = ("stock",)
OWN_MASTER = True
PEER = Path(__file__).parents[1] / "peers" / "rclpy_peer.py"
ACTIONS_PEER = PEER.with_name("rclpy_actions_peer.py")
PYTHON = os.environ.get("PYROS1_ROS2_PYTHON", "")
# ROS 2's wheels have no action but that of test_msgs; the types of stock's tutorials are not among Debian's packages.
ACTION_PACKAGES = "- ros1_package_name: actionlib_tutorials\n  ros2_package_name: test_msgs\n"
ACTION_SERVER = """#!/usr/bin/env python3
import actionlib, rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciFeedback, FibonacciResult
def execute(goal):
    numbers = [0, 1]
    for _ in range(goal.order):
        rospy.sleep(0.2)
        if server.is_preempt_requested():
            server.set_preempted(FibonacciResult(numbers))
            return
        numbers.append(numbers[-1] + numbers[-2])
        server.publish_feedback(FibonacciFeedback(numbers))
    server.set_succeeded(FibonacciResult(numbers))
rospy.init_node("server")
server = actionlib.SimpleActionServer("/ros1_fib", FibonacciAction, execute, auto_start=False)
server.start()
rospy.spin()
"""
ACTION_CLIENT = """#!/usr/bin/env python3
import actionlib, rospy
from actionlib_tutorials.msg import FibonacciAction, FibonacciGoal
rospy.init_node("client")
client = actionlib.SimpleActionClient("/ros2_fib", FibonacciAction)
print("found", client.wait_for_server(rospy.Duration(60)), flush=True)
for order, cancels in ((3, False), (50, True), (-1, False)):
    client.send_goal(FibonacciGoal(order), feedback_cb=lambda _: client.cancel_goal() if cancels else None)
    client.wait_for_result(rospy.Duration(60))
    print("end", client.get_state(), *client.get_result().sequence, flush=True)
"""


class RclpySides(Sides):
    """The same as with the SDK, in a ROS domain of its own."""

    def __init__(self, master: Master) -> None:
        self.domain = random.randrange(1, 100)
        super().__init__(master)

    def start(self, python: str, label: str, *command: str) -> Process:
        here = {"ROS_DOMAIN_ID": str(self.domain), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
        process = Process(command, self.master.environ(python) | here, label)
        self.master.processes.append(process)
        return process

    def start_bridge(self, *options: str) -> Process:
        return self.start("ours", "bridge", PYTHON, "-m", "pyros1", "bridge", "ros2", "--via", "rclpy", *options)

    def start_ros2(self) -> Process:
        process = self.start("ours", "ROS 2", PYTHON, str(PEER))
        process.wait_line("^ready", START)
        return process


@pytest.fixture
def sides(launcher: Master) -> Iterator[RclpySides]:
    return RclpySides(launcher)


def test_topics_both_ways(sides: RclpySides) -> None:
    sides.talker()
    listener = sides.listener()
    sides.ros2.wait_line("^got hi$", START)
    first = int(listener.wait_line(r"from ROS 2 (\d+)", START)[1])
    assert int(listener.wait_line(r"from ROS 2 (\d+)", START)[1]) == first + 1
    sides.ros2.write("")
    names = sides.ros2.wait_line("^topics (.*)", START)[1]
    assert "/from_ros1" in names and "/from_ros2" in names


def test_a_topic_that_both_sides_publish(sides: RclpySides) -> None:
    sides.start("stock", "rostopic pub", "rostopic", "pub", "-r", "10", "/both", "std_msgs/String", "from ROS 1")
    listener = sides.start("stock", "rostopic echo", "rostopic", "echo", "/both")
    sides.ros2.wait_line("^both from ROS 1$", START)
    listener.wait_line("from ROS 2", START)
    before = len(listener.lines)
    until(lambda: sum("from ROS 2" in line for line in listener.lines[before:]) >= 10, "some messages", timeout=START)
    lines = listener.lines[before:]
    of_ros1, of_ros2 = (sum(word in line for line in lines) for word in ("from ROS 1", "from ROS 2"))
    # Twice as many, or four times if each came back from ROS 2.
    assert of_ros1 < 3 * of_ros2, (of_ros1, of_ros2)


def test_latched_messages(sides: RclpySides) -> None:
    sides.start("stock", "rostopic pub", "rostopic", "pub", "-l", "/map_name", "std_msgs/String", "lab")
    sides.ros2.wait_line("^latched lab$", START)
    for _ in range(2):  # the second one comes late
        listener = sides.start("stock", "rostopic echo", "rostopic", "echo", "/ros2_places")
        listener.wait_line("yard", START)
        assert any("cellar" in line for line in listener.lines) or listener.wait_line("cellar", START)


def test_ros2_calls_a_service_of_ros1(sides: RclpySides) -> None:
    sides.start("stock", "server", STOCK_PYTHON, "-c", SERVER)
    sides.wait_called("true", "^response True switched by ROS 1$")
    sides.ros2.write("call false")
    sides.ros2.wait_line(r"^no response", START)
    assert "it is on for good" in sides.bridge.wait_line("a call from ROS 2 has failed.*").string
    sides.wait_called("true", "^response True switched by ROS 1$")


def test_ros1_calls_a_service_of_ros2(sides: RclpySides) -> None:
    until(lambda: "/ros2_switch" in sides.tool("list"), "rosservice lists it", timeout=START)
    assert sides.tool("type", "/ros2_switch") == "std_srvs/SetBool\n"
    for word, success in (("true", "True"), ("false", "False")):
        said = sides.tool("call", "/ros2_switch", word)
        assert f"success: {success}" in said and "switched by ROS 2" in said
    sides.ros2.close()
    until(lambda: "/ros2_switch" not in sides.tool("list"), "it is gone", timeout=START)


def test_actions_both_ways(sides: RclpySides, tmp_path: Path) -> None:
    mapping, package = tmp_path / "actions.yaml", tmp_path / "fibonacci"
    mapping.write_text(ACTION_PACKAGES)
    package.mkdir()
    (package / "package.xml").write_text("<package><name>fibonacci</name></package>")
    for name, text in (("server", ACTION_SERVER), ("client", ACTION_CLIENT)):
        (package / name).write_text(text)
        (package / name).chmod(0o755)
    sides.bridge.close()
    sides.start_bridge("--mapping", str(mapping)).wait_line("^bridge to ROS 2", START)
    run = ("env", f"ROS_PACKAGE_PATH={tmp_path}", sys.executable, "-m", "pyros1", "run", "fibonacci")
    sides.start("ours", "server", *run, "server")
    ros2 = sides.start("ours", "ROS 2 actions", PYTHON, str(ACTIONS_PEER))
    client = sides.start("ours", "client", *run, "client")
    client.wait_line("^end 3 0 1 1 2 3$", START)
    client.wait_line(r"^end 2 0 1 1\b", START)
    client.wait_line("^end 4 0 1$", START)
    ros2.wait_line("^result 4 0 1 1 2 3$", START)
    ros2.wait_line("^canceling 1$", START)
    ros2.wait_line(r"^result 5 0 1 1\b", START)
    assert "feedback 0 1 1" in [line.strip() for line in ros2.lines]


def test_a_package_that_is_not_there(sides: RclpySides) -> None:
    sides.start("stock", "rostopic pub", "rostopic", "pub", "-r", "10", "/tf", "tf2_msgs/TFMessage", "transforms: []")
    said = sides.bridge.wait_line("/tf: .*", START).string
    assert "package tf2_msgs is not installed in this ROS 2 installation" in said
    sides.talker()
    sides.ros2.wait_line("^got hi$", START)


def test_a_robot_of_which_the_controller_has_moved(sides: RclpySides, tmp_path: Path) -> None:
    """The programs of the how-to page."""
    wheels, drive = (tmp_path / name for name in ("wheels.py", "drive.py"))
    wheels.write_text(pages()["ros2"].code("python")[0])
    drive.write_text(pages()["ros2"].code("python")[1])
    sides.start("stock", "wheels", STOCK_PYTHON, str(wheels))
    controller = sides.start("ours", "drive", PYTHON, str(drive))
    controller.wait_line(r"\b0\.50 m left", START)
    controller.wait_line(r"\b0\.0\d m left", START)
    echo = sides.start("stock", "rostopic echo", "rostopic", "echo", "/odom/pose/pose/position/x")
    assert 0.9 < float(echo.wait_line(r"^(\d\S*)$", START)[1]) <= 1.0


def test_each_side_starts_again(sides: RclpySides) -> None:
    talker, listener = sides.talker(), sides.listener()
    await_new(sides.ros2, "^got hi$")
    await_new(listener, "from ROS 2")
    sides.ros2.close()
    sides.ros2 = sides.start_ros2()
    await_new(sides.ros2, "^got hi$")
    await_new(listener, "from ROS 2")
    begin = time.monotonic()
    sides.bridge.signal(signal.SIGINT)
    assert sides.bridge.wait(START) in (0, 130) and time.monotonic() - begin < 3
    assert not any("Traceback" in line for line in sides.bridge.lines), sides.bridge.transcript()
    sides.bridge = sides.start_bridge()
    sides.bridge.wait_line("^bridge to ROS 2", START)
    await_new(sides.ros2, "^got hi$")
    await_new(listener, "from ROS 2")
    talker.close()
    listener.close()
    sides.talker()
    await_new(sides.ros2, "^got hi$")
    await_new(sides.listener(), "from ROS 2")


def test_the_master_starts_again(own_master: Callable[[str], Master]) -> None:
    master = own_master("stock")
    master.start()
    sides = RclpySides(master)
    talker, listener = sides.talker(), sides.listener()
    await_new(sides.ros2, "^got hi$")
    await_new(listener, "from ROS 2")
    master.stop()
    talker.close()
    listener.close()
    master.start()
    sides.talker()
    await_new(sides.ros2, "^got hi$")
    await_new(sides.listener(), "from ROS 2")
