"""Tests of launch files are run, tried again, timed and reported (L186, X33-X35)."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

from pyros1.finding.packages import PackageIndex, enclosing_package
from pyros1.launch.plan import Plan, TestPlan
from pyros1.launch.testing.junit import Case, Results, read_results, summary, write_results
from pyros1.launch.testing.tests import TestRun, name_from_path, results_folder
from pyros1.master.server import Master
from pyros1.net.master_client import MasterClient

PACKAGE = """<package format="2"><name>tested</name><version>1.0.0</version><description>Tests.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
# A test writes what it is told to, to where the launcher wants it.
TEST = """#!/bin/sh
count=$(cat "$ROS_HOME/count" 2>/dev/null || echo 0); count=$((count + 1)); echo $count > "$ROS_HOME/count"
echo "$@" > "$ROS_HOME/words"
for word; do case $word in --gtest_output=xml:*) file=${word#--gtest_output=xml:};; esac; done
good='<testsuite><testcase name="a" classname="c" time="0.5"/></testsuite>'
bad='<testsuites><testsuite><testcase name="a"><failure message="wrong"/></testcase></testsuite></testsuites>'
case $1 in
  good) echo "$good" > "$file";;
  bad) echo "$bad" > "$file"; exit 1;;
  later) if [ $count -gt 1 ]; then echo "$good"; else echo "$bad"; fi > "$file";;
  broken) echo "<testsuite" > "$file";;
  hang) sleep 1000;;
  stuck) trap '' INT TERM; echo up > "$ROS_HOME/up"; while :; do sleep 1000; done;;
esac
"""

Run = Callable[..., TestRun]
Make = Callable[..., TestRun]


@pytest.fixture
def make(tmp_path: Path, master: Master) -> Make:
    """Return a function that makes a run of tests; the master that runs is only used if that is asked for."""
    package = tmp_path / "tested"
    package.mkdir()
    (package / "package.xml").write_text(PACKAGE)
    (package / "check").write_text(TEST)
    (package / "check").chmod(0o755)
    environ = {
        **os.environ,
        "ROS_PACKAGE_PATH": str(package),
        "ROS_HOME": str(tmp_path / "home"),
        "ROS_HOSTNAME": "localhost",
        "ROS_MASTER_URI": master.uri,
    }

    def make(*tests: TestPlan, **options: bool) -> TestRun:
        folder = results_folder(environ)
        return TestRun(Plan(tests=list(tests)), PackageIndex(environ), environ, "tested", folder, **options)

    return make


def plan(*args: str, name: str = "it", kind: str = "check", limit: float = 60.0, retry: int = 0) -> TestPlan:
    return TestPlan("tested", kind, name, args=list(args), test_name=name, time_limit=limit, retry=retry)


@pytest.fixture
def run(make: Make) -> Run:
    def run(*args: str, name: str = "it", kind: str = "check", limit: float = 60.0, retry: int = 0) -> TestRun:
        runner = make(plan(*args, name=name, kind=kind, limit=limit, retry=retry))
        runner.run()
        return runner

    return run


def test_a_good_test(run: Run, tmp_path: Path) -> None:
    done = run("good")
    assert [(case.name, case.failures, case.errors) for case in done.runs.cases] == [("testit", [], [])]
    assert done.results.cases == [Case("tested.rosunit-it/a", "c", 0.5)]
    assert (tmp_path / "home" / "test_results" / "tested" / "rosunit-it.xml").exists()
    assert "process[it-2]: started with pid" in done.out.getvalue()


def test_a_test_that_finds_a_failure_has_run(run: Run) -> None:
    done = run("bad")
    assert not done.runs.failures and not done.runs.errors
    assert done.results.failures == 1 and done.results.cases[0].failures == [("", "wrong")]


def test_retries_end_with_the_first_success(run: Run, tmp_path: Path) -> None:
    done = run("later", retry=5)
    assert (done.results.failures, len(done.results.cases)) == (0, 1)
    assert (tmp_path / "home" / "count").read_text().strip() == "2"
    assert "Retries left: 4" in done.out.getvalue()


def test_what_does_not_end_is_ended(run: Run, tmp_path: Path) -> None:
    done = run("hang", limit=0.3, retry=1)
    ((_, text),) = done.runs.cases[0].errors
    assert "max time [0.3s] allotted for test [it] of type [tested/check]" in text
    assert (tmp_path / "home" / "count").read_text().strip() == "2"


@pytest.mark.parametrize(
    ("kind", "args", "text"),
    [("check", ["nothing"], "did not generate test results"), ("none", [], "does not exist or is not executable")],
)
def test_what_does_not_run_is_a_failure(run: Run, kind: str, args: list[str], text: str) -> None:
    done = run(*args, kind=kind)
    assert text in done.runs.cases[0].failures[0][1]


