"""rostest and rosunit by pyros1, in programs of tests as users write them."""

from __future__ import annotations

import os
import stat
import subprocess
import sys
from pathlib import Path

import pytest
from programs import environment, run

UNIT = """
import sys, unittest
import rosunit
class TestThing(unittest.TestCase):
    def test_sum(self):
        for number in range(3):
            with self.subTest(number=number):
                self.assertLess(number, {limit})
rosunit.unitrun("my_package", "test_thing", TestThing)
print("the end")
"""


@pytest.mark.parametrize(("limit", "code"), [(3, 0), (2, 1)])
def test_a_unit_test(environ: dict[str, str], limit: int, code: int) -> None:
    out = run(UNIT.format(limit=limit), environ, code=code)
    assert ("the end" in out) == (code == 0)
    assert f" * FAILURES: {code}" in out
    results = Path(environ["ROS_HOME"]) / "test_results" / "my_package" / "rosunit-test_thing.xml"
    assert f'failures="{code}"' in results.read_text()


OLD_TEST = """
import unittest
for name in ("assert_", "assertEquals", "failUnless", "assertItemsEqual"):
    if hasattr(unittest.TestCase, name):
        delattr(unittest.TestCase, name)  # as Python 3.12 and newer ones do
import rosunit
class TestThing(unittest.TestCase):
    def test_sum(self):
        self.assertEquals(4, 2 + 2)
        self.assert_(True)
        self.assertRaises(AssertionError, self.failUnless, False)
        assert not hasattr(self, "assertItemsEqual")  # stock with Python 3 had it neither
rosunit.unitrun("my_package", "test_thing", TestThing)
"""


def test_names_that_newer_pythons_have_removed_from_unittest(environ: dict[str, str]) -> None:
    assert " * FAILURES: 0" in run(OLD_TEST, environ)


PROGRAM = """#!{python}
import sys, unittest
import rospy, rostest
from std_msgs.msg import String
class TestTalker(unittest.TestCase):
    def test_it_talks(self):
        rospy.init_node("test_talker")
        publisher = rospy.Publisher("chatter", String, queue_size=1, latch=True)
        publisher.publish("hello")
        self.assertEqual(rospy.wait_for_message("chatter", String, 20).data, rospy.get_param("/expected"))
        while not rostest.is_publisher("/chatter", rospy.get_name()):
            rospy.sleep(0.01)
if __name__ == "__main__":
    rostest.rosrun("talker_tests", "test_talker", TestTalker, sys.argv)
"""
LAUNCH = """<launch>
  <param name="expected" value="{expected}"/>
  <test test-name="talker" pkg="talker_tests" type="test_talker.py" time-limit="40"/>
</launch>
"""


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="scripts with #!")
@pytest.mark.parametrize(("expected", "code"), [("hello", 0), ("other", 2)])
def test_a_program_of_a_launch_file(environ: dict[str, str], tmp_path: Path, expected: str, code: int) -> None:
    package = tmp_path / "talker_tests"
    package.mkdir()
    (package / "package.xml").write_text("<package><name>talker_tests</name><version>1.0.0</version></package>")
    program = package / "test_talker.py"
    program.write_text(PROGRAM.format(python=sys.executable))
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    launch = package / "talker.test"
    launch.write_text(LAUNCH.format(expected=expected))
    done = subprocess.run(
        [sys.executable, "-m", "pyros1", "test", str(launch)],
        env={**environment(environ), "ROS_PACKAGE_PATH": str(tmp_path), "PATH": os.environ["PATH"]},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
        stdin=subprocess.DEVNULL,
    )
    assert done.returncode == code, done.stdout + done.stderr
    assert "rosunit-talker/test_it_talks]" in done.stdout
    assert " * TESTS: 1" in done.stdout


MISSING = """
import rosunit.baretest
try:
    rosunit.baretest.BareTestCase
except AttributeError as error:
    print(error)
"""


def test_what_is_not_there_says_so(environ: dict[str, str]) -> None:
    assert "pyros1 has no rosunit.baretest.BareTestCase" in run(MISSING, environ)
