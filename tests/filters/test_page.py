"""The guide's programs with filters, parameters that change, and diagnostics."""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.guide.documents import pages
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.reconfigure import Client

FILTERS, ASYNCIO, RECONFIGURE, DIAGNOSTICS = range(4)

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")


@pytest.fixture
def start(environ: dict[str, str]) -> Iterator[Callable[[int], None]]:
    """Start one of the programs; it has to end by itself on Ctrl-C."""
    programs = pages()["filters"].code("python")
    running = []

    def begin(number: int) -> None:
        environment = {**os.environ, **environ}
        running.append(subprocess.Popen([sys.executable, "-c", programs[number]], env=environment))

    yield begin
    for child in running:
        child.send_signal(signal.SIGINT)
        assert child.wait(20) == 0


@pytest.mark.parametrize("number", [FILTERS, ASYNCIO], ids=["node", "asyncio"])
def test_filters(start: Any, make_node: Any, number: int) -> None:
    node = make_node("camera")
    said: queue.Queue[Any] = queue.Queue()
    node.subscribe("/rosout", Log, lambda record: record.name == "/camera_reader" and said.put(record.msg))
    image, info = node.advertise("image", Image), node.advertise("camera_info", CameraInfo)
    start(number)
    for publisher in (image, info):
        assert publisher.wait_for_subscribers(1, 20.0)
    until = time.monotonic() + 20
    while time.monotonic() < until:  # /rosout may be connected later
        first, second = Image(), CameraInfo()
        first.header.stamp, second.header.stamp = Time(1.5), Time(1.51)
        image.publish(first)
        info.publish(second)
        try:
            assert said.get(timeout=0.5) == "image and info of 1.500"
            return
        except queue.Empty:
            continue
    pytest.fail("no set of messages")


def test_reconfigure(start: Any, make_node: Any) -> None:
    start(RECONFIGURE)
    with_choice = Client(make_node("panel"), "motor", timeout=20).update({"speed": 7, "mode": "fast"}, 20)
    assert (with_choice.speed, with_choice.mode) == (5.0, 1)


def test_diagnostics(start: Any, make_node: Any) -> None:
    arrays: queue.Queue[Any] = queue.Queue()
    make_node("monitor").subscribe("/diagnostics", DiagnosticArray, arrays.put)
    start(DIAGNOSTICS)
    found: list[tuple[str, int, str]] = []
    while len(found) < 2:
        found = [(each.name, each.level, each.hardware_id) for each in arrays.get(timeout=20).status]
    assert found[0] == ("driver: Battery", 1, "laser 7") and found[1][0] == "driver: Scans"
