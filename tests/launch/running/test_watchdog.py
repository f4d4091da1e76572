"""Nodes end even when their launcher is killed, and so do their children (X90)."""

from __future__ import annotations

import io
import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.launch.running.watchdog import (
    Watchdog,
    find_group_leaders,
    group_exists,
    groups_alive,
    is_leaderless,
    main,
    run_on_death_commands,
    stop_groups,
)

DEADLINE = 20.0
LAUNCHER = """
import sys, time
from pyros1.launch.running.console import Console
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.supervisor import Supervisor
supervisor = Supervisor(Console(), sigint_timeout=0.2, sigterm_timeout=0.2, guarded=True)
for number, script in enumerate(sys.argv[1:]):
    words = ["sh", "-c", script, f"__log:=/tmp/no/such/{number}"]
    supervisor.start(ProcessSpec(f"node-{number}", f"/node{number}", words, {"PATH": "/bin:/usr/bin"}, "/"))
supervisor.run()
"""
POLITE = "echo up; exec sleep 100"
FORKING = "sleep 100 & sleep 100 & echo up; wait"
STUCK = "trap '' INT TERM; echo up; while :; do sleep 100; done"
LEAVING = "(trap '' INT; exec sleep 100) & echo up; exit 0"


def wait_gone(group: int) -> None:
    deadline = time.monotonic() + DEADLINE
    while group_exists(group):
        assert time.monotonic() < deadline, f"process group {group} is still there"
        time.sleep(0.01)


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="needs /proc")
def test_killed_launcher_leaves_nothing() -> None:
    scripts = [POLITE, FORKING, STUCK, LEAVING]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    command = [sys.executable, "-c", LAUNCHER, *scripts]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=env) as launcher:
        assert launcher.stdout is not None
        groups, up = [], 0
        while len(groups) < len(scripts) or up < len(scripts):
            line = launcher.stdout.readline()
            assert line, "the launcher has ended"
            up += line == "up\n"
            if "started with pid" in line:
                groups.append(int(line.rpartition("[")[2].rstrip("]\n")))
        launcher.send_signal(signal.SIGKILL)
    for group in groups:
        wait_gone(group)


def test_a_started_but_unreported_process_is_found(opened: list[Any]) -> None:
    mark = f"__log:=/tmp/{os.getpid()}-{time.monotonic_ns()}"
    watchdog = Watchdog(0.2, 0.2)
    (guard,) = opened
    watchdog.expect(mark)
    words = ["sh", "-c", "echo up; sleep 100; :", mark]
    with subprocess.Popen(words, stdout=subprocess.PIPE, start_new_session=True) as node:
        assert node.stdout is not None
        node.stdout.readline()
        assert find_group_leaders(mark) == {node.pid}
        guard.stdin.close()  # as the system does when the launcher is killed
        assert node.wait(DEADLINE) < 0 or node.returncode == 130
    guard.wait(DEADLINE)


def test_released_groups_are_left_alone() -> None:
    watchdog = Watchdog(0.2, 0.2)
    with subprocess.Popen(["sleep", "100"], start_new_session=True) as node:
        watchdog.watch(node.pid)
        watchdog.close()
        assert node.poll() is None
        node.kill()


def test_a_group_is_leaderless_only_without_its_leader() -> None:
    words, pipe = ["sh", "-c", "sleep 100 & echo; read line"], subprocess.PIPE
    with subprocess.Popen(words, stdin=pipe, stdout=pipe, start_new_session=True) as node:
        assert node.stdin is not None and node.stdout is not None
        node.stdout.readline()
        assert not is_leaderless(node.pid)
        node.stdin.close()
        node.wait(DEADLINE)
        assert is_leaderless(node.pid)
        os.killpg(node.pid, signal.SIGKILL)
        wait_gone(node.pid)


