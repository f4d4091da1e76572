"""The tutorial's four nodes, each in a process of its own, on live topics.

Feature: the tutorial's nodes -- the controller converges as theory predicts
"""

from __future__ import annotations

import itertools
import math
import os
import re
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.launch.reading.loader import load_plan
from pyros1.launch.reading.system_resources import make_resources
from pyros1.msgs.std_msgs.msg import Float64

SRC = Path(pyros1.__file__).parent
SCRIPTS = SRC / "packages" / "minimal_nodes" / "scripts"


@pytest.fixture
def run(environ: dict[str, str]) -> Iterator[Any]:
    """Return a function that starts a script; Ctrl-C must end each of them cleanly."""
    children: list[subprocess.Popen[str]] = []

    def start(script: str, *args: str) -> subprocess.Popen[str]:
        child = subprocess.Popen(
            [sys.executable, "-W", "error", str(SCRIPTS / script), *args],
            env={**os.environ, **environ, "PYTHONPATH": str(SRC.parent)},
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        children.append(child)
        return child

    yield start
    for child in children:
        child.send_signal(signal.SIGINT)
    for child in children:
        try:
            _, err = child.communicate(timeout=15)
        finally:
            child.kill()
        assert (child.returncode, err) == (0, ""), child.args


class Topic:
    """A subscriber that keeps what it hears."""

    def __init__(self, node: Any, name: str) -> None:
        self.data: list[float] = []
        self._changed = threading.Condition()
        self.subscriber = node.subscribe(name, Float64, self._take)

    def _take(self, message: Any) -> None:
        with self._changed:
            self.data.append(message.data)
            self._changed.notify_all()

    def wait(self, count: int, timeout: float = 15.0) -> list[float]:
        with self._changed:
            assert self._changed.wait_for(lambda: len(self.data) >= count, timeout), self.data
            return list(self.data)


def test_subscriber_prints_what_the_publisher_sends(run: Any, make_node: Any) -> None:
    subscriber = run("minimal_subscriber")
    publisher = run("minimal_publisher", "_rate:=50")
    lines = [subscriber.stdout.readline() for _ in range(5)]
    values = []
    for line in lines:
        match = re.fullmatch(r"\[INFO\] \[\d+\.\d+\]: received value is: (\d+\.\d{6})\n", line)
        assert match, line
        values.append(round(float(match.group(1)) * 1000))
    assert values == list(range(values[0], values[0] + 5)), "0.001 more each time"
    assert make_node("looker").params["/minimal_publisher/rate"] == 50
    assert publisher.poll() is None


def test_publisher_counts_from_one_thousandth(run: Any, make_node: Any) -> None:
    topic = Topic(make_node("listener"), "topic1")
    run("minimal_publisher", "_rate:=20")
    data = topic.wait(5)
    assert data[0] < 0.1
    for before, after in itertools.pairwise(data):
        assert after - before == pytest.approx(0.001)


def test_publisher_as_fast_as_it_can(run: Any, make_node: Any) -> None:
    topic = Topic(make_node("listener"), "topic1")
    run("minimal_publisher", "_rate:=0")
    data = topic.wait(5000)
    assert data == sorted(data)


def test_simulator_integrates_the_force(run: Any, make_node: Any) -> None:
    node = make_node("pusher")
    velocity = Topic(node, "velocity")
    force = node.advertise("force_cmd", Float64, latch=True)
    run("minimal_simulator")
    assert set(velocity.wait(5)) == {0.0}
    force.publish(2.0)
    begun = len(velocity.data)
    data = velocity.wait(begun + 30)
    steps = [after - before for before, after in itertools.pairwise(data)]
    first = next(index for index, step in enumerate(steps) if step)
    assert steps[first:] == pytest.approx([2.0 * 0.01] * len(steps[first:])), "v += F / m * dt, each step"


@pytest.mark.slow
def test_controller_converges_with_a_time_constant_of_one_second(run: Any, make_node: Any) -> None:
    """The response to a step is 1 - exp(-t / T) with T = m / Kv = 1 s, t in steps of the simulation (0.01 s each).

    The controller samples ten times a second of wall time; the simulator steps a hundred times. On a busy machine both
    come late, but together: a fit over the whole response keeps T within the tolerance.
    """
    node = make_node("operator")
    velocity = Topic(node, "velocity")
    command = node.advertise("vel_cmd", Float64, latch=True)
    run("minimal_simulator")
    run("minimal_controller")
    assert command.wait_for_subscribers(timeout=15)
    velocity.wait(10)
    command.publish(1.0)
    begun = len(velocity.data)
    data = velocity.wait(begun + 300)
    start = next(index for index, value in enumerate(data) if value > 0)
    response = data[start : start + 250]
    assert all(after >= before - 1e-9 for before, after in itertools.pairwise(response))
    assert max(response) <= 1.0 + 1e-9, "no overshoot"
    # a straight line through log(1 - v) over the time, by least squares, up to two time constants
    points = [(index * 0.01, math.log(1.0 - value)) for index, value in enumerate(response[:200]) if value < 1.0]
    mean_t = sum(t for t, _ in points) / len(points)
    mean_y = sum(y for _, y in points) / len(points)
    slope = sum((t - mean_t) * (y - mean_y) for t, y in points) / sum((t - mean_t) ** 2 for t, _ in points)
    assert -1.0 / slope == pytest.approx(1.0, rel=0.15)
    assert response[-1] == pytest.approx(1.0 - math.exp(-2.5), abs=0.06)


@pytest.mark.slow
def test_the_tour_has_a_simulator_a_changing_command_and_a_page(run: Any, make_node: Any) -> None:
    tour = SCRIPTS.parent / "launch" / "tour.launch"
    plan = load_plan([str(tour)], {}, make_resources())
    assert [(node.package, node.type) for node in plan.nodes] == [
        ("minimal_nodes", "minimal_simulator"),
        ("minimal_nodes", "minimal_controller"),
        ("minimal_nodes", "minimal_commander"),
        ("rqt_gui", "rqt_gui"),
    ]
    commands = Topic(make_node("listener"), "vel_cmd")
    run("minimal_commander")
    assert set(commands.wait(2)) == {1.0}
