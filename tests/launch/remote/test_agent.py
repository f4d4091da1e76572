"""launch.remote.agent in this process: what it does with messages, and with silence."""

from __future__ import annotations

import io
import json
import os
import signal
import threading
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.launch.remote import agent
from pyros1.launch.running import usage

DEADLINE = 20.0
START = {"do": "start", "label": "it-1", "package": "far", "type": "stay", "prefix": [], "args": [], "env": {}}
START |= {"cwd": "node", "run_id": "run", "screen": False, "again": False}


class Launcher:
    """The other end of the agent's standard input and output."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        (self.stdin, self.to_agent), (self.from_agent, self.stdout) = (
            (os.fdopen(read_end), os.fdopen(write_end, "w", buffering=1))
            for read_end, write_end in (os.pipe(), os.pipe())
        )
        self.streams = SimpleNamespace(stdin=self.stdin, stdout=self.stdout)
        monkeypatch.setattr(agent, "sys", self.streams)
        self.thread = threading.Thread(target=agent.Agent().run)
        self.thread.start()

    def send(self, **message: Any) -> None:
        self.to_agent.write(json.dumps(message) + "\n")

    def receive(self) -> dict[str, Any]:
        return dict(json.loads(self.from_agent.readline()))

    def close(self) -> None:
        self.to_agent.close()
        self.thread.join(DEADLINE)
        for file in (self.stdout, self.from_agent, self.stdin):
            file.close()


@pytest.fixture
def launcher(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Launcher]:
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "package.xml").write_text("<package><name>far</name></package>")
    (tmp_path / "far" / "stay").write_text("#!/bin/sh\nexec sleep 100\n")
    (tmp_path / "far" / "tell").write_text("#!/bin/sh\npwd\necho 'an error' >&2\n")
    for name in ("stay", "tell"):
        (tmp_path / "far" / name).chmod(0o755)
    monkeypatch.setenv("ROS_PACKAGE_PATH", str(tmp_path / "far"))
    monkeypatch.setenv("ROS_HOME", str(tmp_path / "home"))
    monkeypatch.delenv("ROS_LOG_DIR", raising=False)
    launcher = Launcher(monkeypatch)
    assert launcher.receive() == {"event": "ready", "pid": os.getpid()}
    assert usage.__file__ is not None
    launcher.send(do="hello", stop_timeouts=[5.0, 0.1], usage=Path(usage.__file__).read_text())
    yield launcher
    launcher.close()
    assert not launcher.thread.is_alive()


def test_silence_of_the_launcher_ends_the_nodes(launcher: Launcher, monkeypatch: pytest.MonkeyPatch) -> None:
    """The network may fail without closing the connection."""
    launcher.send(**START)
    assert launcher.receive()["event"] == "started"
    monkeypatch.setattr(agent, "HEARTBEAT_TIMEOUT", 0.0)
    launcher.send()  # the last heartbeat
    assert launcher.receive() == {"event": "ended", "label": "it-1", "code": -signal.SIGINT}
    launcher.thread.join(DEADLINE)
    assert not launcher.thread.is_alive()


@pytest.mark.parametrize("screen", [True, False])
def test_the_output_of_nodes_goes_to_the_launcher_or_to_files(launcher: Launcher, tmp_path: Path, screen: bool) -> None:
    launcher.send(**{**START, "type": "tell", "cwd": "ros_home", "screen": screen})
    outputs, event = {}, launcher.receive()
    while event["event"] != "ended":
        if event["event"] == "output":
            outputs[event["stream"]] = event["text"]
        event = launcher.receive()
    log_base = tmp_path / "home" / "log" / "run" / "it-1"
    if not screen:
        outputs = {n: Path(f"{log_base}-{name}.log").read_text() for n, name in ((1, "stdout"), (2, "stderr"))}
    assert outputs == {1: f"{tmp_path / 'home'}\n", 2: "an error\n"}


def test_messages_that_mean_nothing_are_ignored(launcher: Launcher) -> None:
    """A newer launcher may send others."""
    launcher.send(do="dance")
    launcher.send(do="signal", label="nobody", number=9)
    launcher.send(**START)
    assert launcher.receive()["event"] == "started"
    launcher.send(do="signal", label="it-1", number=9)
    assert launcher.receive() == {"event": "ended", "label": "it-1", "code": -9}


def test_a_launcher_that_does_not_listen_does_no_harm(launcher: Launcher) -> None:
    launcher.streams.stdout = io.StringIO()
    launcher.streams.stdout.close()
    launcher.send(**{**START, "package": "none"})
    launcher.close()
    assert not launcher.thread.is_alive()


@pytest.mark.skipif(not hasattr(os, "SCHED_FIFO"), reason="only Linux has real-time priorities")
@pytest.mark.parametrize("permitted", [True, False])
def test_a_real_time_priority(launcher: Launcher, monkeypatch: pytest.MonkeyPatch, permitted: bool) -> None:
    asked = []

    def set_scheduler(thread: int, policy: int, param: os.sched_param) -> None:
        if not permitted:
            raise PermissionError(1, "Operation not permitted")
        asked.append((thread, policy, param.sched_priority))

    monkeypatch.setattr(os, "sched_setscheduler", set_scheduler)
    launcher.send(**START, priority=50)
    started = launcher.receive()
    assert started["event"] == "started"
    launcher.send(do="usage")
    refusal = None if permitted else launcher.receive()
    assert launcher.receive()["event"] == "usage"
    if refusal is None:
        assert asked == [(started["pid"], os.SCHED_FIFO, 50)]
    else:
        assert (refusal["event"], refusal["stream"]) == ("output", 2)
        assert refusal["text"].startswith("[it-1] cannot get real-time priority 50: [Errno 1] Operation not permitted")
