"""rosunit and rostest on stock's modules and on ours: what programs of tests print, write and return."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from faces import FACES, command, environ, run, same
from harness import Master

MASTERS = ("ours",)
CASES = """
import sys, unittest
import {module}
class TestThing(unittest.TestCase):
    def test_good(self):
        print("hello out")
    @unittest.skip("later")
    def test_skip(self):
        pass
class TestWrong(TestThing):
    def test_bad(self):
        self.assertEqual(1, 2, "no")
    def test_error(self):
        raise ValueError("oh <x>")
if __name__ == "__main__":
    {module}.{function}("pkg", "na me", {kind})
    print("the end")
"""
PLACES = re.compile(r'  File "[^"]*", line \d+, in .*\n(    .*\n)*')
ESCAPES = [("&lt;", "<"), ("&gt;", ">")]


def run_tests(face: str, master: Master, text: str, *words: str) -> tuple[int, str, list[object]]:
    """Return exit code, output, and results of a program of tests."""
    program = master.home / f"tests_{face}.py"
    program.write_text(text)
    home = master.home / f"home_{face}"
    variables = environ(face, master, ROS_HOME=str(home), ROS_TEST_RESULTS_DIR=None)
    done = subprocess.run(
        [*command(face, program), *words],
        env=variables,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    out = PLACES.sub("", done.stdout).replace(str(home), "HOME")
    for old, new in ESCAPES:
        out = out.replace(old, new)
    files = sorted(home.rglob("*.xml")) if home.exists() else []
    return done.returncode, out, [results(file) for file in files]


def results(file: Path) -> object:
    root = ET.parse(file).getroot()
    cases = [
        (
            case.get("classname"),
            case.get("name"),
            [(each.tag, each.get("type"), (each.text or "").split("\n")[0]) for each in case],
        )
        for case in root.iter("testcase")
    ]
    printed = (root.findtext("system-out") or "").replace("<![CDATA[", "").replace("]]>", "").strip()
    return file.name, {key: root.get(key) for key in ("errors", "failures", "tests", "name")}, cases, printed


@pytest.mark.parametrize("words", [[], ["--text"], ["--gtest_output=xml:{home}/there/x.xml"]], ids=["", "text", "file"])
@pytest.mark.parametrize("kind", ["TestThing", "TestWrong", '"__main__.TestThing"'])
@pytest.mark.parametrize(("module", "function"), [("rosunit", "unitrun"), ("rostest", "rosrun")])
def test_programs_of_tests(master: Master, module: str, function: str, kind: str, words: list[str]) -> None:
    text = CASES.format(module=module, function=function, kind=kind)
    said = {}
    for face in FACES:
        given = [word.format(home=master.home / f"home_{face}") for word in words]
        code, out, found = run_tests(face, master, text, *given)
        said[face] = code, re.sub(r"in \d\.\d+s", "", out), found
    assert said["ours"] == said["stock"]
    assert said["ours"][0] == (1 if "Wrong" in kind else 0)


LIBRARY = """
import os
import rosunit, rosunit.junitxml as junit, rosunit.core
print(rosunit.XML_OUTPUT_FLAG)
for name in ("a", "a/b", "x y$z"):
    for flag in (False, True):
        print(rosunit.xml_results_file("pkg", name, flag, env={"ROS_HOME": "/tmp", "ROS_TEST_RESULTS_DIR": HOME}))
for folder, file in (("/a/b", "/a/b/c/d.launch"), ("/a/b", "/a/b/x"), ("/q", "y/z.test"), ("/a", "/a/b.c/d.e.f")):
    print(rosunit.rostest_name_from_path(folder, file))
print(junit.test_success_junit_xml("suite").decode())
print(junit.test_failure_junit_xml("suite", "why <x>", "out", "C", "t").decode())
with open(os.path.join(HOME, "one.xml"), "wb") as file:
    file.write(junit.test_failure_junit_xml("suite", "why"))
read = junit.read(os.path.join(HOME, "one.xml"), "name")
print(read.num_tests, read.num_errors, read.num_failures, [(c.name, c.classname, c.passed, c.time)
      for c in read.test_case_results])
with open(os.path.join(HOME, "bad.xml"), "w") as file:
    file.write("nothing")
