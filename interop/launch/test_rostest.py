"""The same tests under stock rostest and `pyros1 test`: exit codes, result files, what the summaries count (L186).

Feature: launch tests run as with rostest -- same result files
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import xml.etree.ElementTree
from pathlib import Path

import pytest
from harness import SOURCE

pytestmark = pytest.mark.ours_only

PACKAGE = """<package format="2"><name>tested</name><version>1.0.0</version><description>Tests.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
UNIT = """#!/usr/bin/python3
import sys, time, unittest
import rospy, rosunit
from std_msgs.msg import String

class Case(unittest.TestCase):
    def test_param(self):
        self.assertEqual(rospy.get_param("~own"), 3)
    def test_topic(self):
        rospy.Publisher("in", String, queue_size=1, latch=True).publish("word")
        self.assertEqual(rospy.wait_for_message("out", String, 40).data, "word")
    def test_wrong(self):
        self.assertEqual(1, 2)
    def test_error(self):
        raise ValueError("<oh>")

for name in ("wrong", "error"):
    if name not in sys.argv:
        delattr(Case, "test_" + name)
if "hang" in sys.argv:
    time.sleep(1000)
if "mute" in sys.argv:
    sys.exit(0)
rospy.init_node("unit")
rosunit.unitrun("tested", "case", Case)
"""
NODES = '<node pkg="topic_tools" type="relay" name="relay" args="in out"/>'
GOOD = '<test pkg="tested" type="unit" test-name="good"><param name="own" value="3"/></test>'
FILES = {
    "good": (0, GOOD),
    "wrong": (2, GOOD + GOOD.replace('test-name="good"', 'test-name="bad" args="wrong error"')),
    "unable": (
        1,
        GOOD + '<test pkg="tested" type="unit" test-name="mute" args="mute"/>'
        '<test pkg="tested" type="none" test-name="none"/>',
    ),
    "slow": (1, '<test pkg="tested" type="unit" test-name="slow" args="hang" time-limit="1"/>'),
    "double": (1, GOOD + GOOD.replace('test-name="good"', 'test-name="good" name="other"')),
    "tools": (
        2,
        '<node pkg="rostopic" type="rostopic" name="talk" args="pub -r 10 /beat std_msgs/String x"/>'
        '<test pkg="rostest" type="paramtest" test-name="param"><param name="param_name_target" value="/rosversion"/>'
        '<param name="test_duration" value="5.0"/><param name="wait_time" value="5.0"/></test>'
        '<test pkg="rostest" type="paramtest" test-name="noparam"><param name="param_name_target" value="/none"/>'
        '<param name="test_duration" value="0.5"/><param name="wait_time" value="1.0"/></test>',
    ),
}


@pytest.mark.parametrize("name", FILES)
def test_exit_code_results_and_summary(name: str, tmp_path: Path) -> None:
    package = tmp_path / "tested"
    (package / "test").mkdir(parents=True)
    (package / "package.xml").write_text(PACKAGE)
    (package / "unit").write_text(UNIT)
    (package / "unit").chmod(0o755)
    code, tests = FILES[name]
    (package / "test" / "all.test").write_text(f"<launch>{NODES}{tests}</launch>")
    seen = {}
    for who, command in {"stock": ["rostest"], "ours": [sys.executable, "-m", "pyros1", "test"]}.items():
        environ = {
            **os.environ,
            "ROS_HOME": str(tmp_path / who),
            "ROS_HOSTNAME": "localhost",
            "PATH": f"/usr/bin:{os.environ['PATH']}",  # some nodes say ``env python3``
            "ROS_PACKAGE_PATH": f"{package}:/usr/share",
            "PYTHONPATH": str(SOURCE) if who == "ours" else "",
        }
        done = subprocess.run(
            [*command, "tested", "all.test"], env=environ, capture_output=True, text=True, timeout=120, check=False
        )
        assert done.returncode == code, f"{who}: {done.stdout}\n{done.stderr}"
        folder = tmp_path / who / "test_results"
        files = {str(path.relative_to(folder)): xml_counts(path) for path in sorted(folder.rglob("*.xml"))}
        seen[who] = (files, re.findall(r"(?:RESULT|TESTS|ERRORS|FAILURES): \w+", done.stdout))
    assert seen["ours"] == seen["stock"]


def xml_counts(path: Path) -> list[tuple[str | None, str | None, list[str]]]:
    """Classes and names of a file's test cases, and the tags in them."""
    root = xml.etree.ElementTree.parse(path).getroot()
    return [
        (case.get("classname"), case.get("name"), sorted(child.tag for child in case)) for case in root.iter("testcase")
    ]
