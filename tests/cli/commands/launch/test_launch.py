# ruff: noqa: E501 - tables in one line
"""pyros1 launch, core and run as a user types them: real processes, a master of their own on a free port."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pyros1.ground.errors import MasterUnreachableError
from pyros1.net.master_client import MasterClient

pytestmark = pytest.mark.once

SOURCES = Path(__file__).resolve().parents[4] / "src"
TOP_LEVEL = Path(__file__).resolve().parents[4] / "launch"
DEADLINE = 30.0
MAIN = "import sys; from pyros1.cli.running import run_command; sys.exit(run_command('{0}', sys.argv[1:]))"


class Tool:
    """A running command and the lines it has written."""

    def __init__(self, command: str, words: list[str], cwd: Path, env: dict[str, str]) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-c", MAIN.format(command), *words],
            cwd=cwd, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )  # fmt: skip
        self.lines: list[str] = []
        self._news = threading.Condition()
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self.process.stdout is not None
        for line in self.process.stdout:
            with self._news:
                self.lines.append(line.rstrip("\n"))
                self._news.notify_all()

    def wait_for(self, pattern: str) -> str:
        deadline = time.monotonic() + DEADLINE
        with self._news:
            while True:
                alive = self._reader.is_alive()
                for line in self.lines:
                    if re.search(pattern, line):
                        return line
                left = deadline - time.monotonic()
                assert left > 0 and alive, f"no {pattern!r} in:\n" + "\n".join(self.lines)
                self._news.wait(min(left, 0.2))

    def finish(self) -> int:
        return self.process.wait(DEADLINE)

    def end(self, number: int = signal.SIGINT) -> int:
        if self.process.poll() is None:
            self.process.send_signal(number)
        try:
            code = self.process.wait(DEADLINE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = self.process.wait(DEADLINE)
        self._reader.join(DEADLINE)
        assert self.process.stdout is not None
        self.process.stdout.close()
        return code


Start = Callable[..., Tool]


@pytest.fixture
def env(tmp_path: Path, free_port: int) -> dict[str, str]:
    names = ("ROS_LOG_DIR", "ROS_NAMESPACE", "ROS_IP", "ROS_PACKAGE_PATH")
    rest = {name: value for name, value in os.environ.items() if name not in names}
    uri = f"http://localhost:{free_port}"
    home = str(tmp_path / "ros")
    return {**rest, "PYTHONPATH": str(SOURCES), "ROS_HOME": home, "ROS_HOSTNAME": "localhost", "ROS_MASTER_URI": uri}


@pytest.fixture
def start(tmp_path: Path, env: dict[str, str]) -> Iterator[Start]:
    running: list[Tool] = []

    def begin(command: str, *words: str) -> Tool:
        running.append(Tool(command, list(words), tmp_path, env))
        return running[-1]

    yield begin
    for tool in reversed(running):
        tool.end()


@pytest.mark.slow
def test_launch_starts_its_own_master_and_ends_cleanly_x78_x90(
    start: Start, env: dict[str, str], tmp_path: Path
) -> None:
    tool = start("launch", "minimal_nodes.launch", "rate:=50")
    tool.wait_for(r"received value is: 0\.\d{6}")
    master = MasterClient("/test", env["ROS_MASTER_URI"])
    run_id = master.get_param("/run_id")
    assert master.get_param("/rosversion") == "1.16.0\n"
    assert master.get_param("/rosdistro") == "noetic\n"
    assert master.get_param("/minimal_publisher/rate") == 50.0
    (server,) = [name for name in master.get_param_names() if name.startswith("/roslaunch/uris/host_localhost__")]
    assert MasterClient("/test", master.get_param(server)).uri
    assert (tmp_path / "ros" / "log" / "latest").resolve().name == run_id
    master.close()
    assert tool.end() == 0
    pids = [int(match[1]) for line in tool.lines if (match := re.search(r"process\[minimal.*pid \[(\d+)\]", line))]
    assert len(pids) == 2
    for pid in pids:
        with pytest.raises(ProcessLookupError):
            os.kill(pid, 0)
    text = "\n".join(tool.lines)
    order = [
        "... logging to ", "started roslaunch server http://localhost:", "SUMMARY", "PARAMETERS", " * /minimal_publisher/rate: 50.0", "NODES",
        "    minimal_publisher (minimal_nodes/minimal_publisher)", "auto-starting new master", "process[master]: started with pid [",
        f"ROS_MASTER_URI={env['ROS_MASTER_URI']}", "setting /run_id to ", "process[rosout-1]: started with pid [", "started core service [/rosout]",
        "process[minimal_publisher-2]: started", "process[minimal_subscriber-3]: started", "[minimal_subscriber-3] killing on exit",
        "[minimal_publisher-2] killing on exit", "[rosout-1] killing on exit", "[master] killing on exit", "shutting down processing monitor...",
        "... shutting down processing monitor complete", "done",
    ]  # fmt: skip
    places = [text.index(part) for part in order]
    assert places == sorted(places)


@pytest.mark.slow
def test_core_is_used_by_a_launch_and_refuses_a_second_one_l15_l18(
    start: Start, env: dict[str, str], tmp_path: Path
) -> None:
    core = start("core")
    core.wait_for("started core service")
    port = env["ROS_MASTER_URI"].rpartition(":")[2]
    assert (tmp_path / "ros" / f"roscore-{port}.pid").read_text() == str(core.process.pid)
    second = start("core")
    second.wait_for("RLException: roscore cannot run as another roscore/master is already running")
    assert second.finish() == 1
    tool = start("launch", "minimal_nodes", "minimal_nodes.launch", "rate:=50")
    tool.wait_for("received value is")
    assert not [line for line in tool.lines if "auto-starting" in line]
    assert tool.end(signal.SIGTERM) == 0
    assert core.end() == 0
    assert core.lines[-1] == "done"
    client = MasterClient("/test", env["ROS_MASTER_URI"])
    with pytest.raises(MasterUnreachableError):
        client.get_pid()
    client.close()


@pytest.mark.slow
def test_without_nodes_and_with_dead_ones_x89(start: Start, env: dict[str, str], tmp_path: Path) -> None:
    package = tmp_path / "brief"
    package.mkdir()
    (package / "package.xml").write_text("<package><name>brief</name></package>")
    (package / "end").write_text("#!/bin/sh\n")
    (package / "end").chmod(0o755)
    env["ROS_PACKAGE_PATH"] = str(package)
    (tmp_path / "empty.launch").write_text('<launch><param name="p" value="1"/></launch>')
    (tmp_path / "brief.launch").write_text('<launch><node pkg="brief" type="end" name="it"/></launch>')
    core = start("launch", "brief.launch")  # its own master keeps it alive
    core.wait_for(r"\[it-2\] process has finished cleanly")
    empty = start("launch", "empty.launch")
    empty.wait_for("shutting down processing monitor complete")
    assert empty.finish() == 0
    assert "No processes to monitor" in empty.lines and "done" not in empty.lines
    brief = start("launch", "brief.launch")
    brief.wait_for("^all processes on machine have died, roslaunch will exit$")
    brief.wait_for("^done$")
    assert brief.finish() == 0 and core.process.poll() is None
    assert core.end() == 0 and not any("have died" in line for line in core.lines)


def ask(env: dict[str, str], cwd: Path, command: str, *words: str, stdin: str = "") -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, "-c", MAIN.format(command), *words],
        cwd=cwd, env=env, input=stdin, capture_output=True, text=True, timeout=DEADLINE, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout, done.stderr


@pytest.mark.slow
def test_queries_need_no_master_x06(env: dict[str, str], tmp_path: Path) -> None:
    assert ask(env, tmp_path, "launch", "--nodes", "minimal_nodes.launch")[:2] == (
        0,
        "/minimal_publisher\n/minimal_subscriber\n",
    )
    assert (
        ask(
            env,
            tmp_path,
            "launch",
            "--dump-params",
            "-",
            "v:=7",
            stdin='<launch><arg name="v"/><param name="p" value="$(arg v)"/></launch>',
        )[1]
        == "/p: 7\n\n"
    )
    code, out, _ = ask(env, tmp_path, "launch", "--files", str(TOP_LEVEL / "minimal_simulator.launch"))
    assert code == 0
    assert [Path(line).parts[-3:] for line in out.splitlines()] == [
        (TOP_LEVEL.parent.name, "launch", "minimal_simulator.launch"),
        ("minimal_nodes", "launch", "minimal_simulator.launch"),
    ]
    assert "rate (default" in ask(env, tmp_path, "launch", "--ros-args", str(TOP_LEVEL / "minimal_nodes.launch"))[1]
    assert (
        "__name:=minimal_controller"
        in ask(env, tmp_path, "launch", "--args=minimal_controller", "minimal_simulator.launch")[1]
    )


@pytest.mark.slow
@pytest.mark.parametrize(
    ("words", "code", "text"),
    [
        ([], 2, "you must specify at least one input file"), (["nope.launch"], 1, "RLException: [nope.launch] is not a launch file name"),
        (["nopkg", "nope.launch"], 1, "[nope.launch] is neither a launch file in package [nopkg] nor is [nopkg] a launch file name"),
        (["-", "-"], 2, "Only a single instance"), (["--nodes", "--ros-args", "minimal_nodes.launch"], 2, "only one of"),
        (["--find-node=/x", "minimal_nodes.launch"], 0, "Cannot find node named [/x]"), (["--args=/x", "minimal_nodes.launch"], 1, " * /minimal_publisher"),
        (["--core", "minimal_nodes.launch"], 2, "not allowed in core mode"),
        (["minimal_nodes.launch", "rate=5"], 1, "; 'rate=5' is neither a remapping nor a parameter: write rate:=5"),
        (["minimal_nodes", "minimal_nodes.launch", "rate:5"], 2, "do not exist: rate:5\n'rate:5' is neither a remapping nor a parameter: write rate:=5"),
        (["minimal_nodes", "minimal_nodes.launch", "\u2013screen"], 2, "begins with a typographic dash, not with '-': write --screen"),
        (["minimal_nodes", "minimal_noeds.launch"], 1, " (did you mean 'minimal_nodes.launch'?); package [minimal_nodes] has "),
        (["minimal_nodes"], 1, "[minimal_nodes] is not a launch file name; package [minimal_nodes] has "),
    ],
)  # fmt: skip
def test_errors_x05(env: dict[str, str], tmp_path: Path, words: list[str], code: int, text: str) -> None:
    done, out, err = ask(env, tmp_path, "launch", *words)
    assert (done, out) == (code, "")
    assert text in err
    assert "Traceback" not in err


@pytest.mark.slow
def test_a_master_elsewhere_is_not_started_here_x80(env: dict[str, str], tmp_path: Path) -> None:
    env["ROS_MASTER_URI"] = "http://192.0.2.1:1"
    (tmp_path / "e.launch").write_text("<launch/>")
    env["ROS_MASTER_URI"] = "http://no-such-host.invalid:11311"
    code, _, err = ask(env, tmp_path, "launch", "e.launch")
    assert code == 1
    assert "RLException: unable to contact ROS master at [http://no-such-host.invalid:11311]: the host name" in err
    assert "cannot be resolved here" in err and "add a line 'ADDRESS no-such-host.invalid' to /etc/hosts" in err


@pytest.mark.slow
@pytest.mark.parametrize(
    "words", [["launch", "--nodes", "minimal_nodes.launch"], ["launch", "--help"], ["launch", "--tree", "minimal_nodes.launch"], ["core", "--help"], ["run", "-h"], ["help"]]
)  # fmt: skip
def test_a_reader_that_has_gone_is_no_error(env: dict[str, str], tmp_path: Path, words: list[str]) -> None:
    without_a_reader(env, tmp_path, *words)


@pytest.mark.parametrize("words", [["topic", "list"], ["node", "list"], ["param", "get", "/p"]])
def test_a_reader_that_has_gone_is_no_error_for_others(
    env: dict[str, str], environ: dict[str, str], tmp_path: Path, words: list[str]
) -> None:
    master = MasterClient("/test", environ["ROS_MASTER_URI"])
    master.set_param("/p", 1)
    master.close()
    without_a_reader({**env, **environ}, tmp_path, *words)


def without_a_reader(env: dict[str, str], cwd: Path, *words: str) -> None:
    """Run a command whose output nobody reads; it must end well all the same."""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        done = subprocess.run(
            [sys.executable, "-m", "pyros1", *words],
            cwd=cwd, env=env, stdin=subprocess.DEVNULL, stdout=writer, stderr=subprocess.PIPE, text=True, timeout=DEADLINE, check=False,
        )  # fmt: skip
    finally:
        os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.slow
@pytest.mark.parametrize("command", ["core", "run", "launch"])
def test_help_names_our_commands_and_gives_examples(env: dict[str, str], tmp_path: Path, command: str) -> None:
    code, out, err = ask(env, tmp_path, command, "--help")
    assert (code, err) == (0, "")
    assert out.startswith(f"Usage: pyros1 {command} ")
    examples = out.partition("\nExamples:\n")[2].splitlines()
    assert 2 <= len(examples) <= 4 and all(line.startswith(f"  pyros1 {command}") for line in examples)
    assert not re.search(rf"\bros{command}\b", out) and "%prog" not in out
    code, _, err = ask(env, tmp_path, command, "--no-such-option") if command != "run" else (2, "", "")
    assert code == 2 and f"ros{command}:" not in err


def test_a_question_imports_no_more_than_it_needs(env: dict[str, str], tmp_path: Path) -> None:
    words = [sys.executable, "-X", "importtime", "-m", "pyros1", "launch", "--nodes", "minimal_nodes.launch"]
    done = subprocess.run(words, cwd=tmp_path, env=env, capture_output=True, text=True, timeout=DEADLINE, check=True)
    loaded = {line.rpartition("|")[2].strip() for line in done.stderr.splitlines()}
    assert "pyros1.launch.reading.loader" in loaded
    for name in (
        "pyros1.launch.reading.drawing",
        "pyros1.launch.running.session",
        "pyros1.node",
        "pyros1.master",
        "pyros1.net",
        "socket",
        "subprocess",
        "asyncio",
        "yaml",
    ):
        assert name not in loaded
