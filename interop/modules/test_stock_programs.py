"""Programs that Debian's packages install, unmodified, on stock's modules and on ours, with the same results.

Feature: programs from Debian's packages run on our modules -- rosbag and its scripts, roslaunch, rostest, topic_tools
"""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
from faces import run, start
from harness import Master, until
from stock_programs import CATKIN, begin, link_modules, said

MASTERS = ("ours",)
OWN_MASTER = True

MAKE_BAG = """
import sys
import rosbag, rospy
from sensor_msgs.msg import Image
from std_msgs.msg import Float64, Header, String
with rosbag.Bag(sys.argv[1], "w") as bag:
    for number in (3, 1, 2, 0):
        stamp = rospy.Time(1000 + number, 5)
        bag.write("/number", Float64(number), stamp)
        bag.write("/words", String("number %d" % number), stamp)
    image = Image(header=Header(seq=1, frame_id="c"), height=2, width=3, encoding="rgb8", step=9, data=bytes(range(18)))
    bag.write("/image", image, rospy.Time(1001))
"""
READ_BAG = """
import sys
import rosbag
with rosbag.Bag(sys.argv[1]) as bag:
    for topic, message, stamp in bag.read_messages():
        print(topic, message._type, message._md5sum, stamp.to_nsec(), repr(str(message)))
    for connection in sorted(bag._get_connections(), key=lambda each: each.topic):
        print(connection.topic, connection.datatype, connection.md5sum, len(connection.msg_def))
"""


@pytest.fixture
def no_modules(tmp_path: Path) -> Path:
    """A folder without any of stock's modules: the program has ours for all that it imports."""
    return link_modules(tmp_path / "modules", [])


@pytest.mark.parametrize(
    "words",
    [
        "bagsort.py in.bag out.bag",
        "fastrebag.py in.bag out.bag",
        "topic_renamer.py /words in.bag /text out.bag",
        "fix_md5sums.py in.bag",
        "fixbag.py in.bag out.bag",
        "savemsg.py -b in.bag std_msgs/String",
    ],
)
def test_a_script_of_rosbag_makes_the_same_bag(master: Master, no_modules: Path, tmp_path: Path, words: str) -> None:
    results = []
    for face in ("stock", "ours"):
        folder = tmp_path / face
        folder.mkdir()
        run("stock", master, MAKE_BAG, str(folder / "in.bag"))
        script, *arguments = words.split(" ")
        code, out = said(face, master, no_modules, [f"/usr/lib/rosbag/{script}", *arguments], cwd=folder)
        bags = {file.name: run("stock", master, READ_BAG, str(file)) for file in sorted(folder.glob("*.bag"))}
        results.append((code, out, bags))
    assert results[0] == results[1]
    assert results[0][0] == 0


def test_a_field_is_relayed_and_transformed(launcher: Master, no_modules: Path) -> None:
    talker = start(
        "stock",
        launcher,
        """
import rospy
from geometry_msgs.msg import Pose
rospy.init_node("posing")
pose = Pose()
pose.position.x = 3.0
pose.position.y = 4.0
publisher = rospy.Publisher("/posing/pose", Pose, queue_size=1)
print("ready")
rospy.Timer(rospy.Duration(0.05), lambda _: publisher.publish(pose))
rospy.spin()
""",
    )
    talker.wait_line("^ready$")
    for face in ("stock", "ours"):
        tools = link_modules(no_modules / face, ["rostopic", "topic_tools"])
        length = [f"/{face}/length", "std_msgs/Float64", "numpy.hypot(m.x, m.y)", "--import", "numpy"]
        begin(face, launcher, tools, ["/usr/lib/topic_tools/transform", "/posing/pose/position", *length])
        fields = [f"/{face}/point", "geometry_msgs/Point", "{x: m.position.y, y: m.position.x, z: m.position.z}"]
        begin(face, launcher, tools, ["/usr/lib/topic_tools/relay_field", "/posing/pose", *fields])
        program = f"""
import rospy
from geometry_msgs.msg import Point
from std_msgs.msg import Float64
rospy.init_node("asking", anonymous=True)
print(rospy.wait_for_message("/{face}/length", Float64, 20).data)
point = rospy.wait_for_message("/{face}/point", Point, 20)
print(point.x, point.y, point.z)
"""
        assert run("stock", launcher, program) == "5.0\n4.0 3.0 0.0\n"


def test_a_mux_is_selected(launcher: Master, no_modules: Path) -> None:
    mux = ["/usr/lib/topic_tools/mux", "/muxed", "/first", "/second", "mux:=switch"]
    launcher.run(mux)
    until(lambda: launcher.call("lookupService", "/switch/list")[0] == 1, "the mux offers its services")
    answers = []
    for face in ("stock", "ours"):
        tools = link_modules(no_modules / face, [])
        folder = "/usr/lib/topic_tools"
        answers.append(
            [
                said(face, launcher, tools, [f"{folder}/mux_add", "switch", "/third"]),
                said(face, launcher, tools, [f"{folder}/mux_list", "switch"]),
                said(face, launcher, tools, [f"{folder}/mux_select", "switch", "/third"]),
                said(face, launcher, tools, [f"{folder}/mux_select", "switch", "/first"]),
                said(face, launcher, tools, [f"{folder}/mux_delete", "switch", "/third"]),
                said(face, launcher, tools, [f"{folder}/mux_select", "switch", "/third"]),
            ]
        )
    assert answers[0] == answers[1]
    assert answers[0][0][0] == 0


