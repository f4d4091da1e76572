"""Launching from a program (X93).

Feature: launching from programs -- `pyros1.launch.scripting`
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import ExitPolicy
from pyros1.launch.scripting import (
    Node,
    ROSLaunch,
    ROSLaunchParent,
    configure_logging,
    get_or_generate_uuid,
    resolve_launch_arguments,
)
from pyros1.net.master_client import MasterClient

SOURCES = Path(__file__).resolve().parents[2] / "src"
DEADLINE = 30.0
PACKAGE = "<package format='2'><name>scripted</name></package>"
RUN = """#!/bin/sh
trap 'exit 0' INT
touch "$ROS_HOME/began$1"
[ "$1" = fail ] && exit 3
while :; do sleep 0.05; done
"""
FILE = """<launch><arg name="what" default="stay"/><param name="$(arg what)_p" value="1"/>
<node pkg="scripted" type="run" name="$(arg what)" args="$(arg what)"/></launch>"""


class Listener:
    """Remembers what it hears."""

    def __init__(self) -> None:
        self.heard: list[tuple[str, int | None]] = []
        self.news = threading.Event()

    def process_died(self, process_name: str, exit_code: int | None) -> None:
        self.heard.append((process_name, exit_code))
        self.news.set()


@pytest.fixture
def uri(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, environ: dict[str, str]) -> Iterator[str]:
    """A running master."""
    folder = tmp_path / "scripted"
    folder.mkdir()
    (folder / "package.xml").write_text(PACKAGE)
    (folder / "run").write_text(RUN)
    (folder / "run").chmod(0o755)
    (folder / "a.launch").write_text(FILE)
    for name, value in {
        **environ,
        "ROS_HOME": str(tmp_path / "home"),
        "ROS_LOG_DIR": str(tmp_path / "log"),
        "ROS_PACKAGE_PATH": str(folder),
        "ROS_HOSTNAME": "localhost",
    }.items():
        monkeypatch.setenv(name, value)
    yield environ["ROS_MASTER_URI"]


def test_nodes_one_by_one(uri: str) -> None:
    launch = ROSLaunch()
    launch.start()
    try:
        process = launch.launch(Node("scripted", "run", name="a", namespace="/deep", args="stay 'two words'"))
        assert process.is_alive() and process.pid > 0 and process.name == "deep/a-1" and process.exit_code is None
        launch.spin_once()
        process.stop()
        assert not process.is_alive() and process.exit_code is not None
        other = launch.launch(Node("scripted", "run"))
        assert other.is_alive() and other.name == "run-2"
        with pytest.raises(LaunchError, match="Cannot locate node of type"):
            launch.launch(Node("scripted", "none"))
    finally:
        launch.stop()
    assert not other.is_alive()
    launch.stop()
    with pytest.raises(LaunchError, match="over"):
        launch.launch(Node("scripted", "run"))


def test_a_node_gets_the_environment_of_the_moment(uri: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "scripted" / "tell").write_text('#!/bin/sh\necho "$SETTING" > "$ROS_HOME/told"\n')
    (tmp_path / "scripted" / "tell").chmod(0o755)
    launch = ROSLaunch()
    launch.start()
    try:
        monkeypatch.setenv("SETTING", "later")
        process = launch.launch(Node("scripted", "tell"))
        deadline = time.monotonic() + DEADLINE
        while process.is_alive():
            assert time.monotonic() < deadline
            launch.spin_once()
    finally:
        launch.stop()
    assert (tmp_path / "home" / "told").read_text() == "later\n"


def test_files_with_arguments_and_a_listener(uri: str, tmp_path: Path) -> None:
    run_id = get_or_generate_uuid(None, False)
    assert Path(configure_logging(run_id)) == tmp_path / "log" / run_id
    (file,) = resolve_launch_arguments(["scripted", "a.launch", "what:=else"])
    listener = Listener()
    parent = ROSLaunchParent(run_id, [file, (file, ["what:=fail"])], process_listeners=[listener], force_log=True)
    with pytest.raises(LaunchError):
        parent.spin()
    parent.start()
    try:
        client = MasterClient("/test", uri)
        assert client.get_param("/run_id") == run_id == get_or_generate_uuid(None, True)
        assert (client.get_param("/stay_p"), client.get_param("/fail_p")) == (1, 1)
        client.close()
        assert listener.news.wait(DEADLINE)
        assert listener.heard == [("fail-2", 3)]
        parent.spin_once()
    finally:
        parent.shutdown()
    parent.spin()


def test_a_launch_ends_with_its_last_process(uri: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    file = str(tmp_path / "scripted" / "a.launch")
    for verbose in (False, True):
        parent = ROSLaunchParent(None, [(file, ["what:=fail"])], verbose=verbose, is_rostest=True)
        parent.start()
        parent.spin()
        parent.shutdown()
        node = "Added node of type [scripted/run] in namespace [/]"
        told = f"... loading XML file [{file}]\nAdded parameter [/fail_p]\n{node}\n"
        assert (told in capfd.readouterr().out) is verbose


def test_what_cannot_be_started_is_an_error(uri: str, tmp_path: Path) -> None:
    with pytest.raises(LaunchError, match="cannot read"):
        ROSLaunchParent(None, ["/no/such.launch"]).start()
    with pytest.raises(LaunchError, match="already running"):
        ROSLaunchParent(None, [], is_core=True).start()
    with pytest.raises(LaunchError, match="not been started"):
        ROSLaunch().launch(Node("scripted", "run"))
    with pytest.raises(LaunchError, match="does not match"):
        client = MasterClient("/test", uri)
        client.set_param("/run_id", "theirs")
        client.close()
        ROSLaunchParent("mine", [str(tmp_path / "scripted" / "a.launch")]).start()


def test_a_script_without_interpreter_is_said_to_be_that(
    uri: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "scripted" / "run").write_text("import sys\n")
    parent = ROSLaunchParent(None, [str(tmp_path / "scripted" / "a.launch")])
    parent.start()
    parent.shutdown()
    said = capfd.readouterr().err
    assert "cannot launch node of type [scripted/run]: cannot run " in said
    assert "its first line does not name an interpreter: add #!/usr/bin/env python3\n  at " in said


@pytest.mark.parametrize(
    "arguments",
    [{"package": ""}, {"machine_name": "m"}, {"output": "both"}, {"cwd": "/tmp"}, {"args": "'"}, {"respawn": "often"}],
)
def test_what_makes_no_node(arguments: dict[str, str]) -> None:
    with pytest.raises(LaunchError):
        Node(**{"package": "p", "node_type": "t", **arguments})  # type: ignore[arg-type]


def test_arguments_of_a_node() -> None:
    words = ("a 'b c'", "true", 2.0, [("x", "y")], [("A", "b")], "screen", "node", "nice -n 1")
    plan = Node("p", "dir/t.py", None, "n", None, *words).plan
    assert (plan.full_name, plan.args, plan.exit_policy) == ("/n/t", ["a", "b c"], ExitPolicy(True, 2.0))
    assert (plan.remappings, plan.env, plan.prefix) == ([("x", "y")], {"A": "b"}, ["nice", "-n", "1"])
    assert (plan.output, plan.cwd) == ("screen", "node")


PROGRAM = """
import sys
import time
from pyros1.launch.scripting import Node, ROSLaunch
launch = ROSLaunch()
launch.start()
process = launch.launch(Node("scripted", "run", name="a"))
try:
    print("pid", process.pid, flush=True)
    if sys.argv[1] == "spin":
        launch.spin()
except KeyboardInterrupt:  # it may come before spin() is there
    pass
"""


@pytest.mark.parametrize("way", ["spin", "end"])
def test_a_program_that_ends_leaves_nothing_behind(uri: str, way: str) -> None:
    env = {**os.environ, "PYTHONPATH": str(SOURCES)}
    with subprocess.Popen([sys.executable, "-c", PROGRAM, way], env=env, stdout=subprocess.PIPE, text=True) as program:
        assert program.stdout is not None
        pid = next(int(line.split()[1]) for line in program.stdout if line.startswith("pid "))
        if way == "spin":
            program.send_signal(signal.SIGINT)
        rest = program.stdout.read()
    assert program.returncode == 0 and rest.endswith("done\n")
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_no_master_no_run_id(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:1")
    assert get_or_generate_uuid(None, False) != get_or_generate_uuid(None, False)
    assert get_or_generate_uuid("given", True) == "given"
