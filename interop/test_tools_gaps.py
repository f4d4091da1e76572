"""Stock's nodes of rostest (L186), scripts of rosbag (L146), node names of recorder and player (L05), beside ours."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import xml.etree.ElementTree
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from harness import SOURCE, Master, stock_tools, until

MASTERS = ("ours",)  # stock's tools and ours are compared, whatever the master
STOCK_PYTHON = "/usr/bin/python3"
MAKER = Path(__file__).resolve().parent / "peers" / "stock_bags.py"
OWN = SOURCE / "pyros1" / "packages"

pytestmark = pytest.mark.ours_only

# rostest --------------------------------------------------------------------------------------------------------------

PACKAGE = """<package format="2"><name>tested</name><version>1.0.0</version><description>Tests.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
TALK = """#!/usr/bin/python3
import rospy
from std_msgs.msg import String
rospy.init_node("talk")
publisher, rate = rospy.Publisher("/beat", String, queue_size=1), rospy.Rate(20)
while not rospy.is_shutdown():
    publisher.publish("x")
    rate.sleep()
"""
FILE = """<launch><node pkg="tested" type="talk" name="talk"/>
<test pkg="rostest" type="hztest" test-name="hz"><rosparam>
  {topic: beat, hz: 20.0, hzerror: 19.0, test_duration: 1.0, wait_time: 10}</rosparam></test>
<test pkg="rostest" type="hztest" test-name="hz_wrong"><rosparam>
  {topic: beat, hz: x, test_duration: 1.0}</rosparam></test>
<test pkg="rostest" type="publishtest" test-name="publish"><rosparam>
  {topics: [{name: beat, timeout: 10}, {name: silence, timeout: 0.5}]}</rosparam></test>
<test pkg="rostest" type="publishtest" test-name="publish_nothing"/>
<test pkg="rostest" type="advertisetest" test-name="advertise"><rosparam>
  {topics: [{name: /beat, timeout: 10, type: std_msgs/Bool}], services: [{name: /talk/get_loggers}]}</rosparam></test>
</launch>"""


def test_the_nodes_of_rostest_l186(tmp_path: Path) -> None:
    """One file, with good and with failing tests, under each rostest with its own nodes."""
    package = tmp_path / "tested"
    (package / "test").mkdir(parents=True)
    (package / "package.xml").write_text(PACKAGE)
    (package / "test" / "all.test").write_text(FILE)
    (package / "talk").write_text(TALK)
    (package / "talk").chmod(0o755)
    commands = {"stock": ["rostest"], "ours": [sys.executable, "-m", "pyros1", "test"]}

    def run(who: str) -> tuple[int, dict[str, list[str]], list[str]]:
        environ = {
            **os.environ,
            "ROS_HOME": str(tmp_path / who),
            "ROS_HOSTNAME": "localhost",
            "PATH": f"/usr/bin:{os.environ['PATH']}",  # stock's nodes say ``env python3``
            "ROS_PACKAGE_PATH": f"{package}:{OWN if who == 'ours' else '/usr/share'}",
            "PYTHONPATH": str(SOURCE) if who == "ours" else "",
        }
        done = subprocess.run(
            [*commands[who], "tested", "all.test"],
            env=environ,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        folder = tmp_path / who / "test_results"
        files = {str(path.relative_to(folder)): cases(path) for path in sorted(folder.rglob("*.xml"))}
        return done.returncode, files, re.findall(r"(?:RESULT|TESTS|ERRORS|FAILURES): \w+", done.stdout)

    with ThreadPoolExecutor() as pool:
        stock, ours = pool.map(run, commands)
    assert ours == stock
    assert ours[0] == 1
    assert ours[2] == ["RESULT: FAIL", "TESTS: 5", "ERRORS: 1", "FAILURES: 3"]


def cases(path: Path) -> list[str]:
    """Class and name of a file's test cases, and the tags in them."""
    root = xml.etree.ElementTree.parse(path).getroot()
    return [
        " ".join([str(case.get("classname")), str(case.get("name")), *sorted(child.tag for child in case)])
        for case in root.iter("testcase")
    ]


# rosbag ---------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bags(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bags")
    code, _, err = stock_tools().ask([str(MAKER), str(folder)], os.environ)
    assert code == 0, err
    (folder / "old.saved").write_text("[std_msgs/Int32]:\nint16 data\n")
    return folder


SCRIPTS = [
    "bagsort.py mixed.bag OUT",
    "fastrebag.py mixed.bag OUT",
    "topic_renamer.py /number mixed.bag /count OUT",
    "fixbag.py mixed.bag OUT",
    "fix_msg_defs.py mixed.bag OUT",
    "savemsg.py geometry_msgs/PoseStamped",
    "savemsg.py -b mixed.bag std_msgs/String",
    "makerule.py old.saved WHO.bmr",
    "fixbag.py mixed.bag",
    "fixbag.py mixed.bag out.bmr",
    "savemsg.py",
    "makerule.py old.saved",
]


@pytest.mark.parametrize("line", SCRIPTS)
def test_scripts_of_rosbag_l146(bags: Path, line: str) -> None:
    """The same exit code, the same bag; the same text where the text is what is asked for."""
    seen = {}
    for who in ("stock", "ours"):
        script, *words = line.replace("OUT", f"{who}.bag").replace("WHO", who).split()
        environ = {**os.environ, "ROS_HOME": str(bags)}
        if who == "stock":
            command = [STOCK_PYTHON, f"/usr/lib/rosbag/{script}"]
        else:
            command = [sys.executable, str(OWN / "rosbag" / "scripts" / script)]
            environ["PYTHONPATH"] = str(SOURCE)
        done = subprocess.run(
            [*command, *words],
            cwd=bags,
            env=environ,
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )
        made = dump(bags / f"{who}.bag") if "OUT" in line else ""
        says = script in ("savemsg.py", "makerule.py") and not done.returncode
        seen[who] = (done.returncode, made, done.stdout.replace(f"{who}.bmr", "WHO.bmr") if says else "")
    assert seen["ours"] == seen["stock"]


def dump(path: Path) -> list[str]:
    """All messages of a bag as stock reads them, sorted; stock's scripts lose the connection headers."""
    code, out, err = stock_tools().ask([str(MAKER), "dump", str(path)], os.environ)
    assert code == 0, err
    return sorted(line.partition(" [")[0] for line in out.splitlines())


def test_names_of_recorder_and_player_l05(launcher: Master, bags: Path, tmp_path: Path) -> None:
    def known() -> set[str]:
        return {name for table in launcher.call("getSystemState")[2] for _, names in table for name in names}

    for who in ("stock", "ours"):
        program = ["rosbag"] if who == "stock" else [sys.executable, "-m", "pyros1", "bag"]
        before = known()
        started = [
            launcher.run([*program, *words], python=who, TERM="dumb")
            for words in (["record", "-O", str(tmp_path / who), "/x"], ["play", "--pause", str(bags / "plain.bag")])
        ]
        until(lambda before=before: len(known() - before) == 2, f"the nodes of {who}")
        names = sorted(re.sub(r"\d{19}", "NS", name) for name in known() - before)
        for process in started:
            process.close()
        assert names == ["/play_NS", "/record_NS"], who
