"""The node rosout."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Callable
from pathlib import Path
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.net.master_client import MasterClient
from pyros1.node import Node
from pyros1.robot_nodes.rosout.node import is_running, main

PATIENCE = 20.0


def test_nothing_is_done_while_another_node_collects_messages(
    environ: dict[str, str],
    make_node: Callable[..., Node],
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Feature: rosout in a launch file, beside the one of the core"""
    for name, value in environ.items():
        monkeypatch.setenv(name, value)
    assert not is_running(environ["ROS_MASTER_URI"]) and not is_running("http://localhost:1")
    core_node = make_node("rosout")
    waits: list[bool] = []

    def wait() -> None:
        waits.append(core_node.ok())
        raise KeyboardInterrupt

    assert main(["rosout", "__name:=rosout"], wait) == 0
    assert waits == [True]
    assert "the node /rosout is running already" in capfd.readouterr().out
    core_node.shutdown()
    assert not is_running(environ["ROS_MASTER_URI"])


def test_a_node_that_died_does_not_count(environ: dict[str, str], closed_port: int) -> None:
    client = MasterClient("/rosout", environ["ROS_MASTER_URI"])
    client.register_publisher("/rosout_agg", "rosgraph_msgs/Log", f"http://localhost:{closed_port}/")
    client.close()
    assert not is_running(environ["ROS_MASTER_URI"])


def test_messages_are_collected(
    environ: dict[str, str], make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for name, value in {**environ, "ROS_LOG_DIR": str(tmp_path)}.items():
        monkeypatch.setenv(name, value)
    collected: Queue[Any] = Queue()
    user = make_node("user")
    user.subscribe("/rosout_agg", Log, collected.put)

    def talk() -> None:
        try:
            while collected.empty() and user.ok():
                user.log.warn("the battery is low")
                user.sleep(0.05)
        finally:
            os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=talk)
    thread.start()
    assert main(["rosout"], lambda: pytest.fail("no other node was running")) == 0
    thread.join(PATIENCE)
    assert collected.get(timeout=PATIENCE).msg == "the battery is low"
    assert "WARN /user" in (tmp_path / "rosout.log").read_text()
