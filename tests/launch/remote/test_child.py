"""What a stock launcher asks of its child on another machine, asked by a stand-in (L151-L153)."""

from __future__ import annotations

import os
import queue
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

import pytest

from pyros1.finding.packages import PackageIndex
from pyros1.ground.errors import Error, LaunchError
from pyros1.launch.reading.resources import Resources
from pyros1.launch.remote.child import Child, stop_when_stdin_closes
from pyros1.launch.running.options import Options
from pyros1.master.server import Master
from pyros1.net.loop import Loop
from pyros1.net.master_client import MasterClient
from pyros1.net.xmlrpc_client import XmlRpcClient
from pyros1.net.xmlrpc_server import XmlRpcServer

DEADLINE = 20.0
NODES = {
    "stay": "exec sleep 100",
    "fail": "echo out; echo err >&2; exit 3",
    "stuck": "trap '' INT TERM; echo up >\"$UP\"; while :; do sleep 100; done",
}
XML = """<?xml version="1.0" encoding="utf-8"?>
<launch>
<node pkg="far" type="stay" ns="/g/" args="" name="stay" respawn="False" respawn_delay="0.0" required="False">
  <env name="MARK" value="two words" />
</node>
<node pkg="far" type="fail" ns="/g/" args="" name="fail" respawn="False" required="False"/>
<node pkg="far" type="none" ns="/g/" args="" name="none" respawn="False" required="False"/></launch>"""


class Parent:
    """Notes what the child calls."""

    def __init__(self) -> None:
        self.calls: list[tuple[Any, ...]] = []
        self._loop = Loop("parent")
        self._server = XmlRpcServer(self._loop, self._dispatch, bind_host="127.0.0.1", advertised_host="localhost")
        self._loop.start()
        self.uri = self._server.uri

    def _dispatch(self, method: str, params: Sequence[Any]) -> list[Any]:
        self.calls.append((method, *params))
        return [1, "", 1]

    def close(self) -> None:
        self._server.close()
        self._loop.stop()


@pytest.fixture
def parent() -> Iterator[Parent]:
    parent = Parent()
    yield parent
    parent.close()


@pytest.fixture
def environ(tmp_path: Path) -> dict[str, str]:
    (tmp_path / "far").mkdir()
    (tmp_path / "far" / "package.xml").write_text("<package><name>far</name></package>")
    for name, text in NODES.items():
        (tmp_path / "far" / name).write_text(f"#!/bin/sh\n{text}\n")
        (tmp_path / "far" / name).chmod(0o755)
    return {
        **os.environ,
        "ROS_HOME": str(tmp_path / "home"),
        "ROS_HOSTNAME": "localhost",
        "ROS_MASTER_URI": "http://127.0.0.1:1/",
        "ROS_PACKAGE_PATH": str(tmp_path / "far"),
    }


def until(reached: Callable[[], object], what: str) -> None:
    deadline = time.monotonic() + DEADLINE
    while not reached():
        assert time.monotonic() < deadline, what
        time.sleep(0.01)


def make_child(parent_uri: str, environ: dict[str, str]) -> Child:
    options = Options(sigint_timeout=5.0, sigterm_timeout=1.0)
    return Child("robot-0", parent_uri, "run", options, Resources(PackageIndex(environ), environ))


def test_a_parent_is_served(parent: Parent, environ: dict[str, str], tmp_path: Path) -> None:
    child = make_child(parent.uri, environ)
    runner = threading.Thread(target=child.run)
    runner.start()
    until(lambda: parent.calls, "it registers")
    method, name, uri = parent.calls[0]
    assert (method, name) == ("register", "robot-0")
    client = XmlRpcClient(uri, timeout=DEADLINE)
    try:
        assert client.call("launch", "<launch>")[0] == -1
        assert client.call("get_pid") == [1, str(os.getpid()), os.getpid()]
        assert client.call("launch", XML) == [1, "launched", [["Process<g/stay-1>", "Process<g/fail-2>"], ["none"]]]
        until(lambda: ("process_died", "g/fail-2", 3) in parent.calls, "the end of a node is told")
        # That a node has ended is told before it is taken off the list.
        until(lambda: client.call("get_node_names")[2] == ["g/stay-1"], "the node that has ended is listed no more")
        assert client.call("shutdown") == [1, "success", 1]
    finally:
        client.close()
        child.stop()
        runner.join(DEADLINE)
    shown = [(level, text) for method, _, *rest in parent.calls if method == "log" for level, text in [rest]]
    assert shown[0] == (2, "launching nodes...") and (2, "[g/stay-1] killing on exit") in shown
    assert any(level == 2 and text.startswith("process[g/stay-1]: started with pid [") for level, text in shown)
    assert any(level == 8 and "ERROR: cannot launch node of type [far/none]" in text for level, text in shown)
    assert any(level == 8 and "[g/fail-2] process has died [pid " in text for level, text in shown)
    logs = tmp_path / "home" / "log" / "run"
    assert [(logs / f"g-fail-2-{stream}.log").read_text() for stream in ("stdout", "stderr")] == ["out\n", "err\n"]


