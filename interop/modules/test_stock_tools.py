"""Stock's own tools with our rospy, rosgraph, genpy and the rest under them: they must not notice.

The tools' modules are stock's, found through links; everything else that they import is ours, or from Python's index.

Feature: stock's tools run on our modules -- rostopic, rosnode, rosservice, rosparam, rosmsg
"""

from __future__ import annotations

import re
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest
from faces import start
from harness import Master, Process
from stock_programs import CATKIN, begin, link_modules, said

STOCK = ("rostopic", "rosnode", "rosservice", "rosparam", "rosmsg", "roswtf", *CATKIN)
MASTERS = ("ours",)
OWN_MASTER = True

TALKER = """
import rospy
from geometry_msgs.msg import PoseStamped, Twist
from std_msgs.msg import Float64, String
from std_srvs.srv import SetBool, SetBoolResponse
rospy.init_node("talker")
rospy.set_param("~gains", {"p": 1.5, "i": [1, 2], "name": "x"})
rospy.Service("~switch", SetBool, lambda request: SetBoolResponse(request.data, "was set"))
rospy.Subscriber("command", Twist, lambda _: None)
pose = PoseStamped()
pose.header.frame_id = "map"
pose.pose.position.x = 2.5
rospy.Publisher("pose", PoseStamped, latch=True, queue_size=1).publish(pose)
rospy.Publisher("words", String, latch=True, queue_size=1).publish("hello")
number = rospy.Publisher("number", Float64, queue_size=10)
rate = rospy.Rate(50)
print("ready", flush=True)
while not rospy.is_shutdown():
    number.publish(0.25)
    try:
        rate.sleep()
    except rospy.ROSInterruptException:
        pass
"""


