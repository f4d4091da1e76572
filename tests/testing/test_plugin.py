"""The fixtures for users' tests, used as users use them. pytest finds them through pyros1's entry point.

Feature: pytest fixtures: a master, nodes, programs, waiting for messages -- no test needs to sleep
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.finding.python_modules import DROP_IN_START
from pyros1.guide.documents import pages
from pyros1.master.server import Master
from pyros1.testing import Heard, Program

pytest_plugins = ["pytester"]
Listen = Callable[[str, Any], Heard[Any]]
FLOAT = "std_msgs/Float64"
SOURCE = str(Path(pyros1.__file__).parents[1])


def test_the_environment_leads_to_the_master(ros_master: Master, tmp_path: Path) -> None:
    assert os.environ["ROS_MASTER_URI"] == ros_master.uri
    with pyros1.Node("plain", argv=[], handle_signals=False) as node:
        assert node.uri.startswith("http://127.0.0.1:")
        node.log.info("a line")
    assert list((tmp_path / "ros").rglob("plain*.log"))


def test_messages_are_taken_in_their_order(ros_node: Callable[..., Any], ros_listen: Listen) -> None:
    heard = ros_listen("/a", FLOAT)
    publisher = ros_node("source").advertise("/a", FLOAT, latch=True)
    publisher.publish(data=0.0)
    assert heard.next().data == 0.0
    assert publisher.wait_for_subscribers(1, 10)
    for number in range(1, 6):
        publisher.publish(data=float(number))
    assert [message.data for message in heard.wait(3)] == [1.0, 2.0, 3.0]
    assert heard.first(lambda message: message.data > 4).data == 5.0
    assert [message.data for message in heard.wait(2)] == [4.0, 5.0]
    assert heard.count == 6
    assert [message.data for message in heard.messages] == [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    heard.nothing(0.01)
    heard.clear()
    assert heard.messages == []


def test_a_message_that_does_not_come_is_told_with_what_is_known(
    ros_node: Callable[..., Any], ros_listen: Listen
) -> None:
    heard = ros_listen("/a", FLOAT)
    with pytest.raises(
        AssertionError, match=r"0 of 1 messages arrived within 0\.01 s\. /a: no node publishes this topic"
    ):
        heard.next(timeout=0.01)
    publisher = ros_node("source").advertise("/a", FLOAT)
    assert publisher.wait_for_subscribers(1, 10)
    with pytest.raises(AssertionError, match=re.escape("/a: connected to 1 publisher(s), which sent nothing.")):
        heard.first(timeout=0.01)
    publisher.publish(data=7.0)
    heard.next()
    with pytest.raises(AssertionError, match=r"1 messages arrived in total, the last one:\ndata: 7.0"):
        heard.first(lambda message: message.data > 7, timeout=0.01)


def test_a_message_that_should_not_come(ros_node: Callable[..., Any], ros_listen: Listen) -> None:
    publisher = ros_node("source").advertise("/a", FLOAT, latch=True)
    heard = ros_listen("/a", FLOAT)
    publisher.publish(data=1.0)
    with pytest.raises(AssertionError, match="an unexpected message arrived"):
        heard.nothing(10)


def test_only_the_newest_are_kept(
    ros_node: Callable[..., Any], ros_listen: Listen, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.testing.heard.MAX_MESSAGES", 3)
    heard = ros_listen("/a", FLOAT)
    publisher = ros_node("source").advertise("/a", FLOAT, queue_size=0)
    assert publisher.wait_for_subscribers(1, 10)
    for number in range(5):
        publisher.publish(data=float(number))
    heard.first(lambda message: message.data == 4.0)
    with pytest.raises(AssertionError, match="2 messages of /a were discarded: only the newest 3 are kept"):
        heard.wait(5)
    assert [message.data for message in heard.messages] == [2.0, 3.0, 4.0]


def test_a_program_of_a_package_runs_as_long_as_the_test(ros_run: Callable[..., Program], ros_listen: Listen) -> None:
    program = ros_run("minimal_nodes", "minimal_publisher", "topic1:=/other")
    assert ros_listen("/other", FLOAT).next(timeout=60).data > 0
    assert program.running
    assert program.stop() == program.wait()
    assert not program.running


@pytest.mark.slow
def test_a_launch_file(ros_launch: Callable[..., Program], ros_listen: Listen, tmp_path: Path) -> None:
    file = tmp_path / "a.launch"
    file.write_text('<launch><node pkg="minimal_nodes" type="minimal_publisher" name="source"/></launch>')
    program = ros_launch(file)
    ros_listen("/topic1", FLOAT).next(timeout=60)
    program.wait_for(r"process\[source-\d+\]: started with pid", timeout=60)


def test_output_is_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.testing.programs.MAX_OUTPUT", 1000)
    program = Program([sys.executable, "-c", "print('one'); print('two' * 1000); print('three')"], os.environ)
    assert program.wait_for("^three$", 60)
    assert program.wait(60) == 0
    assert len(program.output) == 1000
    with pytest.raises(AssertionError, match="exited without printing 'four', but:\n"):
        program.wait_for("four", 60)
    assert program.stop() == 0


def test_a_program_that_does_not_end_is_ended_with_its_children(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.testing.programs.STOP_TIMEOUTS", (0.01, 0.01, 60.0))
    code = """
        import os, signal, sys, time
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        os.write(1, b"%d" % os.fork() + os.linesep.encode())  # in one piece
        time.sleep(1000)
    """
    program = Program([sys.executable, "-c", textwrap.dedent(code)], os.environ)
    program.wait_for(r"^[1-9]\d*$", 60)
    with pytest.raises(AssertionError, match=r"did not print within 0\.01 s 'never'"):
        program.wait_for("never", 0.01)
    with pytest.raises(AssertionError, match=r"is still running after 0\.01 s"):
        program.wait(0.01)
    assert program.stop() == -9
    with pytest.raises(AssertionError, match="exited without printing 'never'"):  # the child had the pipe, too
        program.wait_for("never", 60)


@pytest.mark.slow
def test_the_tests_of_the_page_and_how_one_that_fails_is_shown(pytester: pytest.Pytester) -> None:
    (program,) = pages()["tests"].code("python")
    fails = "def test_it(ros_listen): ros_listen('/nobody', 'std_msgs/String').next(timeout=0.01)"
    pytester.makepyfile(test_page=program, test_fails=fails)
    result = pytester.runpytest_subprocess("-p", "no:cacheprovider", timeout=120)
    result.assert_outcomes(passed=2, failed=1)
    result.stdout.fnmatch_lines(["*AssertionError: 0 of 1 messages arrived*/nobody: no node publishes this topic*"])


def test_pytest_loads_the_entry_point_without_importing_pyros1() -> None:
    code = "import sys, pyros1_pytest; assert not [each for each in sys.modules if each.partition('.')[0] == 'pyros1']"
    around = {**os.environ, "PYTHONPATH": SOURCE, "PYROS1_ROSPY": "stock"}
    subprocess.run([sys.executable, "-c", code], env=around, check=True, timeout=60)


@pytest.mark.slow
@pytest.mark.parametrize("rospy", ["", "pyros1"])
def test_projects_that_make_warnings_errors_are_tested_with_our_modules_on_the_path(tmp_path: Path, rospy: str) -> None:
    """The finder imports pyros1 before pytest looks for asserts to rewrite in all packages that have plugins."""
    installed = tmp_path / "installed"
    metadata = installed / "ours-1.0.dist-info"
    metadata.mkdir(parents=True)
    (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: ours\nVersion: 1.0\n")
    (metadata / "RECORD").write_text("pyros1/__init__.py,,\npyros1/testing/heard.py,,\npyros1_pytest.py,,\n")
    (metadata / "entry_points.txt").write_text("[pytest11]\npyros1 = pyros1_pytest\n")
    project = tmp_path / "project"
    project.mkdir()
    (project / "pytest.ini").write_text("[pytest]\nfilterwarnings = error\n")
    (project / "test_it.py").write_text(
        "import rospy\n\ndef test_it(ros_master):\n    assert rospy.Duration(1).secs == 1\n"
    )
    path = os.pathsep.join([DROP_IN_START, str(installed), SOURCE])
    around = {**os.environ, "PYTHONPATH": path, "PYROS1_ROSPY": rospy}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "no:hypothesispytest"]
    done = subprocess.run(command, cwd=project, env=around, capture_output=True, text=True, timeout=90, check=False)
    assert done.returncode == 0 and "1 passed" in done.stdout, done.stdout + done.stderr
