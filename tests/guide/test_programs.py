"""The programs of the how-to pages that no other test runs, as they stand there.

Feature: how-to pages
"""

from __future__ import annotations

import os
import queue
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1
from pyros1.cli.running import run_command
from pyros1.finding.python_modules import DROP_IN_START
from pyros1.guide.documents import GuidePage, pages
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.std_msgs.msg import Float64

pytestmark = pytest.mark.once

SOURCE = Path(pyros1.__file__).parents[1]
PATIENCE = 30.0
Start = Callable[[str], "subprocess.Popen[str]"]


@pytest.fixture
def start(environ: dict[str, str], tmp_path: Path) -> Iterator[Start]:
    """Return a function that starts a program in a folder; what still runs is interrupted, and must end well."""
    children: list[subprocess.Popen[str]] = []
    around = {
        "PYTHONPATH": f"{DROP_IN_START}{os.pathsep}{SOURCE}",
        "ROS_HOME": str(tmp_path / "ros"),
        "PYROS1_ROSPY": "pyros1",
    }

    def run(program: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-c", program]
        children.append(
            subprocess.Popen(
                command, cwd=tmp_path, env={**os.environ, **environ, **around}, stdout=subprocess.PIPE, text=True
            )
        )
        return children[-1]

    yield run
    for child in children:
        if child.poll() is None:
            child.send_signal(signal.SIGINT)
        child.communicate(timeout=PATIENCE)
        assert child.returncode == 0


def said_by(child: subprocess.Popen[str]) -> str:
    return child.communicate(timeout=PATIENCE)[0]


def until(values: queue.Queue[Any], wanted: Callable[[Any], bool]) -> Any:
    while not wanted(value := values.get(timeout=PATIENCE)):
        pass
    return value


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
@pytest.mark.parametrize("number", [0, 1], ids=["rospy", "pyros1"])
def test_the_same_node_for_rospy_and_pyros1(start: Start, make_node: Any, number: int) -> None:
    node = make_node("other")
    totals: queue.Queue[float] = queue.Queue()
    texts: queue.Queue[str] = queue.Queue()
    node.params["/adder/gain"] = 1.5
    node.subscribe("total", Float64, lambda message: totals.put(message.data))
    node.subscribe("/rosout", Log, lambda record: record.name == "/adder" and texts.put(record.msg))
    numbers = node.advertise("number", Float64, latch=True)
    start(pages()["habits"].code("python")[number])
    numbers.publish(2.0)
    assert totals.get(timeout=PATIENCE) == 3.0
    node.wait_for_service("/adder/read", PATIENCE)
    assert node.service("/adder/read", "std_srvs/Trigger")().message == "3"
    until(texts, re.compile("the total is [03]").match)


@pytest.mark.parametrize("page", pages().values(), ids=pages())
def test_names_of_nodes_and_their_parts(page: GuidePage, make_node: Any) -> None:
    """What a page calls on a node is there."""
    node = make_node("named")
    text = re.sub(r"(?s)```.*?```", "", page.text)
    for names in re.findall(r"(?<!\S)[`(]?node\.((?!py\b)[a-z_.]+)", text):
        part = node
        for name in names.rstrip(".").split("."):
            if part is node and name == "sync":  # of asyncio's nodes
                continue
            part = getattr(part, name, part if name == "call" else None)
            assert part is not None, f"node.{names}"


@pytest.mark.slow
def test_bags_in_a_notebook(start: Start, make_node: Any) -> None:
    write, look, table, live = pages()["bags"].code("python")
    said_by(start(write))
    assert said_by(start(look)) == "4.5 [5. 6. 7. 8.]\n"
    velocity = make_node("simulator").advertise("velocity", Float64, latch=True)
    velocity.publish(0.25)
    assert said_by(start(live)) == "0.25\n"
    pytest.importorskip("pandas")
    assert re.search(r"1970-01-01 00:16:40\.500 +7\.0\n", said_by(start(table)))


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
def test_frames(start: Start, make_node: Any) -> None:
    publishing, asking = pages()["frames"].code("python")
    texts: queue.Queue[str] = queue.Queue()
    make_node("log").subscribe("/rosout", Log, lambda record: record.name == "/asker" and texts.put(record.msg))
    start(publishing)
    said_by(start(asking))
    assert until(texts, re.compile("it is at").match) == "it is at 1.0, 1.2"


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="process groups")
def test_launch(start: Start, tmp_path: Path) -> None:
    file = tmp_path / "two.launch"
    file.write_text(pages()["launch"].code("xml")[0])
    assert run_command("launch", ["--check", str(file)]) == 0
    (program,) = pages()["launch"].code("python")
    assert re.search(r"^it counts: 0\.\d+$", said_by(start(program)), re.M)