def test_the_end_of_a_node_is_answered_after_it_though_the_launcher_is_killed(
    opened: list[Any], tmp_path: Path
) -> None:
    watchdog = Watchdog(0.2, 0.2)
    (guard,) = opened
    path = tmp_path / "what happened"
    end = "trap 'echo end >>$NAME; exit' INT; echo up; while :; do sleep 0.01; done"
    environ = {"PATH": os.environ["PATH"], "NAME": str(path)}
    words = ["sh", "-c", end]
    with subprocess.Popen(words, stdout=subprocess.PIPE, start_new_session=True, env=environ) as node:
        assert node.stdout is not None
        node.stdout.readline()
        for pid in (node.pid, 1 << 30):  # the second one has ended, and was answered
            watchdog.watch(pid, (["sh", "-c", 'echo "$0" >>"$NAME"', f"answer {pid}"], environ, "/"))
        watchdog.report_exit(1 << 30)
        guard.stdin.close()  # as the system does when the launcher is killed
    guard.wait(DEADLINE)
    assert path.read_text().splitlines() == ["end", f"answer {node.pid}"]


@pytest.mark.parametrize(
    ("script", "sigint_time", "code"), [(POLITE, DEADLINE, -signal.SIGINT), (STUCK, 0.0, -signal.SIGKILL)]
)
def test_groups_are_ended_by_one_signal_after_the_other(script: str, sigint_time: float, code: int) -> None:
    with subprocess.Popen(["sh", "-c", script], stdout=subprocess.PIPE, start_new_session=True) as node:
        assert node.stdout is not None
        node.stdout.readline()
        groups = {node.pid, 1 << 30}  # the second one has ended
        stop_groups(groups, [(signal.SIGINT, sigint_time), (signal.SIGKILL, DEADLINE)])
        assert node.wait(DEADLINE) == code
        assert not groups_alive(groups)


def test_commands_run_together_and_what_cannot_run_stops_no_other(tmp_path: Path) -> None:
    """Each of the two needs the other one: they would wait for ever one after the other."""
    os.mkfifo(tmp_path / "pipe")
    environ = {"PATH": os.environ["PATH"], "WORD": "done"}
    read, write = 'read line <pipe; echo "$line" >result', 'echo "$WORD" >pipe'
    commands = [(["sh", "-c", script], environ, str(tmp_path)) for script in (read, write)]
    run_on_death_commands([(["/no/such/command"], environ, "/"), *commands])
    assert (tmp_path / "result").read_text() == "done\n"