bad = junit.read(os.path.join(HOME, "bad.xml"), "name")
print(bad.name, bad.num_tests, bad.num_errors)
total = junit.Result("all", 1, 2, 3)
total.accumulate(read)
print(total.num_tests, total.num_errors, total.num_failures, len(total.test_case_results))
case = junit.TestCaseResult("case")
print(case.passed)
case.add_failure(junit.TestFailure("Kind", "text <"))
case.add_error(junit.TestError("Other", "text"))
print(case.passed, case.description, case.errors[0].xml().decode(), case.failures[0].type)
total.add_test_case_result(case)
print(total.num_tests, total.num_errors, total.num_failures)
junit.print_summary(junit.Result("x", 0, 0, 4), "ME")
"""


def test_the_library(master: Master, tmp_path: Path) -> None:
    out = same(master, f"HOME = {str(tmp_path)!r}\n" + LIBRARY)
    assert "rostest-a_b.xml" in out


ASKING = """
import rospy, rostest
from std_msgs.msg import String
rospy.init_node("asking")
publisher = rospy.Publisher("out", String, queue_size=1)
rospy.Subscriber("in", String, lambda message: None)
while not rostest.is_publisher("/out", "/asking") or not rostest.is_subscriber("/in", "/asking"):
    rospy.sleep(0.01)
print(rostest.is_publisher("/out", "/other"), rostest.is_publisher("/none", "/asking"),
      rostest.is_subscriber("/out", "/asking"), rostest.get_master().getPid("/me")[0])
"""


def test_asking_the_master(launcher: Master) -> None:
    assert same(launcher, ASKING) == "False False False 1\n"


FILES = r"""
import os, re, sys
import xml.etree.ElementTree as ET
os.environ["ROS_TEST_RESULTS_DIR"] = HOME
import rosunit.junitxml as junit
def attempt(function, *args, **names):
    try:
        result = function(*args, **names)
        print("  ->", result if not isinstance(result, ET.Element) else ET.tostring(result))
    except Exception as error:
        print("  raises", type(error).__name__, error)
def show(result):
    print("=", result.name, result.num_errors, result.num_failures, result.num_tests, result.time,
          [result.system_out, result.system_err])
    for case in result.test_case_results:
        print("   ", case.name, case.passed, case.time, case.classname, [case.description],
              [(each.type, each.text) for each in case.errors + case.failures])
case = junit.TestCaseResult("case")
case.add_error(junit.TestError("Kind", "text <&]]> \x00\x07 \xe9"))
case.add_failure(junit.TestFailure("Kind", "failed"))
case.time, case.classname = 1.25, "Class"
for each in case, case.errors[0], case.failures[0]:
    attempt(each.xml)
    attempt(each.xml_element)
info = junit.TestInfo("Kind", "text")
print(info.type, info.text)
result = junit.Result("suite", 1, 2, 3)
result.system_out, result.system_err = "out \x01 <x>", "err"
attempt(result.xml_element)
attempt(junit.cdata, "x]]>y")
attempt(junit.filter_nonprintable_text, "a\x00b\x1b[0m\t\xe9")
attempt(junit.filter_nonprintable_text, 3)
print(ascii(junit.pattern))
PLACE = os.path.join(HOME, "package", "TEST-one.xml")
os.makedirs(os.path.join(HOME, "package", "deeper"))
os.makedirs(os.path.join(HOME, "other"))
SUITE = '<testsuite name="s" tests="3" errors="1" failures="1" time="1.5">%s</testsuite>'
INNER = '<testcase name="a" classname="k" time="0.5"/><testcase name="b" time="x"><failure type="T" message="M">text' \
        '</failure></testcase><testcase name="c"><error type="E"> one <![CDATA[two]]>\n </error></testcase><testcase>' \
        '<skipped/></testcase><system-out>said\x1b\n</system-out><system-err>err</system-err>'
for text in (SUITE % INNER, "<testsuites>" + SUITE % INNER + SUITE % INNER + "</testsuites>", "<testsuites/>",
             "<testsuite/>", "<other/>", "", "nothing", SUITE.replace("3", "x"),
             SUITE % ('<properties/><testcase name="a"><system-out>in</system-out></testcase>' + SUITE % INNER)):
    with open(PLACE, "w") as file:
        file.write(text)
    try:
        show(junit.read(PLACE, "name"))
    except ValueError as error:
        print("wrong", error)
    with open(PLACE) as file:
        print(file.read())
show(junit.read(os.path.join(HOME, "nothing"), "x"))
for name in ("package/TEST-one.xml", "package/deeper/two.xml", "package/notes.txt", "top.xml", "other/three.xml"):
    with open(os.path.join(HOME, name), "w") as file:
        file.write(SUITE % "")
for wanted in ([], ["package"], ["nobody"]):
    show(junit.read_all(wanted))
show(junit.read_all(filter_=["other"]))
junit.print_summary(junit.read(PLACE, "name"))
for count in (0, 2):
    junit.print_summary(junit.Result("x", 0, 0, count), runner_name="ME")
"""


def test_files_of_results(master: Master, tmp_path: Path) -> None:
    said = [
        run(face, master, f"HOME = {str(tmp_path / face)!r}\n" + FILES).replace(str(tmp_path / face), "HOME")
        for face in FACES
    ]
    assert said[1] == said[0]
    assert "[package.one/b][FAILURE]" in said[0]
