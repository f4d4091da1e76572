from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable

import pytest

from pyros1.ground.errors import NodeError
from pyros1.node import Node
from pyros1.robot_nodes.shared import program
from pyros1.robot_nodes.shared.program import run_node


def test_an_error_at_the_start_is_logged(
    environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)

    def start(node: Node) -> None:
        raise NodeError(f"{node.name} has no map")

    assert run_node(["map_server", "__name:=floor"], "map_server", start) == 1
    assert "/floor has no map" in capfd.readouterr().err


def test_a_node_runs_until_it_is_interrupted(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    interrupt = threading.Timer(0.0, os.kill, [os.getpid(), signal.SIGINT])
    names = []

    def start(node: Node) -> None:
        names.append(node.name)
        interrupt.start()

    assert run_node(["joy_node"], "joy_node", start) == 0
    interrupt.join()
    assert names == ["/joy_node"]


def test_an_interrupt_during_the_start_is_no_error(
    environ: dict[str, str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)

    def start(node: Node) -> None:
        node.shutdown()
        node.advertise("late", "std_msgs/Empty")

    assert run_node(["joy_node"], "joy_node", start) == 0
    assert capfd.readouterr().err == ""


def test_further_options_of_the_node(environ: dict[str, str], monkeypatch: pytest.MonkeyPatch) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    names = []

    def start(node: Node) -> None:
        names.append(node.name)
        node.shutdown()

    assert run_node(["map_server"], "map_server", start, anonymous=True) == 0
    assert names[0].startswith("/map_server_")


def test_a_clock_that_nobody_publishes_is_reported(
    environ: dict[str, str],
    monkeypatch: pytest.MonkeyPatch,
    make_node: Callable[..., Node],
    wait_for_line: Callable[[str], None],
) -> None:
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    monkeypatch.setattr(program, "CLOCK_PATIENCE", 0.0)
    make_node("user").params["/use_sim_time"] = True

    def look() -> None:
        try:
            wait_for_line("/use_sim_time is true, but nobody publishes /clock")
        finally:
            os.kill(os.getpid(), signal.SIGINT)

    looking = threading.Thread(target=look)
    assert run_node(["joy_node"], "joy_node", lambda node: looking.start()) == 0
    looking.join()