def test_a_command_that_does_not_end_is_killed_with_its_children(
    opened: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.launch.running.watchdog.ON_DEATH_TIMEOUT", 0.0)
    run_on_death_commands([(["sh", "-c", "trap '' INT TERM; sleep 100; :"], {"PATH": os.environ["PATH"]}, "/")])
    (command,) = opened
    assert command.wait(DEADLINE) == -signal.SIGKILL
    wait_gone(command.pid)


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="needs SIGSTOP")
def test_lines_stay_whole_when_the_pipe_is_full(opened: list[Any]) -> None:
    """The launcher's threads report ends while it reports a start, with an environment that has no room at once."""
    watchdog = Watchdog(0.2, 0.2)
    (guard,) = opened
    guard.send_signal(signal.SIGSTOP)
    gone, environ = 1 << 30, {"LARGE": "x" * 200_000}
    threads = [threading.Thread(target=watchdog.watch, args=(gone, (["true"], environ, "/")))]
    threads += [threading.Thread(target=lambda: [watchdog.report_exit(gone) for _ in range(500)]) for _ in range(4)]
    for thread in threads:
        thread.start()
    guard.send_signal(signal.SIGCONT)
    for thread in threads:
        thread.join(DEADLINE)
    watchdog.close()
    assert guard.returncode == 0


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="needs SIGSTOP")
def test_a_launch_does_not_wait_for_a_watchdog_that_was_stopped(
    opened: list[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.launch.running.watchdog.RELEASE_TIMEOUT", 0.05)
    watchdog = Watchdog(0.2, 0.2)
    (guard,) = opened
    guard.send_signal(signal.SIGSTOP)
    closing = threading.Thread(target=watchdog.close)
    closing.start()
    closing.join(DEADLINE)
    ended = not closing.is_alive()
    guard.send_signal(signal.SIGCONT)
    closing.join(DEADLINE)
    assert ended and guard.returncode == -signal.SIGKILL


@pytest.fixture
def guard(monkeypatch: pytest.MonkeyPatch) -> Iterator[Callable[..., None]]:
    """The watchdog's program, in this process: reads lines, and then the launcher has ended."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}

    def run(*lines: str) -> None:
        monkeypatch.setattr(sys, "argv", ["watchdog", "0.0", str(DEADLINE)])
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO("".join(f"{line}\n" for line in lines).encode())))
        main()

    yield run
    for number, handler in before.items():
        signal.signal(number, handler)


def start(script: str, *words: str) -> subprocess.Popen[bytes]:
    """Start a script that says when it is ready, in a process group of its own."""
    node = subprocess.Popen(["sh", "-c", script, *words], stdout=subprocess.PIPE, start_new_session=True)
    assert node.stdout is not None
    node.stdout.readline()
    return node


def test_signals_of_the_terminal_do_not_end_the_watchdog(guard: Callable[..., None]) -> None:
    guard()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        assert signal.getsignal(number) == signal.SIG_IGN


def test_the_watchdog_ends_what_was_reported_and_what_was_announced(guard: Callable[..., None]) -> None:
    """Of a node that has ended only a child is left, which ignores SIGINT, as such children of a shell do."""
    mark = f"__log:=/tmp/{os.getpid()}-{time.monotonic_ns()}"
    with start(POLITE) as reported, start("echo up; sleep 100; :", mark) as announced, start(POLITE) as other:
        with start("sleep 100 & echo up; read line <&0; exit 0") as parent:
            parent.wait(DEADLINE)
            guard(f"watch {reported.pid}", f"watch {parent.pid}", f"ended {parent.pid}", f"expect {mark}")
            wait_gone(parent.pid)
        assert reported.wait(DEADLINE) in (-signal.SIGINT, -signal.SIGTERM)
        assert announced.wait(DEADLINE) and other.poll() is None
        other.kill()


def test_a_node_that_was_reported_is_no_more_only_announced(guard: Callable[..., None]) -> None:
    mark = f"__log:=/tmp/{os.getpid()}-{time.monotonic_ns()}"
    with start("echo up; sleep 100; :", mark) as other:
        guard(f"expect {mark}", f"watch {1 << 30}")
        assert other.poll() is None
        os.killpg(other.pid, signal.SIGKILL)


def test_an_id_that_was_used_again_is_not_that_of_a_node(guard: Callable[..., None]) -> None:
    """A process with the id of a node that has ended leads another group."""
    with start(POLITE) as other:
        guard(f"watch {other.pid}", f"ended {other.pid}")
        assert other.poll() is None
        other.kill()


def test_a_released_watchdog_does_nothing(guard: Callable[..., None]) -> None:
    with start(POLITE) as node:
        guard(f"watch {node.pid}", "release ")
        assert node.poll() is None
        node.kill()


def test_the_watchdog_runs_commands_of_the_nodes_that_had_not_ended(guard: Callable[..., None], tmp_path: Path) -> None:
    lines = []
    for pid, name in ((1 << 30, "running"), ((1 << 30) + 1, "ended")):
        command = [["sh", "-c", f"touch {name}"], {"PATH": os.environ["PATH"]}, str(tmp_path)]
        lines += [f"on_death {json.dumps([pid, *command])}", f"watch {pid}"]
    guard(*lines, f"ended {(1 << 30) + 1}")
    assert [path.name for path in tmp_path.iterdir()] == ["running"]
