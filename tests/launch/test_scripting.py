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
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import ExitPolicy, Plan
from pyros1.launch.reading.system_resources import make_resources
from pyros1.launch.running.options import Options
from pyros1.launch.script_run import ScriptRun
from pyros1.launch.scripting import (
    Node,
    ROSLaunch,
    ROSLaunchParent,
    configure_logging,
    get_or_generate_uuid,
    resolve_launch_arguments,
)
from pyros1.master.server import Master
from pyros1.net.master_client import MasterClient

SOURCES = Path(__file__).resolve().parents[2] / "src"
DEADLINE = 30.0
PACKAGE = "<package format='2'><name>scripted</name></package>"
RUN = """#!/bin/sh
trap 'exit 0' INT
touch "$ROS_HOME/began$1"
echo "$1 began"
[ "$1" = fail ] && exit 3
while :; do sleep 0.05; done
"""
FILE = """<launch><arg name="what" default="stay"/><arg name="output" default="log"/>
<param name="$(arg what)_p" value="1"/>
<node pkg="scripted" type="run" name="$(arg what)" args="$(arg what)" output="$(arg output)"/></launch>"""


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
    for verbose, output in ((False, "screen"), (True, "log")):
        words = ["what:=fail", f"output:={output}"]
        parent = ROSLaunchParent(
            None, [(file, words)], verbose=verbose, is_rostest=True, force_screen=verbose, force_log=not verbose
        )
        parent.start()
        parent.spin()
        parent.shutdown()
        node = "Added node of type [scripted/run] in namespace [/]"
        told = f"... loading XML file [{file}]\nAdded parameter [/fail_p]\n{node}\n"
        said = capfd.readouterr().out
        assert (told in said) is verbose
        assert ("fail began\n" in said) is verbose, "the output goes where the launch says, not the file"


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


def test_a_launch_is_started_once(uri: str) -> None:
    launch = ROSLaunch()
    launch.start()
    try:
        with pytest.raises(LaunchError, match="this launch was already started"):
            launch.start()
    finally:
        launch.stop()


def test_files_are_added_before_the_start_or_given_as_texts(uri: str, tmp_path: Path) -> None:
    one = ROSLaunch()
    one.load(str(tmp_path / "scripted" / "a.launch"))
    one.load((str(tmp_path / "scripted" / "a.launch"), ["what:=other"]))
    texts = [FILE.replace("$(arg what)", name) for name in ("text1", "text2")]
    client = MasterClient("/test", uri)
    try:
        for launch in (one, ROSLaunchParent(None, [], roslaunch_strs=texts)):
            launch.start()
            (launch.parent if isinstance(launch, ROSLaunch) else launch).shutdown()
        assert {"stay_p", "other_p", "text1_p", "text2_p"} <= set(client.get_param("/"))
    finally:
        client.close()


def test_ctrl_c_ends_a_launch_that_is_waited_for(uri: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ScriptRun, "wait", lambda run, timeout: signal.raise_signal(signal.SIGINT))
    launch = ROSLaunch()
    launch.start()
    process = launch.launch(Node("scripted", "run"))
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        launch.spin()
    finally:
        signal.signal(signal.SIGINT, before)
    assert not process.is_alive()


def test_a_node_that_is_ended_may_start_again_but_not_one_that_is_stopped(uri: str) -> None:
    launch = ROSLaunch()
    launch.start()
    try:
        process = launch.launch(Node("scripted", "run", respawn=True))
        first, errors = process.pid, []
        process.end(errors)
        deadline = time.monotonic() + DEADLINE
        while process.spawn_count == 1 or not process.is_alive():
            assert time.monotonic() < deadline
            time.sleep(0.01)
        assert process.pid != first
        process.stop(errors)
        assert (process.is_alive(), process.spawn_count, errors) == (False, 2, [])
    finally:
        launch.stop()


def test_a_listener_may_add_nodes_and_its_errors_do_no_harm(uri: str, capfd: pytest.CaptureFixture[str]) -> None:
    """It is called in the thread of the launch, which must not wait for itself."""

    class Successor(Listener):
        def process_died(self, process_name: str, exit_code: int | None) -> None:
            super().process_died(process_name, exit_code)
            if exit_code == 3:
                self.next = parent.launch(Node("scripted", "run", name="next"))
                self.next.stop()
                assert self.next.pid > 0
                parent.shutdown()
                raise ValueError("a fault in the program")

    listener = Successor()
    parent = ROSLaunchParent(None, [], process_listeners=[listener])
    parent.start(auto_terminate=False)
    parent.launch(Node("scripted", "run", name="a", args="fail"))
    parent.spin()
    assert ("a-1", 3) in listener.heard and not listener.next.is_alive()
    said = capfd.readouterr()
    assert "process_died of " in said.err and "ValueError('a fault in the program')" in said.err


def test_the_processes_of_a_launch_are_listed(uri: str) -> None:
    run = ScriptRun(Plan(), Options(keep_running=True), [], make_resources())
    run.start()
    try:
        assert run.server_uri.startswith("http://localhost:")
        one, other = (run.launch(Node("scripted", "run", name=name)) for name in "ab")
        one.stop()
        assert [each.name for each in run.processes()] == ["a-1", "b-2"] and run.dead_processes() == []
        assert [each.is_alive() for each in run.processes()] == [False, True] and not run.is_over()
    finally:
        run.stop()
    assert run.is_over() and run.server_uri == ""
    assert not other.is_alive() and run.processes() == [] and [each.name for each in run.dead_processes()]
    other.stop()
    with pytest.raises(LaunchError, match="over"):
        run.launch(Node("scripted", "run"))


def test_the_run_id_of_a_master_can_be_waited_for(
    monkeypatch: pytest.MonkeyPatch, free_port: int, tmp_path: Path
) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", f"http://localhost:{free_port}")
    master = Master(port=free_port, bind_host="127.0.0.1")
    clock = SimpleNamespace(sleep=lambda seconds: master.start())
    monkeypatch.setattr("pyros1.launch.scripting.time", clock)
    try:
        assert get_or_generate_uuid(None, True)
        client = MasterClient("/test", master.uri)
        client.set_param("/run_id", "theirs")
        client.close()
        assert get_or_generate_uuid(None, True) == "theirs"
    finally:
        master.stop()


def test_a_log_folder_that_cannot_be_made_is_said(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path / "file"))
    with pytest.raises(LaunchError, match="cannot create the log folder: Not a directory: "):
        configure_logging("run")


def test_a_process_that_has_been_restarted_has_exited(uri: str) -> None:
    run = ScriptRun(Plan(), Options(keep_running=True), [], make_resources())
    run.start()
    run.stop()
    process: Any = SimpleNamespace(spawn_count=1)

    def is_restarted_meanwhile(deadline: float) -> bool:
        process.spawn_count = 2
        return False

    process.wait = is_restarted_meanwhile
    assert run.end_process(process)
    process.wait = lambda deadline: False
    assert not run.end_process(process)
