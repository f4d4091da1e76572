"""Stock's actionlib and a ROS 2 program that is not ours, with `pyros1 bridge ros2` between them.

Feature: actions of ROS 2 nodes that use rmw_zenoh -- with stock's actionlib, and with zenoh-ros2-sdk at the other side
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from harness import STOCK_PYTHON, Master, Process, free_port, until

MASTERS = ("stock",)
OWN_MASTER = True
PEER = Path(__file__).parents[1] / "peers" / "ros2_sdk_actions_peer.py"
START = 60.0
SERVER = """
import actionlib, rospy
from actionlib.msg import TestAction, TestFeedback, TestResult
def execute(goal):
    if goal.goal < 0:
        server.set_aborted(TestResult(-1))
        return
    for step in range(1, goal.goal + 1):
        rospy.sleep(0.2)
        if server.is_preempt_requested():
            server.set_preempted(TestResult(step))
            return
        server.publish_feedback(TestFeedback(step))
    server.set_succeeded(TestResult(goal.goal))
rospy.init_node("server")
server = actionlib.SimpleActionServer("/ros1_test", TestAction, execute, auto_start=False)
server.start()
rospy.spin()
"""
CLIENT = """
import sys
import actionlib, rospy
from actionlib.msg import TestAction, TestGoal
rospy.init_node("client")
client = actionlib.SimpleActionClient("/ros2_test", TestAction)
print("found", client.wait_for_server(rospy.Duration(60)), flush=True)
for number, cancels in ((3, False), (50, True), (-1, False)):
    def on_feedback(feedback):
        print("feedback", feedback.feedback, flush=True)
        if cancels:
            client.cancel_goal()
    client.send_goal(TestGoal(number), feedback_cb=on_feedback)
    client.wait_for_result(rospy.Duration(60))
    result = client.get_result()
    print("end", client.get_state(), result.result if result else None, flush=True)
"""


class Sides:
    """A stock master, the bridge, and the ROS 2 program."""

    def __init__(self, master: Master) -> None:
        self.master = master
        port = free_port()
        endpoint = f"tcp/127.0.0.1:{port}"
        bridge = self.start("ours", "bridge", sys.executable, "-m", "pyros1", "bridge", "ros2", "--listen", endpoint)
        bridge.wait_line("^bridge to ROS 2", START)
        self.ros2 = self.start("ours", "ROS 2", sys.executable, str(PEER), str(port))
        self.ros2.wait_line("^ready", START)

    def start(self, python: str, label: str, *command: str) -> Process:
        process = Process(command, self.master.environ(python), label)
        self.master.processes.append(process)
        return process


@pytest.fixture
def sides(launcher: Master) -> Iterator[Sides]:
    yield Sides(launcher)
    for process in launcher.processes:  # shown if the test has failed
        print(process.label, process.transcript(), sep="\n")


def test_ros2_uses_an_action_of_ros1(sides: Sides) -> None:
    sides.start("stock", "server", STOCK_PYTHON, "-c", SERVER)

    def has_ended() -> bool:
        """Let ROS 2 send a goal, which is not accepted before the bridge offers the action."""
        sides.ros2.write("goal 3")
        line = sides.ros2.wait_line("^client (result|not accepted).*", START)[0]
        assert line in ("client result 4 3", "client not accepted 3")
        return line == "client result 4 3"

    until(has_ended, "a goal is achieved", timeout=START)
    assert "client feedback True 1" in [line.strip() for line in sides.ros2.lines]
    sides.ros2.write("cancel 50")
    sides.ros2.wait_line("^client cancels 0 True$", START)
    sides.ros2.wait_line(r"^client result 5 \d$", START)


def test_ros1_uses_an_action_of_ros2(sides: Sides) -> None:
    client = sides.start("stock", "client", STOCK_PYTHON, "-c", CLIENT)
    client.wait_line("^found True$", START)
    client.wait_line("^end 3 3$", START)
    client.wait_line(r"^end 2 \d+$", START)
    client.wait_line("^end 5 0$", START)
    assert "feedback 1" in [line.strip() for line in client.lines]
