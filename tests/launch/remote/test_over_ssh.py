"""Nodes on other machines (X91); a script that runs the command here stands for ssh."""

from __future__ import annotations

import io
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import ExitPolicy, MachinePlan, NodePlan
from pyros1.launch.remote import agent
from pyros1.launch.remote.over_ssh import SSH_VARIABLE, Machine, make_machine, ssh_command
from pyros1.launch.remote.process import RemoteProcess
from pyros1.launch.running.console import Console
from pyros1.launch.running.process import Process
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.supervisor import Supervisor
from pyros1.launch.running.usage import UNKNOWN_USAGE
from pyros1.launch.running.watchdog import group_exists

DEADLINE = 20.0
STAGES = (0.3, 0.3)
PACKAGE = """<package format="2"><name>far</name><version>1.0.0</version><description>Nodes.</description>
<maintainer email="a@example.org">a</maintainer><license>BSD</license></package>"""
NODES = {
    "brief": 'echo "$ROS_NAMESPACE $MARK $@" > "$ROS_HOME/said"; echo out; echo err >&2; printf last; exit 3',
    "polite": 'echo up > "$ROS_HOME/up"; sleep 100',
    "stuck": "trap '' INT TERM; echo up > \"$ROS_HOME/up\"; while :; do sleep 100 & wait; done",
}


@pytest.fixture
def environ(tmp_path: Path) -> dict[str, str]:
    package = tmp_path / "far"
    package.mkdir()
    (package / "package.xml").write_text(PACKAGE)
    for name, text in NODES.items():
        (package / name).write_text(f"#!/bin/sh\n{text}\n")
        (package / name).chmod(0o755)
    ssh = tmp_path / "ssh"
    ssh.write_text('#!/bin/sh\nfor last; do :; done\nexec sh -c "$last"\n')
    ssh.chmod(0o755)
    (tmp_path / "home").mkdir()
    (tmp_path / "bin").mkdir()
    python = tmp_path / "bin" / "python3"
    python.write_text(f'#!/bin/sh\nexec {sys.executable} "$@"\n')
    python.chmod(0o755)
    return {
        **os.environ,
        SSH_VARIABLE: str(ssh),
        "ROS_PACKAGE_PATH": str(package),
        "ROS_HOME": str(tmp_path / "home"),
        "PYTHONPATH": os.pathsep.join(path for path in sys.path if path),
        "PATH": f"{tmp_path / 'bin'}{os.pathsep}{os.environ['PATH']}",
    }


class Bench:
    def __init__(self, environ: dict[str, str]) -> None:
        self.out, self.err = io.StringIO(), io.StringIO()
        self.console = Console(self.out, self.err)
        self.supervisor = Supervisor(self.console, sigint_timeout=STAGES[0], sigterm_timeout=STAGES[1])
        self.machine = Machine(
            MachinePlan("robot", "robot.example"), environ, "http://me:1/", STAGES, self.console, self.back
        )
        self.machine.connect()
        self.machine.wait_ready()

    def back(self, processes: list[Process]) -> None:
        self.supervisor.call_soon(lambda: self.supervisor.resume(processes))

    def start(self, kind: str, *, screen: bool = False, respawn: bool = False, priority: int = 0) -> bool:
        node = NodePlan("far", kind, "it", "/ns/", ["a", "b c"], [("x", "y")], {"MARK": "set"})
        spec = ProcessSpec(
            "ns/it-1", "/ns/it", [f"far/{kind}"], {}, "", to_screen=screen, exit_policy=ExitPolicy(respawn)
        )
        spec.priority = priority
        return self.supervisor.start(spec, self.machine.make_process_factory(node, "run"))

    @property
    def process(self) -> Process:
        return self.supervisor.find("/ns/it")


@pytest.fixture
def bench(environ: dict[str, str]) -> Iterator[Bench]:
    bench = Bench(environ)
    yield bench
    bench.supervisor.shut_down()
    bench.machine.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("machine")]