@pytest.fixture(scope="module")
def stock_modules(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with links to the tools' modules, and to no others of stock's."""
    return link_modules(tmp_path_factory.mktemp("modules"), STOCK)


@pytest.fixture(scope="module")
def talker(master: Master) -> Iterator[Process]:
    """A node of stock's for the tools to look at."""
    mark = len(master.processes)
    process = start("stock", master, TALKER)
    process.wait_line("^ready$")
    yield process
    master.close_since(mark)


@pytest.mark.parametrize(
    "words",
    [
        "rostopic list",
        "rostopic list -v",
        "rostopic list -p /pose",
        "rostopic type /pose",
        "rostopic type /pose/pose/position",
        "rostopic info /number",
        "rostopic info /none",
        "rostopic find std_msgs/String",
        "rostopic echo -n 1 /words",
        "rostopic echo -n 1 /pose/pose/position",
        "rostopic echo -n 1 --noarr --nostr /pose",
        "rostopic echo -n 2 -p /number",
        "rostopic echo -n 1 --offset /pose/header",
        "rostopic pub -1 /command geometry_msgs/Twist {linear:{x:1.5}}",
        "rostopic pub -1 /command geometry_msgs/Twist [1,2]",
        "rostopic nonsense",
        "rosnode list",
        "rosnode list -a",
        "rosnode list -u",
        "rosnode info /talker",
        "rosnode ping -c 2 /talker",
        "rosnode machine",
        "rosnode info /nobody",
        "rosservice list",
        "rosservice list -n",
        "rosservice type /talker/switch",
        "rosservice node /talker/switch",
        "rosservice args /talker/switch",
        "rosservice find std_srvs/SetBool",
        "rosservice call /talker/switch true",
        "rosservice call /talker/switch {data:true}",
        "rosservice call /talker/switch 1 2 3",
        "rosservice info /talker/switch",
        "rosservice uri /talker/switch",
        "rosservice type /none",
        "rosparam list /talker",
        "rosparam get /talker/gains",
        "rosparam get /none",
        "rosmsg show geometry_msgs/PoseStamped",
        "rosmsg show -r std_msgs/Header",
        "rosmsg md5 nav_msgs/Odometry",
        "rosmsg package std_srvs",
        "rosmsg package geometry_msgs",
        "rosmsg show none/None",
        "rossrv show std_srvs/SetBool",
        "rossrv md5 std_srvs/SetBool",
        "rossrv package std_srvs",
    ],
)
def test_a_tool_says_the_same(master: Master, talker: Process, stock_modules: Path, words: str) -> None:
    stock = said("stock", master, stock_modules, words.split(" "))
    assert said("ours", master, stock_modules, words.split(" ")) == stock
    assert stock[1] or words.startswith("rostopic pub")


@pytest.mark.parametrize(
    ("words", "line"),
    [
        ("rostopic hz /number", r"average rate: [45]\d\.\d"),
        ("rostopic bw /number", r"average: [34]\d\d(\.\d+)?B/s"),
        ("rostopic hz -w 10 --wall-time /number", r"average rate: [45]\d\.\d"),
    ],
)
@pytest.mark.parametrize("face", ["stock", "ours"])
def test_a_tool_that_measures(
    launcher: Master, talker: Process, stock_modules: Path, face: str, words: str, line: str
) -> None:
    process = begin(face, launcher, stock_modules, words.split(" "))
    process.wait_line(line, timeout=30)
    process.signal(signal.SIGINT)
    assert process.wait() in (0, -signal.SIGINT, 130)
    assert not [text for text in process.lines if "Traceback" in text]


@pytest.mark.parametrize("face", ["stock", "ours"])
def test_parameters_are_set_loaded_dumped_and_deleted(
    master: Master, stock_modules: Path, tmp_path: Path, face: str
) -> None:
    file = tmp_path / "gains.yaml"
    file.write_text("a: 1\nb: [1.5, x]\nangle: deg(180)\n")
    for words in (f"rosparam load {file} /{face}", f"rosparam set /{face}/c true", f"rosparam delete /{face}/a"):
        assert said(face, master, stock_modules, words.split(" "))[0] == 0
    assert said(face, master, stock_modules, ["rosparam", "dump", f"{tmp_path}/out.yaml", f"/{face}"])[0] == 0
    assert master.call("getParam", f"/{face}")[2] == {
        "b": [1.5, "x"],
        "angle": pytest.approx(3.14159, abs=1e-4),
        "c": True,
    }
    assert (tmp_path / "out.yaml").read_text().splitlines()[1:] == ["b:", "- 1.5", "- x", "c: true"]


@pytest.mark.parametrize("face", ["stock", "ours"])
def test_a_node_is_killed(launcher: Master, stock_modules: Path, face: str) -> None:
    victim = start("stock", launcher, f"import rospy\nrospy.init_node('victim_{face}')\nprint('ready')\nrospy.spin()")
    victim.wait_line("^ready$")
    code, out = said(face, launcher, stock_modules, ["rosnode", "kill", f"/victim_{face}"])
    assert code == 0
    assert out.splitlines()[-1] == "killed"
    victim.wait()


@pytest.mark.parametrize("words", ["roswtf", "roswtf --offline", "roswtf --help"])
def test_roswtf_finds_the_same(
    master: Master, talker: Process, stock_modules: Path, words: str, tmp_path: Path
) -> None:
    """It also says that rosdep is not there: that is no module of ours, and its findings are left out."""
    stock, ours = (said(face, master, stock_modules, words.split(" "), cwd=tmp_path) for face in ("stock", "ours"))
    assert ours[0] == stock[0] == 0
    left_out = re.compile(r".*ROS Dep database.*|.*rosdep2.*|Found \d+ warning\(s\)\.")
    assert left_out.sub("", ours[1]).split() == left_out.sub("", stock[1]).split()
    assert "/command" in stock[1] or words != "roswtf"


@pytest.mark.parametrize("words", ["rostopic list", "rosnode list", "rosservice list", "rosparam list", "rosmsg list"])
def test_without_a_master(master: Master, stock_modules: Path, words: str) -> None:
    nobody = {"ROS_MASTER_URI": "http://localhost:1/"}
    stock, ours = (said(face, master, stock_modules, words.split(" "), **nobody) for face in ("stock", "ours"))
    assert ours[0] == stock[0]
    if words == "rosmsg list":
        assert "std_msgs/String" in ours[1].splitlines()
    else:
        assert ours[1] == stock[1]
