# ruff: noqa: E501 - tables and programs in one line
"""Real child processes: start, death, respawn, required, and an end that comes (X87-X90)."""

from __future__ import annotations

import io
import os
import queue
import signal
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import ExitPolicy
from pyros1.launch.running.console import Console
from pyros1.launch.running.process import Process
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.screen import Screen
from pyros1.launch.running.supervisor import Supervisor, install_signals
from pyros1.launch.running.watchdog import is_leaderless

DEADLINE = 20.0
LATE = "import signal, sys, time; signal.signal(2, lambda *_: (time.sleep(0.1), sys.exit())); print('ready', flush=True); signal.pause()"
FORKS = "import os, signal\nif not os.fork(): print('ready', flush=True)\nsignal.pause()"
STUBBORN = "import signal; signal.signal(2, signal.SIG_IGN); signal.signal(15, signal.SIG_IGN); print('ready', flush=True); signal.pause()"


class Output(io.StringIO):
    """What was said, which can be waited for."""

    def __init__(self) -> None:
        super().__init__()
        self._said = threading.Condition()

    def write(self, text: str) -> int:
        with self._said:
            self._said.notify_all()
            return super().write(text)

    def wait_for(self, text: str, count: int) -> None:
        """Wait until a text was said that often."""
        with self._said:
            assert self._said.wait_for(lambda: self.getvalue().count(text) >= count, DEADLINE), self.getvalue()


class Bench:
    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.out, self.err = Output(), io.StringIO()
        self.supervisor = Supervisor(Console(self.out, self.err), sigint_timeout=0.2, sigterm_timeout=0.2)

    def spec(
        self, label: str, code: str, *, respawn: bool = False, required: bool = False, delay: float = 0.0
    ) -> ProcessSpec:
        words = [sys.executable, "-c", code]
        base = str(self.folder / label)
        policy = ExitPolicy(respawn, delay, required)
        return ProcessSpec(label, f"/{label}", words, dict(os.environ), str(self.folder), base, False, policy)

    def log(self, label: str) -> str:
        return (self.folder / f"{label}-stdout.log").read_text()

    def wait_for_log(self, label: str, text: str) -> None:
        deadline = time.monotonic() + DEADLINE
        while not (self.folder / f"{label}-stdout.log").exists() or text not in self.log(label):
            assert time.monotonic() < deadline, f"{label} did not say {text}"
            time.sleep(0.01)


@pytest.fixture
def bench(tmp_path: Path) -> Iterator[Bench]:
    bench = Bench(tmp_path)
    yield bench
    bench.supervisor.shut_down()
    assert not any(process.alive for process in bench.supervisor.dead)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("watch ")]


def test_all_dead_ends_the_run_x87_x89(bench: Bench) -> None:
    assert bench.supervisor.start(bench.spec("good-1", "print('hello')"))
    assert bench.supervisor.start(bench.spec("bad-2", "raise SystemExit(3)"))
    assert bench.supervisor.run() == "all processes on machine have died, roslaunch will exit"
    assert "process[good-1]: started with pid [" in bench.out.getvalue()
    assert f"[good-1] process has finished cleanly\nlog file: {bench.folder / 'good-1'}*.log" in bench.out.getvalue()
    assert "[bad-2] process has died [pid " in bench.err.getvalue()
    assert ", exit code 3, cmd " in bench.err.getvalue()
    assert bench.log("good-1") == "hello\n"


def test_required_ends_the_run_x88(bench: Bench) -> None:
    bench.supervisor.start(bench.spec("other-1", "import signal; signal.pause()"))
    bench.supervisor.start(bench.spec("needed-2", "", required=True))
    assert bench.supervisor.run() == "required process died"
    assert "REQUIRED process [needed-2] has died!\nInitiating shutdown!" in bench.err.getvalue()


def test_a_process_that_is_to_be_respawned_is_not_kept_from_it_by_its_end(bench: Bench) -> None:
    supervisor = bench.supervisor
    supervisor.start(bench.spec("again-1", "", respawn=True, delay=0.2))
    (process,) = supervisor.active
    supervisor.on_process_exit = lambda _: supervisor.call_soon(lambda: supervisor.end_node(process))
    runner = threading.Thread(target=supervisor.run)
    runner.start()
    try:
        bench.out.wait_for("restarting process", 2)
    finally:
        supervisor.stop()
        runner.join(10)