def test_it_ends_when_its_last_node_has(parent: Parent, environ: dict[str, str]) -> None:
    child = make_child(parent.uri, environ)
    runner = threading.Thread(target=child.run)
    runner.start()
    until(lambda: parent.calls, "it registers")
    client = XmlRpcClient(parent.calls[0][2], timeout=DEADLINE)
    client.call("launch", '<launch><node pkg="far" type="fail" name="fail"/></launch>')
    client.close()
    runner.join(DEADLINE)
    assert not runner.is_alive()
    text = "all processes on machine have died, roslaunch will exit"
    assert ("log", "robot-0", 2, text) in parent.calls


def test_without_a_parent_there_is_nothing_to_do(environ: dict[str, str]) -> None:
    with pytest.raises(Error, match="nonsense"):
        make_child("nonsense", environ)
    with pytest.raises(Error, match=r"cannot reach http://127\.0\.0\.1:1/"):
        make_child("http://127.0.0.1:1/", environ).run()


def test_log_files_that_cannot_be_written_are_said(environ: dict[str, str], tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(LaunchError, match=r"cannot write log files: .*\. Set ROS_LOG_DIR "):
        make_child("http://127.0.0.1:1/", {**environ, "ROS_LOG_DIR": str(tmp_path / "file")})


def test_its_nodes_are_found_through_the_master_while_they_run(
    parent: Parent, environ: dict[str, str], master: Master
) -> None:
    child = make_child(parent.uri, {**environ, "ROS_MASTER_URI": master.uri})
    runner = threading.Thread(target=child.run)
    client = MasterClient("/test", master.uri)
    runner.start()
    try:
        until(lambda: parent.calls, "it registers")
        assert child.launch("<launch><node pkg='far' type='stay' name='stay'/></launch>")[0] == 1
        (uri,) = client.get_param("/roslaunch/uris").values()
        assert uri == parent.calls[0][2]
    finally:
        child.stop()
        runner.join(DEADLINE)
    assert client.get_param("/roslaunch/uris") == {}
    client.close()
    assert child.launch(XML) == [0, "ERROR: this launcher is shutting down", [[], []]]


def test_nodes_that_do_not_end_are_killed_when_one_cannot_wait(
    parent: Parent, environ: dict[str, str], tmp_path: Path
) -> None:
    os.mkfifo(tmp_path / "up")
    child = make_child(parent.uri, {**environ, "UP": str(tmp_path / "up")})
    runner = threading.Thread(target=child.run)
    runner.start()
    child.launch("<launch><node pkg='far' type='stuck' name='stuck'/></launch>")
    (tmp_path / "up").read_text()
    child.stop()
    for _ in range(2):
        child.stop_waiting()
    runner.join(DEADLINE)
    assert not runner.is_alive()
    assert ("log", "robot-0", 2, "[stuck-1] escalating to SIGKILL") in parent.calls


def test_it_goes_on_when_the_parent_does_not_listen(parent: Parent, environ: dict[str, str]) -> None:
    """Until it is stopped by the connection, as the parent's end may also be a fault of the network."""
    child = make_child(parent.uri, environ)
    runner = threading.Thread(target=child.run)
    runner.start()
    until(lambda: parent.calls, "it registers")
    parent.close()
    client = XmlRpcClient(parent.calls[0][2], timeout=DEADLINE)
    try:
        assert client.call("launch", XML)[2] == [["Process<g/stay-1>", "Process<g/fail-2>"], ["none"]]
        assert "g/stay-1" in client.call("get_node_names")[2]
    finally:
        client.close()
        child.stop()
        runner.join(DEADLINE)
    assert not runner.is_alive()


@pytest.fixture
def stdin() -> Iterator[Callable[[int], None]]:
    """Return a function that makes a file the standard input of this process."""
    before = os.dup(0)

    def replace(file: int) -> None:
        os.dup2(file, 0)
        os.close(file)

    yield replace
    os.dup2(before, 0)
    os.close(before)


def test_it_ends_with_the_connection(stdin: Callable[[int], None]) -> None:
    """Also if that is only seen at its standard input, of which nodes get nothing."""
    read_end, write_end = os.pipe()
    reasons: queue.SimpleQueue[str] = queue.SimpleQueue()
    stdin(read_end)
    stop_when_stdin_closes(reasons.put)
    os.write(write_end, b"what a user types")
    assert os.read(0, 1) == b""
    assert reasons.empty()
    os.close(write_end)
    assert reasons.get(timeout=DEADLINE) == "the connection to the parent was closed"


def test_a_standard_input_that_is_no_connection_is_left_alone(stdin: Callable[[int], None], tmp_path: Path) -> None:
    (tmp_path / "file").write_text("text")
    stdin(os.open(tmp_path / "file", os.O_RDONLY))
    stop_when_stdin_closes(print)
    assert os.read(0, 10) == b"text"


@pytest.mark.parametrize(
    ("words", "text"),
    [
        ([], "--child option requires --server_uri to be set as well"),
        (["-u", "http://localhost:1/"], "--child option requires --run_id to be set as well"),
        (["-u", "http://localhost:1/", "--run_id", "r", "x.launch"], "Input files are not allowed when run in child"),
    ],
)
def test_wrong_words(words: list[str], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    from pyros1.cli.running import run_command

    with pytest.raises(SystemExit) as end:
        run_command("launch", ["-c", "robot-0", *words])
    assert end.value.code == 2 and text in capsys.readouterr().err
