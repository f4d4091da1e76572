"""Stock ROS 1 nodes and a ROS 2 program that is not ours, with `pyros1 bridge ros2` between them.

Feature: topics of ROS 2 nodes that use rmw_zenoh -- with stock's rospy, and with zenoh-ros2-sdk at the other side
Feature: services of ROS 2 nodes that use rmw_zenoh -- with stock's rospy, and with zenoh-ros2-sdk at the other side
"""

from __future__ import annotations

import re
import socket
import sys
from collections.abc import Iterator

import pytest
from harness import STOCK_PYTHON, Master, Process, free_port, until
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


class Apart(Sides):
    """The parts apart from each other, with a router of their own, as ROS 2 has one. None is started yet."""

    def __init__(self, master: Master) -> None:
        self.master = master
        self.port = free_port()
        self.endpoint = f"tcp/127.0.0.1:{self.port}"

    def start_part(self, name: str) -> list[Process]:
        command = [sys.executable, "-m", "pyros1", "bridge"]
        if name == "router":
            router = self.start("ours", name, *command, "router", "--insecure", "--listen", self.endpoint)
            until(self.accepts_connections, "the router listens", timeout=START)
            return [router]
        if name == "bridge":
            return [self.start("ours", name, *command, "ros2", "--to", self.endpoint)]
        if name == "ros2":
            self.ros2 = self.start_peer()
            return [self.ros2]
        self.echo = self.listener()
        return [self.talker(), self.echo]

    def accepts_connections(self) -> bool:
        with socket.socket() as probe:
            return probe.connect_ex(("127.0.0.1", self.port)) == 0

    def await_messages(self) -> None:
        await_new(self.ros2, "^got hi$")
        await_new(self.echo, "from ROS 2")


# Each part comes once before and once after each other one; but zenoh-ros2-sdk cannot start before the router.
ORDERS = (
    ("router", "ros2", "ros1", "bridge"),
    ("bridge", "router", "ros2", "ros1"),
    ("ros1", "bridge", "router", "ros2"),
)


@pytest.mark.parametrize("order", ORDERS, ids="-".join)
def test_all_start_in_any_order(launcher: Master, order: tuple[str, ...]) -> None:
    apart = Apart(launcher)
    for name in order:
        apart.start_part(name)
    apart.await_messages()


def test_the_router_starts_again(launcher: Master) -> None:
    apart = Apart(launcher)
    (router,) = apart.start_part("router")
    for name in ("bridge", "ros1", "ros2"):
        apart.start_part(name)
    apart.await_messages()
    router.close()
    apart.start_part("router")
    apart.await_messages()