def until(reached: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + DEADLINE
    while not reached():
        assert time.monotonic() < deadline, what
        time.sleep(0.01)


def test_a_node_gets_its_words_and_its_end_comes_back(
    bench: Bench, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bench.start("brief", screen=True)
    bench.supervisor.run()
    log = tmp_path / "home" / "log" / "run" / "ns-it-1.log"
    said = (tmp_path / "home" / "said").read_text()
    assert said == f"/ns set a b c x:=y __name:=it __log:={log}\n"
    assert "process has died [pid " in bench.err.getvalue() and "exit code 3" in bench.err.getvalue()
    shown = capsys.readouterr()
    assert (shown.out, shown.err) == ("out\nlast", "err\n")


def test_that_it_was_started_is_said_before_what_it_says_and_how_it_ends(capsys: pytest.CaptureFixture[str]) -> None:
    class Quick:
        """A machine that is done before whoever gave the order looks again."""

        is_lost, master_uri, plan = False, "http://me:1/", MachinePlan("robot", "robot.example")

        def send(self, message: dict[str, Any]) -> None:
            assert (message["do"], message["label"], message["priority"]) == ("start", "it-1", 50)
            process.handle_message({"event": "started", "pid": 7})
            process.handle_message({"event": "output", "stream": 1, "text": "hello\n"})
            process.handle_message({"event": "ended", "code": 3})

    process = RemoteProcess(ProcessSpec("it-1", "/it", ["far/brief"], {}, "", priority=50), lambda ended: None)
    process.attach(Quick(), NodePlan("far", "brief", "it", "/"), "run")  # type: ignore[arg-type]
    process.start(lambda started: print("started", started.pid))
    assert capsys.readouterr().out == "started 7\nhello\n"
    assert (process.alive, process.exit_code, process.spawn_count) == (False, 3, 1)


def test_a_start_that_is_confirmed_too_late_is_undone(monkeypatch: pytest.MonkeyPatch, environ: dict[str, str]) -> None:
    """It was told that it could not be started."""
    monkeypatch.setattr("pyros1.launch.remote.process.START_TIMEOUT", 0.01)
    said, out, err = [], io.StringIO(), io.StringIO()
    started: list[RemoteProcess] = []

    class Slow:
        is_lost, master_uri, plan = False, "http://me:1/", MachinePlan("robot", "robot.example")

        def send(self, message: dict[str, Any]) -> None:
            said.append((message["do"], message.get("number")))

    def kind(spec: ProcessSpec, on_exit: Any, watchdog: Any, screen: Any) -> RemoteProcess:
        process = RemoteProcess(spec, on_exit, screen=screen)
        process.attach(Slow(), NodePlan("far", "brief", "it", "/"), "run")  # type: ignore[arg-type]
        started.append(process)
        return process

    supervisor = Supervisor(Console(out, err))
    assert not supervisor.start(ProcessSpec("it-1", "/it", ["far/brief"], {}, ""), kind)
    assert "no answer in time" in err.getvalue()
    started[0].handle_message({"event": "started", "pid": 7})
    started[0].handle_message({"event": "ended", "code": -9})
    assert said == [("start", None), ("signal", signal.SIGKILL)]
    assert not started[0].alive and "started with pid" not in out.getvalue() + err.getvalue()
    assert supervisor.run() == "all processes on machine have died, roslaunch will exit"


def test_output_goes_to_files_over_there(bench: Bench, tmp_path: Path) -> None:
    assert bench.start("brief")
    bench.supervisor.run()
    logs = tmp_path / "home" / "log" / "run"
    assert (logs / "ns-it-1-stdout.log").read_text() == "out\nlast"
    assert (logs / "ns-it-1-stderr.log").read_text() == "err\n"


def test_a_missing_node_is_said(bench: Bench) -> None:
    assert not bench.start("nothing")
    assert "nothing" in bench.err.getvalue()
    assert bench.supervisor.active == []


def test_a_machine_with_neither_pyros1_nor_ros_is_said_to_be_so(environ: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "hidden" / "pyros1").mkdir(parents=True)
    (tmp_path / "hidden" / "pyros1" / "__init__.py").write_text("raise ImportError")
    (tmp_path / "bin" / "sh").symlink_to("/bin/sh")
    bench = Bench({**environ, "PYTHONPATH": str(tmp_path / "hidden"), "PATH": str(tmp_path / "bin")})
    assert not bench.start("brief")
    bench.machine.close()
    assert "neither pyros1 nor stock ROS was found with the machine's python3 and PATH" in bench.err.getvalue()


def test_an_error_over_there_is_shown_with_the_code_here(
    environ: dict[str, str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """The agent was not installed there, but its traceback names the file in which to look for the fault."""
    (tmp_path / "faulty").mkdir()
    (tmp_path / "faulty" / "pyros1").mkdir()
    (tmp_path / "faulty" / "pyros1" / "__init__.py").write_text("1 / 0")
    with pytest.raises(LaunchError, match="see the output of ssh"):
        Bench({**environ, "PYTHONPATH": str(tmp_path / "faulty")})
    said = capfd.readouterr().err
    assert f'File "{agent.__file__}", line ' in said and "ZeroDivisionError" in said


def test_a_stuck_node_is_killed_and_restarted(bench: Bench, tmp_path: Path) -> None:
    assert bench.start("stuck")
    until((tmp_path / "home" / "up").exists, "the node runs")
    first = bench.process.pid
    runner = threading.Thread(target=bench.supervisor.run)
    runner.start()
    process = bench.process
    bench.supervisor.call_soon(lambda: bench.supervisor.restart_node(process))
    until(lambda: process.spawn_count == 2, "it is started again")
    assert process.pid != first
    until(lambda: not group_exists(first), "nothing of the first is left")
    bench.supervisor.stop()
    runner.join(DEADLINE)


def test_a_broken_connection_ends_the_nodes_over_there(opened: list[Any], bench: Bench, tmp_path: Path) -> None:
    assert bench.start("stuck")
    until((tmp_path / "home" / "up").exists, "the node runs")
    process = bench.process
    opened[0].stdin.close()  # all that the other side sees of a connection that breaks
    bench.supervisor.run()
    assert process.exit_code == -signal.SIGKILL
    until(lambda: not group_exists(process.pid), "nothing is left")


def test_a_machine_that_comes_back_gets_its_respawning_nodes_again(
    opened: list[Any], environ: dict[str, str], tmp_path: Path
) -> None:
    bench = Bench(environ)
    assert bench.start("polite", respawn=True)
    until((tmp_path / "home" / "up").exists, "the node runs")
    process = bench.process
    first = process.pid
    runner = threading.Thread(target=bench.supervisor.run)
    runner.start()
    try:
        opened[0].stdin.close()
        until(lambda: process.spawn_count == 2, "it is started again")
        assert process.alive and process.pid != first and not process.is_disconnected
        until(lambda: not group_exists(first), "the first one has ended")
    finally:
        bench.supervisor.stop()
        runner.join(DEADLINE)
        bench.supervisor.shut_down()
        bench.machine.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("machine")]
    assert (
        "ERROR: the connection to machine [robot] (robot.example) was lost, and the nodes on it" in bench.err.getvalue()
    )
    assert "remote[robot] connected to robot.example again" in bench.out.getvalue()


def test_what_a_node_over_there_uses_is_known(bench: Bench, tmp_path: Path) -> None:
    assert bench.start("polite")
    until((tmp_path / "home" / "up").exists, "the node runs")
    usage = bench.process.usage({})
    if Path("/proc/self/stat").exists():
        assert usage.cpu >= 0 and usage.memory > 0
    assert bench.machine.usage("nobody") == (-1.0, -1)


def test_a_password_is_warned_of(environ: dict[str, str]) -> None:
    err = io.StringIO()
    plan = MachinePlan("robot", "robot.example", (("password", "secret"),))
    make_machine(plan, environ, "http://me:1/", STAGES, Console(io.StringIO(), err), list)
    assert "the password of machine [robot] is not used" in err.getvalue() and "secret" not in err.getvalue()


def test_who_cannot_be_reached_is_said_before_anything_runs(environ: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "ssh").write_text("#!/bin/sh\nexit 255\n")
    with pytest.raises(
        LaunchError, match=r"cannot launch nodes on machine \[robot\] \(robot.example\): see the output of ssh"
    ):
        Bench(environ)
    with pytest.raises(LaunchError, match="cannot run"):
        Bench({**environ, SSH_VARIABLE: "/no/such/ssh"})


def test_the_tag_and_the_variable_make_the_command() -> None:
    settings = (("env-loader", "/my env.sh"), ("ssh-port", "2222"), ("user", "me"))
    words = ssh_command(MachinePlan("m", "host", settings), {SSH_VARIABLE: "ssh -F 'my config'"})
    assert words[:3] == ["ssh", "-F", "my config"]
    assert words[-7:-1] == ["-p", "2222", "-l", "me", "--", "host"]
    assert words[-1].startswith("exec sh -c ") and "/my env.sh" in words[-1]
    assert ssh_command(MachinePlan("m", "host"), {})[0] == "ssh"


def test_a_machine_with_stock_ros_only_finds_nodes_with_rosrun(environ: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "hidden" / "pyros1").mkdir(parents=True)
    (tmp_path / "hidden" / "pyros1" / "__init__.py").write_text("raise ImportError")
    find = 'test "$*" = "--prefix echo far brief" || { echo "[rosrun] no such node" >&2; exit 3; }'
    (tmp_path / "bin" / "rosrun").write_text(f"#!/bin/sh\n{find}\necho {tmp_path}/far/brief\n")
    (tmp_path / "bin" / "rosrun").chmod(0o755)
    bench = Bench({**environ, "PYTHONPATH": str(tmp_path / "hidden")})
    assert bench.start("brief")
    bench.supervisor.run()
    assert (tmp_path / "home" / "said").exists()
    assert not bench.start("polite")
    assert "[rosrun] no such node" in bench.err.getvalue()
    bench.machine.close()


def answer(tmp_path: Path, *lines: str) -> Path:
    """Make ssh a program that says these lines and notes what it is sent, until the connection is closed."""
    said = "".join(f"echo '{line}'\n" for line in lines)
    (tmp_path / "ssh").write_text(f"#!/bin/sh\n{said}cat >{tmp_path / 'sent'}\n")
    return tmp_path / "sent"


READY = '{"event": "ready", "pid": 7}'


def test_what_a_login_script_prints_is_shown(
    environ: dict[str, str], tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    answer(tmp_path, "Welcome to robot", "5", '{"event": "output", "label": "of another launch", "text": "x"}', READY)
    Bench(environ).machine.close()
    assert capfd.readouterr().err == "Welcome to robot\n"


def test_the_agent_hears_regularly_that_the_launcher_is_there(
    environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.launch.remote.over_ssh.HEARTBEAT_INTERVAL", 0.001)
    sent = answer(tmp_path, READY)
    machine = Bench(environ).machine
    until(lambda: sent.exists() and sent.read_text().endswith("{}\n{}\n"), "there are heartbeats")
    machine.close()


def test_what_is_not_told_in_time_is_unknown(
    environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.launch.remote.over_ssh.USAGE_TIMEOUT", 0.001)
    answer(tmp_path, READY)
    machine = Bench(environ).machine
    assert machine.usage("it") == UNKNOWN_USAGE
    machine.close()


def test_who_does_not_answer_is_given_up_and_ssh_killed(
    environ: dict[str, str], tmp_path: Path, opened: list[Any]
) -> None:
    (tmp_path / "ssh").write_text("#!/bin/sh\nexec sleep 100\n")
    plan = MachinePlan("robot", "robot.example", (("timeout", "0.01"),))
    machine = make_machine(plan, environ, "http://me:1/", STAGES, Console(io.StringIO(), io.StringIO()), list)
    machine.connect()
    with pytest.raises(LaunchError, match=r"\(robot\.example\): no answer within 0\.01 s"):
        machine.wait_ready()
    assert opened[0].returncode == -signal.SIGKILL


class Commands(dict[str, str]):
    """An environment whose command for ssh is another one at each attempt; the last one stays."""

    def __init__(self, environ: dict[str, str], *commands: str) -> None:
        super().__init__(environ)
        self.commands = list(commands)

    def get(self, key: str, default: Any = None) -> Any:
        if key != SSH_VARIABLE:
            return super().get(key, default)
        return self.commands.pop(0) if len(self.commands) > 1 else self.commands[0]


def test_a_lost_machine_is_tried_again_until_it_is_there(
    opened: list[Any], environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.launch.remote.over_ssh.RECONNECT_DELAYS", (0.001, 0.01))
    answer(tmp_path, READY)
    ssh = environ[SSH_VARIABLE]
    bench = Bench(Commands(environ, ssh, "/no/such/ssh", "false", ssh))
    opened[0].kill()
    until(lambda: "remote[robot] connected to robot.example again" in bench.out.getvalue(), "it is connected again")
    assert bench.err.getvalue().count("was lost") == 1 and not bench.machine.is_lost
    assert [process.args[0] for process in opened] == [ssh, "false", ssh]
    bench.machine.close()


def test_a_lost_machine_is_tried_no_more_after_the_end(
    opened: list[Any], environ: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.launch.remote.over_ssh.RECONNECT_DELAYS", (1000.0, 1000.0))
    answer(tmp_path, READY)
    bench = Bench(environ)
    opened[0].kill()
    until(lambda: "was lost" in bench.err.getvalue(), "the loss is noticed")
    bench.machine.close()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("machine")]
    assert len(opened) == 1


@pytest.mark.parametrize("host", ["localhost", "127.0.0.1"])
def test_a_master_that_means_another_machine_there_is_warned_of(environ: dict[str, str], host: str) -> None:
    err = io.StringIO()
    plan = MachinePlan("robot", "robot.example")
    make_machine(plan, environ, f"http://{host}:11311/", STAGES, Console(io.StringIO(), err), list)
    assert f"get the master URI http://{host}:11311/, which refers to that machine, not to this one" in err.getvalue()


@pytest.mark.skipif(not hasattr(os, "SCHED_FIFO"), reason="only Linux has real-time priorities")
def test_only_the_agent_sets_the_priority_of_its_node(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """A process on this machine may have the same id."""
    asked: list[object] = []
    monkeypatch.setattr(os, "sched_setscheduler", lambda *words: asked.append(words))
    assert bench.start("brief", priority=50)
    bench.supervisor.run()
    assert asked == []