def test_results_that_cannot_be_read_are_an_error(run: Run) -> None:
    assert run("broken").results.errors == 1


def test_results_are_read_as_they_were_written(tmp_path: Path) -> None:
    cases = [Case("a", "c", 0.5), Case("b", "c", 1.0, [("F", "<x> & 'y'")], [("E", "bad\x00byte")])]
    write_results(tmp_path / "r.xml", "suite", Results(cases), "out \x1b[1m", "err")
    found = read_results(tmp_path / "r.xml", "s")
    assert [case.name for case in found.cases] == ["s/a", "s/b"]
    assert found.cases[1].failures == [("F", "<x> & 'y'")] and found.cases[1].errors == [("E", "bad\ufffdbyte")]


def test_the_summary_counts_both_kinds() -> None:
    text = summary(Results([Case("testx", failures=[("", "no")])]), Results([Case("a"), Case("b", errors=[("", "e")])]))
    assert "[a][passed]\n" in text and "[b][ERROR]---" in text and "[testx][failed]\n" in text
    assert " * TESTS: 2\n" in text and " * ERRORS: 1\033" in text and " * FAILURES: 1\033" in text
    assert text.endswith("ERROR: The following tests failed to run:\n * testx\n")
    assert "RESULT: SUCCESS" in summary(Results(), Results([Case("a")]))


def test_names_come_from_paths(tmp_path: Path) -> None:
    (tmp_path / "package.xml").write_text(PACKAGE)
    file = tmp_path / "test" / "deep" / "my.file.test"
    assert enclosing_package(file) == (tmp_path.resolve(), "tested")
    assert name_from_path(tmp_path, file) == "test_deep_my.file"


def test_tests_of_one_name_are_not_run(make: Make, tmp_path: Path) -> None:
    done = make(plan("good"), plan("bad"))
    done.run()
    ((_, text),) = done.runs.cases[0].failures
    assert text == "Duplicate tests named [it] in rostest suite" and f"[ROSTEST]{text}\n" in done.err.getvalue()
    assert not (tmp_path / "home" / "count").exists()


def test_results_that_have_no_place_are_an_error(run: Run, tmp_path: Path) -> None:
    (tmp_path / "home").mkdir()
    (tmp_path / "home" / "test_results").touch()
    ((kind, text),) = run("good").runs.cases[0].errors
    folder = tmp_path / "home" / "test_results" / "tested"
    assert (kind, text) == ("LaunchError", f"cannot create test results directory [{folder}]: Not a directory")


def test_a_test_that_writes_to_the_screen_needs_no_results(make: Make, tmp_path: Path) -> None:
    done = make(plan("nothing"), text=True)
    done.run()
    assert not done.runs.failures and not done.runs.errors and not done.results.cases
    assert " --text " in (tmp_path / "home" / "words").read_text()


@pytest.mark.parametrize("clear", [False, True])
def test_the_running_master_can_be_used(make: Make, master: Master, clear: bool) -> None:
    client = MasterClient("/test", master.uri)
    try:
        client.set_param("/old", 1)
        client.set_param("/run_id", "theirs")
        done = make(plan("good"), reuse_master=True, clear=clear)
        done.run()
        assert done.results.cases and not done.results.failures
        assert "process[it-1]: started with pid" in done.out.getvalue()  # no rosout before it
        assert client.has_param("/old") is not clear and client.get_param("/run_id") == "theirs"
    finally:
        client.close()


def test_a_master_that_is_to_be_used_must_run(make: Make, master: Master) -> None:
    master.stop()
    done = make(plan("good"), reuse_master=True)
    done.run()
    ((kind, _),) = done.runs.cases[0].errors
    assert kind == "MasterUnreachableError"


def test_a_run_that_is_interrupted_runs_no_more_tests(make: Make, tmp_path: Path) -> None:
    """The test that is running is stopped like a node; a test that ignores that is killed after more signals."""
    (tmp_path / "home").mkdir()
    os.mkfifo(tmp_path / "home" / "up")
    runner = make(plan("stuck", retry=3), plan("good", name="later"))
    runner.stop_waiting()  # nothing runs yet

    def interrupt() -> None:
        (tmp_path / "home" / "up").read_text()
        runner.stop("SIGINT")
        for _ in range(2):
            runner.stop_waiting()

    thread = threading.Thread(target=interrupt)
    thread.start()
    runner.run()
    thread.join()
    (case,) = runner.runs.cases
    assert case.errors == [("LaunchError", "test [it] was interrupted")]
    assert "[it-2] escalating to SIGKILL" in runner.out.getvalue() and "retrying" not in runner.out.getvalue()
    assert (tmp_path / "home" / "count").read_text().strip() == "1"