def test_stock_rosbag_works_on_our_rospy_and_genpy(launcher: Master, no_modules: Path, tmp_path: Path) -> None:
    results = []
    for face in ("stock", "ours"):
        tools = link_modules(no_modules / face, ["rosbag", "roslz4", *CATKIN])
        folder = tmp_path / face
        folder.mkdir()
        run("stock", launcher, MAKE_BAG, str(folder / "in.bag"))
        answers = []
        for words in ("info in.bag", "info -y -k topics in.bag", "check in.bag", "compress in.bag", "reindex in.bag"):
            answers.append(said(face, launcher, tools, ["rosbag", *words.split(" ")], cwd=folder))
        answers.append(
            said(
                face,
                launcher,
                tools,
                ["rosbag", "filter", "in.bag", "out.bag", "m.data != 2 if 'num' in topic else 1"],
                cwd=folder,
            )
        )
        bags = {file.name: run("stock", launcher, READ_BAG, str(file)) for file in sorted(folder.glob("*.bag"))}
        results.append((answers, bags))
    assert results[0] == results[1]
    assert results[0][0][0][0] == 0


LAUNCH = """<launch>
  <arg name="text" default="hello"/>
  <group ns="robot">
    <param name="text" value="$(arg text)"/>
    <rosparam>gains: [1, 2.5]</rosparam>
    <node pkg="rostopic" type="rostopic" name="said" args="pub -l /robot/words std_msgs/String $(arg text)"/>
  </group>
</launch>
"""
ROSLAUNCH = ["roslaunch", "rosmaster", "rosclean", "rosunit", "rosservice", "rosnode", *CATKIN]
ROSLAUNCH += ["rostopic", "rosmsg", "rosparam", "rostest"]


def test_stock_roslaunch_works_on_our_modules(launcher: Master, no_modules: Path, tmp_path: Path) -> None:
    file = tmp_path / "robot.launch"
    file.write_text(LAUNCH)
    tools = link_modules(no_modules / "launch", ROSLAUNCH)
    for words in ("--nodes", "--ros-args", "--files", "--dump-params", "--args=/robot/said", "--find-node=/robot/said"):
        command = ["roslaunch", words, str(file)]
        assert said("ours", launcher, tools, command) == said("stock", launcher, tools, command)
    launch = begin("ours", launcher, tools, ["roslaunch", "--wait", str(file), "text:=bye"])
    listen = """
import rospy
from std_msgs.msg import String
rospy.init_node("listen")
print(rospy.wait_for_message("/robot/words", String, 30).data, sorted(rospy.get_param("/robot").items()))
"""
    assert run("stock", launcher, listen) == "bye [('gains', [1, 2.5]), ('text', 'bye')]\n"
    launch.signal(signal.SIGINT)
    assert launch.wait(30) == 0
    assert "done" in launch.lines[-1]


ROSTEST = """<launch>
  <param name="expected" value="3"/>
  <test pkg="rostest" type="paramtest" test-name="has_it" time-limit="20">
    <param name="param_name_target" value="/expected"/>
    <param name="test_duration" value="5.0"/>
    <param name="wait_time" value="5.0"/>
  </test>
</launch>
"""


def test_stock_rostest_works_on_our_modules(launcher: Master, no_modules: Path, tmp_path: Path) -> None:
    package = tmp_path / "tested"
    package.mkdir()
    (package / "package.xml").write_text(
        "<package><name>tested</name><version>1.0.0</version><description>x</description>"
        "<maintainer email='a@b.c'>x</maintainer><license>x</license></package>"
    )
    (package / "one.test").write_text(ROSTEST)
    tools = link_modules(no_modules / "test", ROSLAUNCH)
    for face in ("stock", "ours"):
        code, out = said(face, launcher, tools, ["rostest", str(package / "one.test")], ROS_PACKAGE_PATH=str(tmp_path))
        assert code == 0, out
        assert "RESULT: SUCCESS" in out


RECONFIGURE_SERVER = """
import rospy
from dynamic_reconfigure.cfg import TestConfig
from dynamic_reconfigure.server import Server
rospy.init_node("tuned")
server = Server(TestConfig, lambda config, level: config)
print("ready", flush=True)
rospy.spin()
"""


def test_dynparam_asks_a_reconfigure_server(launcher: Master, no_modules: Path, tmp_path: Path) -> None:
    start("stock", launcher, RECONFIGURE_SERVER).wait_line("^ready$")
    dynparam = "/usr/lib/dynamic_reconfigure/dynparam"
    answers = []
    for number, face in enumerate(("stock", "ours")):
        verbs = ("list", "set /tuned int_ 7", "get /tuned", f"dump /tuned {face}.yaml")
        set_back = said(face, launcher, no_modules, [dynparam, "set", "/tuned", "int_", str(number)])
        each = [said(face, launcher, no_modules, [dynparam, *words.split()], cwd=tmp_path) for words in verbs]
        file = tmp_path / f"{face}.yaml"
        for _ in range(5):  # the groups are missing if the values arrive before their description
            if "groups:" not in file.read_text():
                said(face, launcher, no_modules, [dynparam, *verbs[-1].split()], cwd=tmp_path)
        answers.append((set_back, each, file.read_text()))
    assert answers[0] == answers[1]
    assert "/tuned" in answers[0][1][0][1]
    assert "int_: 7" in answers[0][2] or "'int_': 7" in answers[0][1][2][1]
