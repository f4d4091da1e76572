"""More scripts of Debian's packages, unmodified, on stock's modules and on ours, with the same results."""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest
from faces import run, start
from harness import Master
from stock_programs import begin, link_modules, said

MASTERS = ("ours",)
OWN_MASTER = True

MANIFEST = """<package><name>robot</name><version>1.0.0</version><description>x</description>
<maintainer email="a@example.org">x</maintainer><license>x</license><run_depend>rostopic</run_depend></package>
"""
FILES = {
    "package.xml": MANIFEST,
    "good.launch": '<launch><arg name="text" default="x"/><arg name="b" default="$(arg text)"/>'
    '<node pkg="rostopic" type="rostopic" name="said" args="list"/></launch>',
    "undeclared.launch": '<launch><test pkg="rostest" type="hztest" test-name="rate"/></launch>',
    "lacking.launch": '<launch><node pkg="nope" type="no" name="no"/></launch>',
    "outer.launch": '<launch><include file="$(find robot)/undeclared.launch"/></launch>',
}
NAMES = [*FILES][1:]


@pytest.fixture
def robot(tmp_path: Path) -> Path:
    """A package with launch files."""
    folder = tmp_path / "packages" / "robot"
    folder.mkdir(parents=True)
    for name, text in FILES.items():
        (folder / name).write_text(text)
    return folder


@pytest.fixture
def no_modules(tmp_path: Path) -> Path:
    """A folder without any of stock's modules."""
    return link_modules(tmp_path / "modules", [])


def alike(master: Master, no_modules: Path, words: list[str], cwd: Path | None = None, **extra: str) -> tuple[int, str]:
    """Run a program on both, require the same exit code and output, and return them."""
    stock, ours = (said(face, master, no_modules, words, cwd, **extra) for face in ("stock", "ours"))
    assert ours == stock
    return ours


def package_path(robot: Path) -> str:
    return f"{robot.parent}{os.pathsep}/usr/share"


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("options", ["", "-v", "-w"])
def test_roslaunch_deps(master: Master, no_modules: Path, robot: Path, name: str, options: str) -> None:
    words = ["roslaunch-deps", *options.split(), str(robot / name)]
    code, out = alike(master, no_modules, words, ROS_PACKAGE_PATH=package_path(robot))
    assert code == 0, out
    assert ("rostest" in out) == (name in ("undeclared.launch", "outer.launch"))


def test_roslaunch_logs(master: Master, no_modules: Path) -> None:
    code, out = alike(master, no_modules, ["roslaunch-logs"])
    assert code == 0, out
    assert str(master.call("getParam", "/run_id")[2]) in out
    code, out = alike(master, no_modules, ["roslaunch-logs"], ROS_MASTER_URI="http://localhost:1")
    assert code == 2
    assert "No active roscore" in out


def test_roslaunch_complete(master: Master, no_modules: Path, robot: Path) -> None:
    code, out = alike(master, no_modules, ["roslaunch-complete", str(robot / "good.launch"), "text:=b"])
    assert (code, out) == (0, "b text\n")
    assert alike(master, no_modules, ["roslaunch-complete", "nope.launch"])[0] == 1


@pytest.mark.parametrize("name", NAMES)
def test_roslaunch_check(master: Master, no_modules: Path, robot: Path, tmp_path: Path, name: str) -> None:
    words = ["/usr/share/roslaunch/scripts/roslaunch-check", "-o", "out.xml", str(robot / name)]
    results = []
    for face in ("stock", "ours"):
        code, out = said(face, master, no_modules, words, tmp_path, ROS_PACKAGE_PATH=package_path(robot))
        report = (tmp_path / "out.xml").read_text()
        results.append((code, *(re.sub(r"ROS path \[\d\].*\n|File .*\n", "", text) for text in (out, report))))
    assert results[0] == results[1]
    assert results[0][0] == (name != "good.launch")


MAKE_BAG = """
import sys
import rosbag, rospy
from std_msgs.msg import Float64, String
with rosbag.Bag(sys.argv[1], "w") as bag:
    for number in range(3):
        stamp = rospy.Time(1000 + number, 5)
        bag.write("/number", Float64(number), stamp)
        bag.write("/words", String("number %d" % number), stamp)
"""
READ_BAG = """
import sys
import rosbag
with rosbag.Bag(sys.argv[1]) as bag:
    for topic, message, stamp in bag.read_messages():
        print(topic, message._type, message._md5sum, stamp.to_nsec(), repr(str(message)))
    for connection in sorted(bag._get_connections(), key=lambda each: each.topic):
        print(connection.topic, connection.datatype, connection.md5sum, connection.msg_def)
"""
OLD = "[std_msgs/Float64]:\nfloat32 data\nint32 extra\n"


