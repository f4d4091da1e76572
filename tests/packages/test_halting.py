"""The guide's simulator that halts, and launch files that stop one which does not.

Feature: a robot that stops when its controller dies -- kill -9, SIGSTOP, a clean exit
Feature: a final message or a stop program when a launched node has exited
"""

from __future__ import annotations

import os
import queue
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.guide.documents import pages
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.std_msgs.msg import Float64

SRC = Path(pyros1.__file__).parent
SCRIPTS = SRC / "packages" / "minimal_nodes" / "scripts"
PATIENCE = 30.0

pytestmark = [
    pytest.mark.once,
    pytest.mark.skipif(sys.platform == "win32", reason="signals"),
]


@pytest.fixture
def run(environ: dict[str, str]) -> Iterator[Callable[..., Any]]:
    """Return a function that starts a Python program."""
    children: list[subprocess.Popen[bytes]] = []

    def start(*words: object) -> subprocess.Popen[bytes]:
        env = {**os.environ, **environ, "PYTHONPATH": str(SRC.parent)}
        children.append(subprocess.Popen([sys.executable, *map(str, words)], env=env, stdout=subprocess.DEVNULL))
        return children[-1]

    yield start
    for child in children:
        for number in (signal.SIGCONT, signal.SIGINT):
            child.send_signal(number)
    for child in children:
        try:
            child.wait(PATIENCE)
        finally:
            child.kill()
            child.wait()


def until(values: queue.Queue[Any], wanted: Callable[[Any], bool]) -> Any:
    """Wait for a value."""
    end = time.monotonic() + PATIENCE
    while not wanted(value := values.get(timeout=max(0.0, end - time.monotonic()))):
        pass
    return value


def program() -> str:
    """Return the program of the guide's page."""
    (found,) = pages()["halting"].code("python")
    return found


def test_the_readme_shows_the_script() -> None:
    assert (SCRIPTS / "halting_simulator").read_text("utf-8").endswith('"""\n\n' + program())


@pytest.mark.slow
def test_the_simulator_halts_when_its_controller_dies_hangs_or_ends(run: Any, make_node: Any) -> None:
    node = make_node("operator")
    velocities: queue.Queue[float] = queue.Queue()
    said: queue.Queue[str] = queue.Queue()
    node.subscribe("velocity", Float64, lambda message: velocities.put(message.data))
    node.subscribe("/rosout", Log, lambda record: record.name == "/halting_simulator" and said.put(record.msg))
    node.advertise("vel_cmd", Float64, latch=True).publish(10.0)
    run("-c", program())
    silent = "no message on /force_cmd"  # may be first also of a dead one, where the machine stands still for a moment
    for number, reason in (
        (signal.SIGKILL, f"its port is closed|{silent}"),
        (signal.SIGSTOP, silent),
        (signal.SIGINT, f"its port is closed|{silent}"),
    ):
        controller = run(SCRIPTS / "minimal_controller")
        until(velocities, lambda velocity: velocity > 0.3)
        controller.send_signal(number)
        until(said, re.compile(f"halting: .*({reason})").match)
        until(velocities, lambda velocity: velocity < 0.01)
        if number == signal.SIGSTOP:
            controller.send_signal(signal.SIGCONT)
            until(velocities, lambda velocity: velocity > 0.3)
            controller.kill()
            until(velocities, lambda velocity: velocity < 0.01)


@pytest.mark.slow
def test_a_launch_stops_what_a_dead_controller_left(run: Any, make_node: Any, tmp_path: Path) -> None:
    (tmp_path / "stop.launch").write_text(
        '<launch><remap from="force_cmd" to="/force"/>'
        '<node pkg="minimal_nodes" type="minimal_controller" name="controller"'
        ' on-death="pub force_cmd std_msgs/Float64 -7.5"/></launch>'
    )
    node = make_node("operator")
    forces: queue.Queue[tuple[float, str]] = queue.Queue()
    node.subscribe("/force", Float64, lambda m: forces.put((m.data, m._connection_header["callerid"])))
    run("-m", "pyros1", "launch", tmp_path / "stop.launch")
    until(forces, lambda force: force[1] == "/controller")
    os.kill(controller_pid(node), signal.SIGKILL)
    until(forces, lambda force: force[0] == -7.5)


def controller_pid(node: Any) -> int:
    """Return the process id of the controller."""
    found: queue.Queue[int] = queue.Queue()
    with node.watch("/controller", on_found=lambda sighting: found.put(sighting.pid)):
        return found.get(timeout=PATIENCE)
