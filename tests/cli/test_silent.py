"""A master or a node that was stopped takes connections and never answers: every command says so in a few seconds.

Feature: which nodes are alive, hanging or dead
Feature: a master or node that hangs is reported within five seconds
"""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.main import entry
from pyros1.ground.errors import NodeShutdownError
from pyros1.net.master_client import MasterClient

pytestmark = pytest.mark.once

SOURCE = Path(__file__).resolve().parents[2] / "src"


@pytest.fixture
def silent() -> Iterator[int]:
    """A port that takes connections and never answers."""
    with socket.create_server(("127.0.0.1", 0), backlog=50) as server:
        yield server.getsockname()[1]


COMMANDS = """
topic list | topic type /t | topic info /t | topic find std_msgs/String | topic echo /t | topic hz /t | topic bw /t
topic delay /t | topic pub /t std_msgs/String x | node list | node info /n | node ping /n | node ping -a | node machine
node kill /n | node cleanup | node tree | node status | node stop /n | service list | service info /s | service type /s
service uri /s | service call /s | service find std_srvs/Empty | param list | param get /p | param set /p 1
param delete /p
param dump | graph --once | graph | log list /n | log echo | diagnostic | dynparam list | tf tree
tf echo a b | tf monitor
"""


@pytest.mark.parametrize("words", [each.strip() for each in COMMANDS.replace("\n", "|").split("|") if each.strip()])
def test_a_master_that_does_not_answer(
    silent: int, words: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{silent}")
    monkeypatch.setattr("pyros1.cli.invocation.MASTER_TIMEOUT", 0.1)
    assert entry(["pyros1", *words.split()]) in (1, 2)
    assert f"http://127.0.0.1:{silent} did not answer within 0.1 s" in capfd.readouterr().err


@pytest.mark.parametrize("words", ["launch minimal_nodes minimal_nodes.launch", "core"])
def test_a_launch_does_not_take_it_for_no_master(
    silent: int, words: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{silent}")
    monkeypatch.setenv("ROS_HOSTNAME", "127.0.0.1")
    monkeypatch.setenv("ROS_HOME", str(tmp_path))
    monkeypatch.setattr("pyros1.launch.running.session.PING_TIMEOUT", 0.1)
    assert entry(["pyros1", *words.split(), *(["-p", str(silent)] if words == "core" else [])]) == 1
    assert f"127.0.0.1:{silent}" in (err := capfd.readouterr().err) and "does not answer within 0.1 s" in err


@pytest.mark.parametrize(
    "words", ["bag record /a", "topic_tools relay /a /b", "tf static_transform_publisher 0 0 0 0 0 0 a b 100"]
)
def test_what_waits_for_a_master_says_that_it_does_not_answer(
    silent: int, words: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("ROS_MASTER_URI", f"http://127.0.0.1:{silent}")
    monkeypatch.setenv("ROS_HOME", str(tmp_path))
    monkeypatch.setattr("pyros1.node.registrar.PING_TIMEOUT", 0.1)
    monkeypatch.setattr("pyros1.node.context.Context.pause", _give_up)
    entry(["pyros1", *words.split()])
    assert "it accepts connections, but did not answer within 0.1 s (was it stopped?)" in capfd.readouterr().err


def _give_up(*_: object) -> None:
    raise NodeShutdownError("it waits for the master")


@pytest.mark.slow
def test_a_node_that_does_not_answer(silent: int, environ: dict[str, str]) -> None:
    """All at once: each waits for some seconds."""
    api = f"http://127.0.0.1:{silent}/"
    client = MasterClient("/mute", environ["ROS_MASTER_URI"])
    client.register_publisher("/t", "std_msgs/String", api)
    client.register_service("/s", f"rosrpc://127.0.0.1:{silent}", api)
    client.register_service("/mute/set_parameters", f"rosrpc://127.0.0.1:{silent}", api)
    client.register_service("/mute/get_loggers", f"rosrpc://127.0.0.1:{silent}", api)
    client.close()
    expected = {
        "node info /mute": (1, api),
        "node ping /mute": (0, api),
        "node ping -a": (0, api),
        "node list --check": (1, "/mute hangs: it accepts connections, but did not answer within 2.5 s"),
        "node kill /mute": (1, "/mute"),
        "node cleanup": (0, "/mute"),
        "service info /s": (2, "/s"),
        "service type /s": (2, "/s"),
        "service call /s": (2, "/mute accepts connections but did not answer"),
        "dynparam get -t 2 /mute": (1, "does not answer (was its node stopped?)"),
        "service find std_srvs/Empty": (0, "/s"),
        "log list /mute": (1, "/mute"),
        "graph --once": (0, "/mute"),
        "wtf": (1, "Nodes at [127.0.0.1] accept connections, but do not answer"),
    }
    running: dict[str, Any] = {
        words: subprocess.Popen(
            [sys.executable, "-m", "pyros1", *words.split()], env={**os.environ, **environ, "PYTHONPATH": str(SOURCE)},
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        )
        for words in expected
    }  # fmt: skip
    for words, child in running.items():
        said = child.communicate(timeout=30)[0]
        code, who = expected[words]
        assert "Traceback" not in said
        # One of the others may be among the nodes, and the column wider for it.
        assert (child.returncode, who in " ".join(said.split())) == (code, True), f"{words}: {said}"
