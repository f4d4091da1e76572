"""One launch file with stock nodes and pyros1's, started by stock roslaunch and by ours, under both masters.

Feature: stock roslaunch starts our nodes, ours starts stock nodes
"""

from __future__ import annotations

import os
import re
import signal
import sys
from pathlib import Path

import pytest
from harness import SOURCE, Master, Peer, Process, until

pytestmark = pytest.mark.ours_only

LAUNCHERS = {"roslaunch": ["roslaunch"], "pyros1 launch": [sys.executable, "-m", "pyros1", "launch"]}

FILE = """<launch>
  <arg name="space"/>
  <arg name="stock" default="true"/>
  <group ns="$(arg space)">
    <param name="greeting" value="Grüße"/>
    <rosparam>{gains: [1.5, 2, x], nested: {flag: true}}</rosparam>
    <node pkg="interop_nodes" type="talker" name="talker" args="hello" if="$(arg stock)"/>
    <node pkg="topic_tools" type="relay" name="relay" args="chatter elsewhere" respawn="true">
      <remap from="elsewhere" to="relayed"/>
    </node>
    <node pkg="minimal_nodes" type="minimal_publisher" name="counter" respawn="true">
      <param name="rate" value="50.0"/>
      <remap from="topic1" to="numbers"/>
    </node>
    <node pkg="minimal_nodes" type="minimal_subscriber" name="reader" output="screen">
      <remap from="topic1" to="numbers"/>
    </node>
    <node pkg="topic_tools" type="relay" name="absent" args="a b" unless="$(arg stock)"/>
  </group>
</launch>
"""

# The stock tools that are nodes too say ``env python3``, which here is the Python that has pyros1.
TALKER = """#!/usr/bin/python3
import sys
import rospy
from std_msgs.msg import String

rospy.init_node("talker")
publisher = rospy.Publisher("chatter", String, queue_size=10)
rate = rospy.Rate(20)
count, wanted = 0, rospy.get_param("~count", -1)
while not rospy.is_shutdown() and count != wanted:
    publisher.publish(rospy.myargv(sys.argv)[1])
    rate.sleep()
    count += 1
"""
PACKAGE = """<package format="2">
  <name>interop_nodes</name><version>1.0.0</version><description>A rospy node.</description>
  <maintainer email="nobody@example.org">nobody</maintainer><license>BSD</license>
</package>
"""


@pytest.fixture
def packages(tmp_path: Path) -> str:
    """ROS_PACKAGE_PATH with a package of a rospy node, and ours."""
    script = tmp_path / "interop_nodes" / "scripts" / "talker"
    script.parent.mkdir(parents=True)
    script.write_text(TALKER, encoding="utf-8")
    script.chmod(0o755)
    (tmp_path / "interop_nodes" / "package.xml").write_text(PACKAGE, encoding="utf-8")
    return os.pathsep.join([str(tmp_path), str(SOURCE / "pyros1" / "packages"), "/usr/share"])


@pytest.fixture(params=LAUNCHERS)
def launch(request: pytest.FixtureRequest, launcher: Master, packages: str, topic: str, tmp_path: Path) -> Process:
    """The running launcher; its nodes live in the namespace *topic*."""
    (tmp_path / "mixed.launch").write_text(FILE, encoding="utf-8")
    command = [*LAUNCHERS[request.param], str(tmp_path / "mixed.launch"), f"space:={topic}"]
    return launcher.run(command, python="ours", label=request.param, ROS_PACKAGE_PATH=packages)


def nodes_of(master: Master, space: str) -> set[str]:
    state = master.call("getSystemState")[2]
    return {node for kind in state for _, nodes in kind for node in nodes if node.startswith(space + "/")}


def test_nodes_topics_parameters_and_output(launch: Process, launcher: Master, ours: Peer, topic: str) -> None:
    roscpp = launcher.shared("stock", "roscpp")
    for listener in (ours, roscpp):
        listener.subscribe(topic + "/relayed", "std_msgs/String")
        listener.subscribe(topic + "/numbers", "std_msgs/Float64")
        assert listener.received(topic + "/relayed", timeout=30) == b"\5\0\0\0hello".hex()
        assert listener.received(topic + "/numbers", timeout=30)
    names = {f"{topic}/{name}" for name in ("talker", "relay", "counter", "reader")}
    until(lambda: names <= nodes_of(launcher, topic), "all nodes are registered")
    assert not [node for node in nodes_of(launcher, topic) if "absent" in node]
    launch.wait_line(r"received value is: \d+\.\d+")
    for key, value in {"greeting": "Grüße", "gains": [1.5, 2, "x"], "nested": {"flag": True}}.items():
        assert launcher.call("getParam", f"{topic}/{key}")[2] == value
    assert launcher.call("getParam", f"{topic}/counter/rate")[2] == 50.0
    pings = launcher.tool("rosnode", "ping", "-c", "1", f"{topic}/counter")
    assert "xmlrpc reply from" in pings


def test_sigint_ends_every_node(launch: Process, launcher: Master, ours: Peer, topic: str) -> None:
    # Only when the talker talks: a signal during a call to the master, as in init_node, makes rospy wait for itself.
    ours.subscribe(topic + "/relayed", "std_msgs/String")
    ours.received(topic + "/relayed", timeout=30)
    launch.wait_line(r"received value is", timeout=30)
    os.kill(launch.pid, signal.SIGINT)  # the launcher alone: ending the nodes is its work
    assert launch.wait(30) == 0
    assert not launch.unread("escalat"), launch.transcript()
    assert nodes_of(launcher, topic) <= {f"{topic}/relay"}  # roscpp nodes may lose the race against their launcher
    assert launch.unread("done")


def test_killed_nodes_come_back(launch: Process, launcher: Master, topic: str) -> None:
    """respawn="true" for a roscpp node and for one of ours."""
    for name in (f"{topic}/relay", f"{topic}/counter"):
        until(lambda: name in nodes_of(launcher, topic), f"{name} is up", timeout=30)  # noqa: B023
        first = until(lambda: pid_of(launcher, name), f"{name} answers", timeout=30)  # noqa: B023
        os.kill(first, signal.SIGKILL)
        until(lambda: (pid_of(launcher, name) or first) != first, f"{name} is back", timeout=30)  # noqa: B023
    assert launch.child.poll() is None


def pid_of(master: Master, node: str) -> int:
    """The node's process, 0 while it does not answer."""
    try:
        return int(master.node(node, "getPid")[2])
    except OSError:
        return 0


def test_a_required_node_ends_everything(launcher: Master, packages: str, topic: str, tmp_path: Path) -> None:
    """Both launchers stop all when the required stock node ends, and say which one it was."""
    text = """<launch><group ns="SPACE">
      <node pkg="topic_tools" type="relay" name="relay" args="a b"/>
      <node pkg="interop_nodes" type="talker" name="brief" args="bye" required="true">
        <param name="count" value="3"/>
      </node>
    </group></launch>"""
    (tmp_path / "required.launch").write_text(text.replace("SPACE", topic), encoding="utf-8")
    for name, command in LAUNCHERS.items():
        line = [*command, str(tmp_path / "required.launch")]
        process = launcher.run(line, python="ours", label=name, ROS_PACKAGE_PATH=packages)
        process.wait_line(r"REQUIRED process \[.*brief.*\] has died", timeout=30)
        process.wait(30)
        assert not re.search("Traceback", process.transcript())
