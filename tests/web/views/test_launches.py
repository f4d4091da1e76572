"""The views and calls behind the panel of launches, with a launch of the test's process."""

from __future__ import annotations

import io
import os
import threading
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.ground.errors import Error
from pyros1.launch.running.api import LaunchServer
from pyros1.launch.running.console import Console
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.supervisor import Supervisor
from pyros1.net.hosts import addresses_from_environment
from pyros1.web import calls
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError

PATIENCE = 20.0
Make = Callable[..., Any]


@pytest.fixture
def logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "logs"
    folder.mkdir()
    monkeypatch.setenv("ROS_LOG_DIR", str(folder))
    return folder


@pytest.fixture
def launch(robot: Robot, logs: Path, tmp_path: Path) -> Iterator[str]:
    """A launch with a process; the name of its parameter."""
    supervisor = Supervisor(Console(io.StringIO(), io.StringIO()), sigint_timeout=5.0)
    words = ["sh", "-c", "echo it runs; exec sleep 100"]
    base = str(logs / "driver-1")
    supervisor.start(ProcessSpec("driver-1", "/driver", words, dict(os.environ), str(tmp_path), base, False))
    runner = threading.Thread(target=supervisor.run)
    runner.start()
    server = LaunchServer(supervisor, addresses_from_environment({"ROS_HOSTNAME": "localhost"}, {}), "robot.launch")
    robot.master.set_param(server.param_name(), server.uri)
    yield server.param_name()
    server.close()
    supervisor.stop()
    runner.join(PATIENCE)
    supervisor.shut_down()


def process(data: Any) -> Any:
    return data["launches"][0]["processes"][0]


@pytest.mark.slow
def test_launches_are_seen_and_controlled(robot: Robot, watch: Make, launch: str) -> None:
    watched = watch("launches")
    seen = watched.until(lambda data: data["launches"])
    assert (seen["launches"][0]["title"], seen["launches"][0]["param"], seen["more"]) == ("robot.launch", launch, 0)
    assert (process(seen)["node"], process(seen)["state"], seen["launches"][0]["refusal"]) == ("/driver", "running", "")
    watched.until(lambda data: process(data)["cpu"] is not None or not os.path.exists("/proc"))
    told = {"launch": launch, "process": "driver-1"}
    calls.run(robot, "launches.control", {**told, "verb": "stop"})
    watched.until(lambda data: process(data)["state"] == "stopped")
    calls.run(robot, "launches.control", {**told, "verb": "start"})
    watched.until(lambda data: process(data)["state"] == "running" and process(data)["starts"] == 2)
    calls.run(robot, "launches.control", {**told, "verb": "restart"})
    watched.until(lambda data: process(data)["state"] == "running" and process(data)["starts"] == 3)
    info = calls.run(robot, "launches.info", told)
    assert info["command"] == "sh -c 'echo it runs; exec sleep 100'"


def test_only_what_may_be_told(robot: Robot, make_robot: Make, launch: str) -> None:
    for args in (
        {"launch": launch, "process": "driver-1", "verb": "eat"},
        {"launch": launch, "process": "other-1", "verb": "stop"},
        {"launch": "/rosdistro", "process": "driver-1", "verb": "stop"},
        {"launch": launch, "verb": "stop"},
    ):
        with pytest.raises(Error):
            calls.run(robot, "launches.control", args)
    looker = make_robot(read_only=True)
    with pytest.raises(RequestError, match="read-only"):
        calls.run(looker, "launches.control", {"launch": launch, "process": "driver-1", "verb": "stop"})
    with pytest.raises(RequestError, match="read-only"):
        calls.run(looker, "launches.forget", {"launch": launch})


def test_a_launch_that_was_killed_is_shown_and_forgotten(robot: Robot, watch: Make, closed_port: int) -> None:
    param = "/roslaunch/uris/host_gone__1"
    robot.master.set_param(param, f"http://localhost:{closed_port}/")
    robot.master.set_param("/roslaunch/uris/odd", "nonsense")
    watched = watch("launches")
    seen = watched.until(lambda data: len(data["launches"]) == 2)
    assert all(launch["problem"] for launch in seen["launches"])
    calls.run(robot, "launches.forget", {"launch": param})
    calls.run(robot, "launches.forget", {"launch": "/roslaunch/uris/odd"})
    calls.run(robot, "launches.forget", {"launch": "/run_id"})  # not a launch
    watched.until(lambda data: not data["launches"])


def test_the_log_grows(watch: Make, launch: str, logs: Path) -> None:
    watched = watch("launch_log", launch=launch, process="driver-1")
    seen = watched.until(lambda data: data["files"] and data["files"][0]["text"])
    assert (seen["files"][0]["text"], seen["base"]) == ("it runs", str(logs / "driver-1"))
    (logs / "driver-1.log").write_text("one\n")
    seen = watched.until(lambda data: len(data["files"]) == 2)
    assert seen["files"][0] == {"path": str(logs / "driver-1.log"), "size": 4, "text": "one"}
    with pytest.raises(RequestError, match="no process"):
        watch("launch_log", launch=launch, process="other-1")
