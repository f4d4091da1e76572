"""Stock nodes of ROS 1 and a program of ROS 2 that is not ours, with `pyros1 bridge ros2` between them.

Feature: topics of ROS 2 nodes that use rmw_zenoh -- with stock's rospy, and with zenoh-ros2-sdk at the other side
Feature: services of ROS 2 nodes that use rmw_zenoh -- with stock's rospy, and with zenoh-ros2-sdk at the other side
"""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from harness import STOCK_PYTHON, Master, until
from ros2_sides import SERVER, START, Sides, await_new

MASTERS = ("stock",)
OWN_MASTER = True


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
