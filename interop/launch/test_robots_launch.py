"""A launch file for three robots, through stock's roslaunch with stock's rospy and through ours: the same names."""

from __future__ import annotations

import signal
import sys
from pathlib import Path

from harness import STOCK_PYTHON, Master, until

MASTERS = ("ours",)
OWN_MASTER = True
PACKAGE = """<package format="2"><name>robots</name><version>1.0.0</version><description>d</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
ROBOT = """<launch>
  <arg name="robot"/><arg name="base" default="move_base"/>
  <arg name="prefix" default="$(arg robot)_tf"/><arg name="ns" default="$(arg robot)"/>
  <group ns="$(arg ns)">
    <remap from="tf" to="/tf"/><remap from="/tf_static" to="/$(arg robot)/tf_static"/>
    <param name="tf_prefix" value="$(arg prefix)"/>
    <node pkg="robots" type="server" name="$(arg base)">
      <remap from="move_base" to="/$(arg robot)/nav/move_base"/><remap from="map" to="/map"/>
      <param name="base_frame" value="$(arg prefix)/base_link"/>
    </node>
    <node pkg="robots" type="client" name="client"><remap from="move_base" to="/$(arg robot)/nav/move_base"/></node>
    <node pkg="topic_tools" type="throttle" name="slower" args="messages scan 1.0 slow">
      <remap from="scan" to="laser/scan"/>
    </node>
    <group if="$(eval robot == 'r1')">
      <node pkg="topic_tools" type="relay" name="relay_$(arg robot)" args="/map map_$(arg robot)"/>
    </group>
  </group>
</launch>"""
ROBOTS = """<launch>
  <include file="$(dirname)/robot.launch"><arg name="robot" value="r1"/></include>
  <include file="$(dirname)/robot.launch" ns="fleet">
    <arg name="robot" value="r2"/><arg name="ns" value="inner"/>
  </include>
  <remap from="move_base" to="everywhere"/>
  <include file="$(dirname)/robot.launch" pass_all_args="true"><arg name="robot" value="r3"/></include>
  <group ns="x"><node pkg="robots" type="server" name="plain"/></group>
</launch>"""
SERVER = """import actionlib, rospy, tf
from actionlib.msg import TestAction
from std_msgs.msg import String
from std_srvs.srv import Empty
rospy.init_node("move_base")
server = actionlib.SimpleActionServer("move_base", TestAction, lambda goal: server.set_succeeded(), auto_start=False)
server.start()
listener = tf.TransformListener()
kept = [
    rospy.Subscriber("map", String),
    rospy.Subscriber("move_base_simple/goal", String),
    rospy.Publisher("~plan", String, queue_size=1),
    rospy.Publisher("move_base/current_goal", String, queue_size=1),
    rospy.Service("~make_plan", Empty, lambda request: []),
    rospy.Service("move_base/clear", Empty, lambda request: []),
]
rospy.set_param("~seen", [rospy.get_param("~base_frame", ""), str(rospy.search_param("tf_prefix"))])
rospy.spin()
"""
CLIENT = """import actionlib, rospy
from actionlib.msg import TestAction, TestGoal
rospy.init_node("client")
client = actionlib.SimpleActionClient("move_base", TestAction)
client.wait_for_server()
client.send_goal(TestGoal(1))
while not client.wait_for_result(rospy.Duration(5)) and not rospy.is_shutdown():
    client.send_goal(TestGoal(1))  # stock's client may lose the first one
rospy.set_param("~seen", client.get_state())
rospy.spin()
"""
REGISTRATIONS = 104
"""How many topics and services stock's nodes have."""


def test_robots_have_the_same_names(launcher: Master, tmp_path: Path) -> None:
    found = []
    for whose, python, tool in (
        ("stock", STOCK_PYTHON, [STOCK_PYTHON, "/usr/bin/roslaunch"]),
        ("ours", sys.executable, [sys.executable, "-m", "pyros1", "launch"]),
    ):
        file = make_package(tmp_path / whose / "robots", python)
        packages = f"{tmp_path / whose}:/usr/share"
        process = launcher.run([*tool, str(file)], python=whose, label=whose, ROS_PACKAGE_PATH=packages)
        until(lambda: len(registrations(launcher)) >= REGISTRATIONS, f"{whose}: all nodes are up", timeout=60)
        until(lambda: len(seen(launcher)) == 7, f"{whose}: all goals are reached", timeout=60)
        found.append((seen(launcher), registrations(launcher)))
        process.signal(signal.SIGINT)
        process.wait()
        until(lambda: not registrations(launcher), f"{whose}: all nodes have gone")
        for name in ("r1", "r3", "fleet", "x"):
            launcher.call("deleteParam", f"/{name}")
    assert found[1] == found[0]
    assert found[0][0]["/fleet/inner/client"] == 3, "the goal has succeeded"


def make_package(folder: Path, python: str) -> Path:
    """Write the package, whose nodes run in a Python; return its launch file."""
    files = {"package.xml": PACKAGE, "robot.launch": ROBOT, "robots.launch": ROBOTS}
    nodes = {name: f"#!{python}\n{text}" for name, text in {"server": SERVER, "client": CLIENT}.items()}
    folder.mkdir(parents=True)
    for name, text in {**files, **nodes}.items():
        (folder / name).write_text(text)
        (folder / name).chmod(0o755)
    return folder / "robots.launch"


def seen(master: Master) -> dict[str, object]:
    """Return what the nodes have said about themselves: node -> value."""
    names = [name for name in master.call("getParamNames")[2] if name.endswith("/seen")]
    return {name.removesuffix("/seen"): master.call("getParam", name)[2] for name in names}


def registrations(master: Master) -> set[str]:
    """Return the topics and services of all nodes but rosout."""
    words = zip(("pub", "sub", "srv"), master.call("getSystemState")[2], strict=True)
    found = {f"{word} {topic} {node}" for word, part in words for topic, nodes in part for node in nodes}
    return {each for each in found if not each.endswith(" /rosout")}
