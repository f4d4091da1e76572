"""Stock nodes of ROS 1 and a program of ROS 2 that is not ours, with `pyros1 bridge ros2` between them.

Feature: topics of ROS 2 nodes that use rmw_zenoh -- with stock's rospy, and with zenoh-ros2-sdk at the other side
Feature: services of ROS 2 nodes that use rmw_zenoh -- with stock's rospy, and with zenoh-ros2-sdk at the other side
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import STOCK_PYTHON, Master, Process, free_port, until

MASTERS = ("stock",)
OWN_MASTER = True
PEER = Path(__file__).parents[1] / "peers" / "ros2_sdk_peer.py"
START = 60.0
SERVER = """
import rospy
from std_srvs.srv import SetBool
def switch(request):
    if not request.data:
        raise rospy.ServiceException("it is on for good")
    return True, "switched by ROS 1"
rospy.init_node("switch")
service = rospy.Service("/ros1_switch", SetBool, switch)
rospy.spin()
"""


class Sides:
    """A stock master, the bridge, and the program of ROS 2."""

    def __init__(self, master: Master) -> None:
        self.master = master
        self.port = free_port()
        self.bridge = self.start_bridge()
        self.bridge.wait_line("^bridge to ROS 2", START)
        self.ros2 = self.start_ros2()

    def start(self, python: str, label: str, *command: str) -> Process:
        process = Process(command, self.master.environ(python), label)
        self.master.processes.append(process)
        return process

    def start_bridge(self) -> Process:
        endpoint = f"tcp/127.0.0.1:{self.port}"
        return self.start("ours", "bridge", sys.executable, "-m", "pyros1", "bridge", "ros2", "--listen", endpoint)

    def start_ros2(self) -> Process:
        process = self.start("ours", "ROS 2", sys.executable, str(PEER), str(self.port))
        process.wait_line("^ready", START)
        return process

    def talker(self) -> Process:
        return self.start("stock", "rostopic pub", "rostopic", "pub", "-r", "10", "/from_ros1", "std_msgs/String", "hi")

    def listener(self) -> Process:
        return self.start("stock", "rostopic echo", "rostopic", "echo", "/from_ros2")

    def tool(self, *words: str) -> str:
        """Return what stock's rosservice prints."""
        command = ["rosservice", *words]
        environ = self.master.environ("stock")
        return subprocess.run(command, env=environ, capture_output=True, text=True, timeout=START, check=True).stdout

    def wait_called(self, word: str, pattern: str) -> None:
        """Let ROS 2 call the service of ROS 1 until it gets a certain response: it may not be there yet."""

        def is_called() -> bool:
            before = len(self.ros2.lines)
            self.ros2.write(f"call {word}")
            self.ros2.wait_line("^(response|no response)", START)
            return any(re.search(pattern, line) for line in self.ros2.lines[before:])

        until(is_called, f"the call responds {pattern}", timeout=START)


@pytest.fixture
def sides(launcher: Master) -> Iterator[Sides]:
    return Sides(launcher)


def test_topics_both_ways(sides: Sides) -> None:
    talker, listener = sides.talker(), sides.listener()
    sides.ros2.wait_line("^got hi$", START)
    first = int(listener.wait_line(r"from ROS 2 (\d+)", START)[1])
    assert int(listener.wait_line(r"from ROS 2 (\d+)", START)[1]) == first + 1
    sides.ros2.write("")
    names = sides.ros2.wait_line("^topics (.*)", START)[1]
    assert "/from_ros1" in names and "/from_ros2" in names
    assert talker.child.poll() is None


def test_latched_messages(sides: Sides) -> None:
    sides.start("stock", "rostopic pub", "rostopic", "pub", "-l", "/map_name", "std_msgs/String", "lab")
    sides.ros2.wait_line("^latched lab$", START)


def test_ros2_calls_a_service_of_ros1(sides: Sides) -> None:
    sides.start("stock", "server", STOCK_PYTHON, "-c", SERVER)
    sides.wait_called("true", "^response True switched by ROS 1$")
    sides.ros2.write("call false")
    seconds = sides.ros2.wait_line(r"^no response after (.*) s$", START)[1]
    assert float(seconds) < 5, "its error ends the call"
    assert "it is on for good" in sides.bridge.wait_line("a call from ROS 2 has failed.*").string
    assert any("it is on for good" in line for line in sides.ros2.lines), "the client logs it"


def test_ros1_calls_a_service_of_ros2(sides: Sides) -> None:
    until(lambda: "/ros2_switch" in sides.tool("list"), "rosservice lists it", timeout=START)
    assert sides.tool("type", "/ros2_switch") == "std_srvs/SetBool\n"
    for word, success in (("true", "True"), ("false", "False")):
        said = sides.tool("call", "/ros2_switch", word)
        assert re.search(rf"success: {success}\s+message: \W?switched by ROS 2", said)
    sides.ros2.close()
    until(lambda: "/ros2_switch" not in sides.tool("list"), "it is gone", timeout=START)


def await_new(process: Process, pattern: str) -> None:
    """Wait for a line that is printed from now on."""
    before = len(process.lines)
    until(
        lambda: any(re.search(pattern, line) for line in process.lines[before:]),
        f"{process.label} prints {pattern}",
        timeout=START,
    )


def test_each_side_starts_again(sides: Sides) -> None:
    talker, listener = sides.talker(), sides.listener()
    await_new(sides.ros2, "^got hi$")
    await_new(listener, "from ROS 2")
    sides.ros2.close()
    sides.ros2 = sides.start_ros2()
    await_new(sides.ros2, "^got hi$")
    await_new(listener, "from ROS 2")
    sides.bridge.close()
    sides.bridge = sides.start_bridge()
    sides.bridge.wait_line("^bridge to ROS 2", START)
    await_new(sides.ros2, "^got hi$")
    await_new(listener, "from ROS 2")
    talker.close()
    listener.close()
    sides.talker()
    await_new(sides.ros2, "^got hi$")
    await_new(sides.listener(), "from ROS 2")