def test_respawn_appends_to_the_log_x85_x88(bench: Bench) -> None:
    counter = bench.folder / "count"
    code = f"p = {str(counter)!r}; open(p, 'a').write('x'); n = len(open(p).read()); print('life', n, flush=True); import signal; n > 2 and signal.pause()"
    bench.supervisor.start(bench.spec("again-1", code, respawn=True, delay=0.01))
    runner = threading.Thread(target=bench.supervisor.run)
    runner.start()
    bench.wait_for_log("again-1", "life 3")
    bench.supervisor.stop("enough")
    runner.join(DEADLINE)
    assert not runner.is_alive()
    assert bench.log("again-1") == "life 1\nlife 2\nlife 3\n"
    assert bench.out.getvalue().count("[again-1] restarting process") == 2
    assert bench.supervisor.active[0].spawn_count == 3


def test_a_node_starts_again_once_its_delay_is_over_x88(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    now = [100.0]
    monkeypatch.setattr("pyros1.launch.running.supervisor.time", SimpleNamespace(monotonic=lambda: now[0]))
    supervisor = bench.supervisor
    supervisor.on_process_exit = lambda process: supervisor.stop("it has died")
    supervisor.start(bench.spec("again-1", "exit(3)", respawn=True, delay=60.0))
    assert supervisor.run() == "it has died"
    for now[0], starts in ((159.9, 1), (160.0, 2)):
        supervisor.stop_after(0.0, "the timers that are due have run")
        supervisor.run()
        assert supervisor.active[0].spawn_count == starts


@pytest.mark.slow
def test_escalation_reaches_the_stuck_in_reverse_order_x90(bench: Bench) -> None:
    # A polite process has enough time to end even on a machine that is busy.
    bench.supervisor = Supervisor(Console(bench.out, bench.err), sigint_timeout=2.0, sigterm_timeout=0.2)
    bench.supervisor.start(bench.spec("polite-1", "import signal; print('ready', flush=True); signal.pause()"))
    bench.supervisor.start(bench.spec("stuck-2", STUBBORN))
    bench.wait_for_log("polite-1", "ready")
    bench.wait_for_log("stuck-2", "ready")
    bench.supervisor.shut_down()
    lines = [line for line in bench.out.getvalue().splitlines() if "started with" not in line]
    assert lines == [
        "[stuck-2] killing on exit",
        "[polite-1] killing on exit",
        "[stuck-2] escalating to SIGTERM",
        "[stuck-2] escalating to SIGKILL",
    ]
    assert {process.spec.label: process.exit_code for process in bench.supervisor.dead}["stuck-2"] == -9


def test_a_required_failure_is_remembered(bench: Bench) -> None:
    bench.supervisor.start(bench.spec("needed-1", "raise SystemExit(7)", required=True))
    bench.supervisor.run()
    assert bench.supervisor.required_failed


def test_the_end_of_a_node_is_answered(bench: Bench) -> None:
    spec = bench.spec("controller-1", "raise SystemExit(7)")
    spec.on_death_spec = bench.spec("stop-1", "print('braked')")
    bench.supervisor.start(spec)
    bench.supervisor.run()
    assert bench.log("stop-1") == "braked\n"
    assert "[controller-1] on-death: " in bench.out.getvalue()


def test_the_end_of_a_required_node_is_answered_before_everything_ends(bench: Bench) -> None:
    spec = bench.spec("controller-1", "raise SystemExit(7)", required=True)
    spec.on_death_spec = bench.spec("stop-1", "import time; time.sleep(0.2); print('braked')")
    spec.on_death_spec.ends_launch = True
    bench.supervisor.start(bench.spec("other-2", "import signal; signal.pause()"))
    bench.supervisor.start(spec)
    assert bench.supervisor.run() == "required process died"
    assert bench.log("stop-1") == "braked\n" and bench.supervisor.required_failed


def test_an_answer_that_never_ends_does_not_keep_a_launch(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.launch.running.supervisor.ON_DEATH_TIMEOUT", 0.05)
    spec = bench.spec("controller-1", "", required=True)
    spec.on_death_spec = bench.spec("stop-1", "import signal; signal.pause()")
    bench.supervisor.start(spec)
    assert bench.supervisor.run() == "required process died"


def test_an_answer_is_not_cut_short_by_the_next_end(bench: Bench, tmp_path: Path) -> None:
    """A node that dies again and again would never be answered."""
    deaths = tmp_path / "deaths"
    spec = bench.spec("controller-1", f"open({str(deaths)!r}, 'a').write('x')", respawn=True)
    wait = f"d = {str(deaths)!r}; n = len(open(d).read())\nwhile len(open(d).read()) < n + 3: pass"
    spec.on_death_spec = bench.spec("stop-1", f"{wait}\nprint('braked', flush=True)")
    bench.supervisor.start(spec)
    with Running(bench):
        bench.wait_for_log("stop-1", "braked")


def test_each_end_of_a_node_is_answered(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    """Also one that comes while the answer to the last one still runs: it is made once more, but not without end."""
    monkeypatch.setattr("pyros1.launch.running.supervisor.ON_DEATH_TIMEOUT", 0.1)
    spec = bench.spec("controller-1", "print('up')", respawn=True)
    spec.on_death_spec = bench.spec("stop-1", "import signal; print('braked', flush=True); signal.pause()")
    bench.supervisor.start(spec)
    with Running(bench):
        bench.out.wait_for("[stop-1] stopping", 2)
        bench.out.wait_for("[stop-1] restarting process", 1)


def test_a_node_that_was_told_to_end_is_not_answered(bench: Bench) -> None:
    spec = bench.spec("controller-1", LATE)
    spec.on_death_spec = bench.spec("stop-1", "")
    bench.supervisor.start(spec)
    bench.wait_for_log("controller-1", "ready")
    node = bench.supervisor.find("controller-1")
    with Running(bench) as running:
        running.do(lambda: bench.supervisor.stop_node(node), "[controller-1] stopped")
    assert "on-death" not in bench.out.getvalue()


def test_an_answer_that_cannot_start_does_not_keep_a_launch(bench: Bench) -> None:
    spec = bench.spec("controller-1", "", required=True)
    spec.on_death_spec = bench.spec("stop-1", "")
    spec.on_death_spec.words = ["/nowhere/brake"]
    bench.supervisor.start(spec)
    assert bench.supervisor.run() == "required process died"
    assert "cannot start [stop-1]: No such file or directory: /nowhere/brake" in bench.err.getvalue()


def test_what_a_node_leaves_behind_ends_with_the_launch(bench: Bench) -> None:
    leave = "import os, signal\nif os.fork(): os._exit(0)\nsignal.signal(2, signal.SIG_IGN); print('left', flush=True); signal.pause()"
    bench.supervisor.start(bench.spec("parent-1", leave))
    bench.wait_for_log("parent-1", "left")
    bench.supervisor.run()
    (parent,) = bench.supervisor.dead
    assert not parent.is_gone
    bench.supervisor.shut_down()
    assert parent.is_gone
    assert "[parent-1] escalating to SIGTERM" in bench.out.getvalue()


def test_a_second_signal_hurries_x90(bench: Bench) -> None:
    bench.supervisor = Supervisor(Console(bench.out, bench.err), sigint_timeout=1000.0, sigterm_timeout=1000.0)
    bench.supervisor.start(bench.spec("stuck-1", STUBBORN))
    bench.wait_for_log("stuck-1", "ready")
    bench.supervisor.stop("SIGINT")
    bench.supervisor.stop_waiting()
    bench.supervisor.stop_waiting()
    assert bench.supervisor.run() == "SIGINT"
    bench.supervisor.shut_down()
    (stuck,) = bench.supervisor.dead
    assert stuck.exit_code == -9


def test_asking_twice_for_the_end_is_not_hurrying(bench: Bench) -> None:
    """A master that is told to shut down, and then a signal: the nodes keep the time that they have."""
    bench.supervisor = Supervisor(Console(bench.out, bench.err), sigint_timeout=DEADLINE, sigterm_timeout=DEADLINE)
    bench.supervisor.start(bench.spec("late-1", LATE))
    bench.wait_for_log("late-1", "ready")
    bench.supervisor.stop("shutdown")
    bench.supervisor.stop("SIGINT")
    assert bench.supervisor.run() == "shutdown"
    bench.supervisor.shut_down()
    assert "escalating" not in bench.out.getvalue()


def test_signals_that_come_together_are_one_x90(bench: Bench) -> None:
    """``timeout -s INT`` sends two, to the launcher and to its group."""
    came: list[str] = []
    restore = install_signals(came.append, lambda: came.append("hurry"))
    try:
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGTERM)
    finally:
        restore()
    assert came == ["SIGINT"]


def test_a_signal_that_comes_just_before_a_wait_is_noticed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python runs its handler after the wait, which must have an end."""
    waits: list[float | None] = []

    class Events(queue.SimpleQueue):  # type: ignore[type-arg]  # of the supervisor
        def get(self, block: bool = True, timeout: float | None = None) -> Any:
            waits.append(timeout)
            if len(waits) == 1:
                self.put(("stop", "a signal"))
                raise queue.Empty
            return super().get(block, timeout)

    monkeypatch.setattr("pyros1.launch.running.supervisor.queue.SimpleQueue", Events)
    supervisor = Bench(tmp_path).supervisor
    supervisor.keep_running = True
    assert supervisor.run() == "a signal"
    assert all(wait is not None and wait < 1 for wait in waits)


def test_a_life_ends_while_what_another_left_is_looked_at(bench: Bench, monkeypatch: pytest.MonkeyPatch) -> None:
    ended = threading.Semaphore(0)
    process = Process(bench.spec("forks-1", FORKS), lambda process: ended.release())

    def end(said: str) -> None:
        bench.wait_for_log("forks-1", said)
        os.kill(process.pid, signal.SIGKILL)
        assert ended.acquire(timeout=DEADLINE) and not process.alive

    process.start()
    end("ready\n")
    process.start()

    def look(group: int) -> bool:
        if process.alive:
            end("ready\nready\n")
        return is_leaderless(group)

    monkeypatch.setattr("pyros1.launch.running.process.is_leaderless", look)
    process.signal(0)
    assert not process.alive and not process.is_gone
    process.kill()  # reaches what both have left
    deadline = time.monotonic() + DEADLINE
    while not process.is_gone:
        assert time.monotonic() < deadline
        time.sleep(0.01)
    process.join()


class Running:
    """A supervisor that runs in a thread, as users find it who control a launch."""

    def __init__(self, bench: Bench) -> None:
        self.bench = bench
        self.thread = threading.Thread(target=bench.supervisor.run)

    def __enter__(self) -> Running:
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.bench.supervisor.stop()
        self.thread.join(DEADLINE)
        assert not self.thread.is_alive()

    def do(self, action: Callable[[], object], said: str) -> None:
        before = self.bench.out.getvalue().count(said)
        self.bench.supervisor.call_soon(action)
        self.bench.out.wait_for(said, before + 1)
        over = threading.Event()  # it was said in the middle of what is done; this comes after it
        self.bench.supervisor.call_soon(over.set)
        assert over.wait(DEADLINE)


def test_nodes_are_stopped_started_and_restarted_by_hand(bench: Bench) -> None:
    supervisor = bench.supervisor
    supervisor.start(bench.spec("node-1", STUBBORN, respawn=True, required=False))
    bench.wait_for_log("node-1", "ready")
    node = supervisor.find("/node-1")
    with Running(bench) as running:
        running.do(lambda: supervisor.stop_node(node), "[node-1] stopped")
        assert node.stopped_by_user and not node.alive and node.spawn_count == 1
        running.do(lambda: supervisor.start_node(node), "process[node-1]: started with pid")
        assert node.alive and node.spawn_count == 2
        running.do(lambda: supervisor.restart_node(node), "process[node-1]: started with pid")
        assert node.alive and node.spawn_count == 3
        assert supervisor.active == [node]
    assert "has died" not in bench.err.getvalue()


def test_a_required_node_may_be_stopped_by_hand(bench: Bench) -> None:
    bench.supervisor.start(bench.spec("node-1", "import signal; signal.pause()", required=True))
    node = bench.supervisor.find("node-1")
    with Running(bench) as running:
        running.do(lambda: bench.supervisor.stop_node(node), "[node-1] stopped")
        assert running.thread.is_alive()
    with pytest.raises(LaunchError, match="no node"):
        bench.supervisor.find("/other")


def test_the_news_of_an_end_is_old_when_it_runs_again(bench: Bench) -> None:
    first = bench.folder / "was here"
    code = f"import pathlib, signal; here = pathlib.Path({str(first)!r}); here.exists() or (here.touch(), exit(3)); signal.pause()"
    bench.supervisor.start(bench.spec("node-1", code, required=True))
    node = bench.supervisor.find("node-1")
    assert node.wait(time.monotonic() + DEADLINE)
    bench.supervisor.restart_node(node)  # before anybody has heard of its end
    with Running(bench) as running:
        running.do(lambda: bench.supervisor.stop_node(node), "[node-1] stopped")
        assert running.thread.is_alive() and node.spawn_count == 2
    assert "REQUIRED" not in bench.err.getvalue()


def test_a_node_that_is_still_ending_is_started_again(bench: Bench) -> None:
    bench.supervisor.start(bench.spec("node-1", STUBBORN))
    bench.wait_for_log("node-1", "ready")
    node = bench.supervisor.find("node-1")
    with Running(bench) as running:
        running.do(lambda: bench.supervisor.stop_node(node), "[node-1] stopping")
        running.do(lambda: bench.supervisor.start_node(node), "[node-1] restarting process")
        assert node.spawn_count == 2 and not node.stopped_by_user
    assert "[node-1] stopped" not in bench.out.getvalue()


def test_a_node_that_waits_for_its_next_start_is_stopped(bench: Bench) -> None:
    bench.supervisor.start(bench.spec("node-1", "exit(3)", respawn=True, delay=60.0))
    node = bench.supervisor.find("node-1")
    assert node.wait(time.monotonic() + DEADLINE)
    with Running(bench) as running:
        bench.supervisor.call_soon(lambda: bench.supervisor.stop_node(node))
        running.do(lambda: bench.supervisor.start_node(node), "process[node-1]: started with pid")
        assert node.spawn_count == 2


def test_what_cannot_be_started_is_said(bench: Bench) -> None:
    spec = bench.spec("none-1", "")
    spec.words = ["/no/such/program"]
    assert not bench.supervisor.start(spec)
    assert "cannot start [none-1]: No such file or directory: /no/such/program" in bench.err.getvalue()
    assert bench.supervisor.run().startswith("all processes")


@pytest.mark.skipif(not hasattr(os, "waitid"), reason="the system cannot wait without taking the exit code")
def test_that_it_was_started_is_said_before_what_it_says(bench: Bench) -> None:
    class Slow(Console):
        def bold(self, text: str) -> None:
            if "started with pid" in text:
                pid = int(text.rsplit("[", 1)[1].rstrip("]"))
                os.waitid(os.P_PID, pid, os.WEXITED | os.WNOWAIT)  # it has said everything
            super().bold(text)

    screen = Screen(bench.out, bench.err)
    supervisor = Supervisor(Slow(bench.out, bench.err), screen=screen)
    counter = bench.folder / "count"
    code = f"p = {str(counter)!r}; open(p, 'a').write('x'); n = len(open(p).read()); print('life', n)"
    spec = bench.spec("again-1", code, respawn=True)
    spec.to_screen = True

    def enough(process: Process) -> None:
        if process.spawn_count == 3:
            supervisor.stop("enough")

    supervisor.on_process_exit = enough
    supervisor.start(spec)
    assert supervisor.run() == "enough"
    supervisor.shut_down()
    screen.close(DEADLINE)
    said = [line for line in bench.out.getvalue().splitlines() if "started with pid" in line or "life" in line]
    assert [line.split(" [")[0].split("] ")[-1] for line in said] == [
        word for life in (1, 2, 3) for word in ("process[again-1]: started with pid", f"life {life}")
    ]


@pytest.mark.skipif(not hasattr(os, "SCHED_FIFO"), reason="only Linux has real-time priorities")
@pytest.mark.parametrize("permitted", [True, False])
def test_a_real_time_priority(bench: Bench, monkeypatch: pytest.MonkeyPatch, permitted: bool) -> None:
    asked = []

    def set_scheduler(thread: int, policy: int, param: os.sched_param) -> None:
        if not permitted:
            raise PermissionError(1, "Operation not permitted")
        asked.append((thread, policy, param.sched_priority))

    monkeypatch.setattr(os, "sched_setscheduler", set_scheduler)
    assert bench.supervisor.start(replace(bench.spec("fast-1", "import signal; signal.pause()"), priority=50))
    (process,) = bench.supervisor.active
    assert asked == ([(process.pid, os.SCHED_FIFO, 50)] if permitted else [])
    assert ("[fast-1] cannot get real-time priority 50: the system does not" in bench.err.getvalue()) != permitted
    assert bench.supervisor.start(bench.spec("usual-2", "import signal; signal.pause()")) and len(asked) <= 1