@pytest.mark.parametrize(
    "words",
    [
        "fixbag_batch.py in.bag",
        "fix_msg_defs.py in.bag out.bag",
        "fix_moved_messages.py empty.txt in.bag out.bag",
        "fix_moved_messages.py",
        "makerule.py same.saved rules.bmr",
        "makerule.py in.bag",
    ],
)
def test_a_script_of_rosbag(master: Master, no_modules: Path, tmp_path: Path, words: str) -> None:
    results = []
    for face in ("stock", "ours"):
        folder = tmp_path / face
        folder.mkdir()
        run("stock", master, MAKE_BAG, str(folder / "in.bag"))
        (folder / "empty.txt").write_text("")
        (folder / "same.saved").write_text("[std_msgs/Float64]:\nfloat64 data\n")
        script, *arguments = words.split(" ")
        code, out = said(face, master, no_modules, [f"/usr/lib/rosbag/{script}", *arguments], cwd=folder)
        bags = {file.name: run("stock", master, READ_BAG, str(file)) for file in sorted(folder.glob("*.bag*"))}
        results.append((code, out, bags))
    assert results[0] == results[1]
    assert results[0][0] == (2 if words in ("fix_moved_messages.py", "makerule.py in.bag") else 0)


def test_makerule_writes_a_rule(master: Master, no_modules: Path, tmp_path: Path) -> None:
    rules = []
    results = []
    for face in ("stock", "ours"):
        folder = tmp_path / face
        folder.mkdir()
        (folder / "old.saved").write_text(OLD)
        words = ["/usr/lib/rosbag/makerule.py", "old.saved", "rules.bmr"]
        results.append(said(face, master, no_modules, words, cwd=folder))
        rules.append((folder / "rules.bmr").read_text())
    assert results[0] == results[1]
    assert results[0][0] == 0
    for text in ("class update_std_msgs_Float64_fa59d2191fc77c4ede9a81085a2a6141(MessageUpdateRule):", "int32 extra"):
        assert all(text in rule for rule in rules)  # ours guesses more of update()


def test_bag2png_needs_a_module_that_is_gone(master: Master, no_modules: Path) -> None:
    results = [said(face, master, no_modules, ["/usr/lib/rosbag/bag2png.py", "x"]) for face in ("stock", "ours")]
    assert [code for code, _ in results] == [1, 1]
    assert all("No module named 'Image'" in out for _, out in results)


def test_bullet_migration_sed(master: Master, no_modules: Path, tmp_path: Path) -> None:
    texts = []
    for face in ("stock", "ours"):
        folder = tmp_path / face
        folder.mkdir()
        (folder / "a.cpp").write_text('#include "LinearMath/btTransform.h"\nbtVector3 v;\n')
        assert said(face, master, no_modules, ["/usr/lib/tf/bullet_migration_sed.py"], cwd=folder)[0] == 0
        texts.append((folder / "a.cpp").read_text())
    assert texts[0] == texts[1]
    assert "tf::Vector3" in texts[0]


TALKER = """
import rospy
from std_msgs.msg import Float64
rospy.init_node("talker")
number = rospy.Publisher("/number", Float64, queue_size=10)
rospy.Publisher("/silent", Float64, queue_size=10)
print("ready", flush=True)
rospy.Timer(rospy.Duration(0.05), lambda _: number.publish(1))
rospy.spin()
"""
CHECKS = {
    "advertisetest": {"topics": [{"name": "/number", "timeout": 30, "type": "std_msgs/Float64"}]},
    "publishtest": {
        "topics": [{"name": "/number", "timeout": 30}, {"name": "/silent", "timeout": 1, "negative": True}]
    },
    "hztest": {"topic": "/number", "hz": 20.0, "hzerror": 15.0, "test_duration": 5.0, "wait_time": 20.0},
    "paramtest": {"param_name_target": "/given", "test_duration": 1.0, "wait_time": 5.0},
}


@pytest.mark.parametrize("kind", CHECKS)
def test_nodes_of_rostest(launcher: Master, no_modules: Path, tmp_path: Path, kind: str) -> None:
    start("stock", launcher, TALKER).wait_line("^ready$")
    launcher.call("setParam", "/given", 3)
    for face in ("stock", "ours"):
        name = f"check_{face}"
        launcher.call("setParam", f"/{name}", CHECKS[kind])
        words = [f"/usr/share/rostest/nodes/{kind}", f"__name:={name}", f"--gtest_output=xml:{tmp_path / face}.xml"]
        code, out = said(face, launcher, no_modules, words)
        report = (tmp_path / f"{face}.xml").read_text()
        assert code == 0, out
        assert 'errors="0"' in report, report
        assert 'failures="0"' in report, report


def test_record_and_play_scripts(launcher: Master, no_modules: Path, tmp_path: Path) -> None:
    """/usr/bin/rosbag with our module: it starts our programs in place of stock's compiled ones."""
    start("stock", launcher, TALKER).wait_line("^ready$")
    words = ["rosbag", "record", "--limit=5", "-O", str(tmp_path / "made.bag"), "/number"]
    code, out = said("ours", launcher, no_modules, words)
    assert code == 0, out
    assert run("stock", launcher, READ_BAG, str(tmp_path / "made.bag")).count("/number std_msgs/Float64") == 6
    listen = 'import rospy\nfrom std_msgs.msg import Float64\nrospy.init_node("listen")\nprint("ready", flush=True)\n'
    listener = start("stock", launcher, listen + 'print(rospy.wait_for_message("/again", Float64, 20).data)\n')
    listener.wait_line("^ready$")
    words = ["rosbag", "play", "--wait-for-subscribers", str(tmp_path / "made.bag"), "/number:=/again"]
    player = begin("ours", launcher, no_modules, words)
    assert listener.wait(30) == 0
    assert player.wait(30) == 0
    assert listener.lines[-1] == "1.0"
