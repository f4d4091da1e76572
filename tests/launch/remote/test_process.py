"""launch.remote.process: a process on another machine under a supervisor; an object stands for the machine."""

from __future__ import annotations

import io
import signal
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.launch.plan import ExitPolicy, MachinePlan, NodePlan
from pyros1.launch.remote.process import RemoteProcess
from pyros1.launch.running.console import Console
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.screen import Screen
from pyros1.launch.running.supervisor import Supervisor
from pyros1.launch.running.usage import UNKNOWN_USAGE, Usage

STARTED = {"event": "started", "pid": 7}


class Remote:
    """A machine that does at once what it is told, and the launch that tells it."""

    is_lost, master_uri, plan = False, "http://me:1/", MachinePlan("robot", "robot.example")

    def __init__(self) -> None:
        self.said: list[dict[str, Any]] = []
        self.answers: list[dict[str, Any]] = []
        self.out, self.err = io.StringIO(), io.StringIO()
        self.supervisor = Supervisor(Console(self.out, self.err), sigint_timeout=0.01, sigterm_timeout=0.01)
        self.supervisor.keep_running = True
        self.screen: Screen | None = None

    def send(self, message: dict[str, Any]) -> None:
        self.said.append(message)
        if message["do"] == "start":
            self.process.handle_message(self.answers.pop(0) if self.answers else STARTED)

    def usage(self, label: str) -> Usage:
        return Usage(1.5, 100)

    def make(self, spec: ProcessSpec, on_exit: Any, watchdog: Any, screen: Any) -> RemoteProcess:
        self.process = RemoteProcess(spec, on_exit, screen=self.screen)
        self.process.attach(self, NodePlan("far", "brief", "it", "/"), "run")  # type: ignore[arg-type]
        return self.process

    def start(self, **policy: Any) -> bool:
        spec = ProcessSpec("it-1", "/it", ["far/brief"], {}, "", exit_policy=ExitPolicy(**policy))
        return self.supervisor.start(spec, self.make)

    def run(self, *actions: Callable[[], object]) -> None:
        """Do what the thread of the launch does until all these have been called there, one after the other."""
        for action in actions:
            self.supervisor.call_soon(action)
        self.supervisor.stop()
        self.supervisor.run()

    def signals(self) -> list[int]:
        return [message["number"] for message in self.said if message["do"] == "signal"]


@pytest.fixture
def remote() -> Iterator[Remote]:
    remote = Remote()
    yield remote
    remote.process.handle_message({"event": "ended", "code": 0})
    remote.supervisor.shut_down()


def test_nothing_is_asked_of_a_machine_that_is_lost(remote: Remote) -> None:
    remote.is_lost = True
    assert not remote.start()
    assert "cannot start [it-1]: the connection is lost: machine robot" in remote.err.getvalue()
    assert remote.said == [] and remote.process.is_disconnected


def test_a_start_that_is_refused_says_why(remote: Remote) -> None:
    remote.answers = [{"event": "failed", "why": "no such program"}]
    assert not remote.start()
    assert "cannot start [it-1]: no such program: machine robot" in remote.err.getvalue()
    assert not remote.process.alive and remote.process.is_gone and not remote.process.is_disconnected


def test_a_connection_that_breaks_during_a_start(remote: Remote) -> None:
    def send(message: dict[str, Any]) -> None:
        remote.is_lost = True
        remote.process.on_connection_lost()

    remote.send = send  # type: ignore[method-assign]
    assert not remote.start()
    assert "cannot start [it-1]: the connection is lost: machine robot" in remote.err.getvalue()
    assert remote.process.is_disconnected and remote.process.exit_code is None


def test_a_node_that_is_not_to_start_again_ends_with_its_connection(remote: Remote) -> None:
    assert remote.start()
    remote.process.on_connection_lost()
    remote.run()
    assert remote.supervisor.dead == [remote.process] and remote.process.exit_code == 255


def test_a_respawning_node_waits_for_its_machine(remote: Remote) -> None:
    assert remote.start(respawn=True)
    remote.process.on_connection_lost()
    remote.run()
    assert remote.supervisor.active == [remote.process] and not remote.process.alive
    remote.run(lambda: remote.supervisor.start_node(remote.process))
    assert "[it-1] waiting for machine [robot]" in remote.out.getvalue() and remote.process.spawn_count == 1
    remote.run(lambda: remote.supervisor.resume([remote.process]))
    assert remote.process.alive and remote.process.spawn_count == 2


def test_a_node_that_was_stopped_by_hand_stays_so_when_its_machine_is_back(remote: Remote) -> None:
    assert remote.start(respawn=True)
    remote.process.on_connection_lost()
    remote.run(lambda: remote.supervisor.stop_node(remote.process), lambda: remote.supervisor.resume([remote.process]))
    assert not remote.process.alive and not remote.process.is_disconnected


def test_a_node_that_cannot_start_again_is_dead(remote: Remote) -> None:
    assert remote.start(respawn=True)
    remote.answers = [{"event": "failed", "why": "it was uninstalled"}]
    remote.process.on_connection_lost()
    remote.run()
    remote.run(lambda: remote.supervisor.resume([remote.process]))
    assert "cannot start [it-1]: it was uninstalled" in remote.err.getvalue()
    assert (remote.supervisor.active, remote.supervisor.dead) == ([], [remote.process])


def test_a_node_that_does_not_end_is_given_up_after_all_signals(remote: Remote) -> None:
    assert remote.start()
    for _ in range(3):
        remote.supervisor.stop_waiting()
    remote.supervisor.shut_down()
    assert remote.signals() == [signal.SIGINT, signal.SIGTERM, signal.SIGKILL]
    assert "[it-1] required SIGKILL. May still be running." in remote.err.getvalue()


def test_what_it_uses_is_asked_only_while_it_runs(remote: Remote) -> None:
    assert remote.start()
    assert remote.process.usage({}) == Usage(1.5, 100)
    remote.process.handle_message({"event": "ended", "code": 3})
    remote.process.handle_message({"event": "ended", "code": 4})  # as after a connection that broke
    assert remote.process.usage({}) == UNKNOWN_USAGE and remote.process.exit_code == 3
    remote.process.signal(signal.SIGINT)
    assert remote.signals() == []


def test_output_on_the_screen_begins_with_the_name_of_the_node(
    remote: Remote, capsys: pytest.CaptureFixture[str]
) -> None:
    remote.screen = Screen(sys.stdout, sys.stderr)
    assert remote.start()
    for stream, text in ((1, "one\n"), (2, "two\n")):
        remote.process.handle_message({"event": "output", "stream": stream, "text": text})
    assert capsys.readouterr() == ("[it] one\n", "[it] two\n")
