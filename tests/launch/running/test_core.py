"""launch.running.core: the rosout node of a core."""

from __future__ import annotations

import os
import queue
import socket
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xmlrpc.client import ServerProxy

import pytest

from pyros1.ground.errors import SettingError
from pyros1.launch.running.core import Core, write_pid_file
from pyros1.net.hosts import LocalAddress
from pyros1.net.master_client import MasterClient

DEADLINE = 20.0


def test_the_rosout_node_comes_back_as_under_roscore(
    tmp_path: Path, free_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "argv", ["launch", "a.launch", "__name:=of_the_launch"])  # no arguments of the node
    uri = f"http://127.0.0.1:{free_port}/"
    said: queue.Queue[str] = queue.Queue()
    core = Core(
        port=free_port,
        address=LocalAddress("127.0.0.1", "127.0.0.1", ()),
        uri=uri,
        log_folder=tmp_path,
        environ={"ROS_HOSTNAME": "127.0.0.1"},
        on_shutdown=lambda reason: None,
    )
    core.start_master()
    client = MasterClient("/tool", uri)
    try:
        core.start_rosout(said.put)
        core.await_rosout()
        with ServerProxy(uri) as master:
            state: Any = master.getSystemState("/tool")
        assert state[2][:2] == [[["/rosout_agg", ["/rosout"]]], [["/rosout", ["/rosout"]]]]
        nodes = []
        for _ in range(2):
            nodes.append(client.lookup_node("/rosout"))
            with ServerProxy(nodes[-1]) as node:
                node.shutdown("/tool", "user request")
            assert said.get(timeout=DEADLINE) == "[rosout-1] process has finished cleanly"
            assert said.get(timeout=DEADLINE) == "[rosout-1] restarting process"
            assert said.get(timeout=DEADLINE) == f"process[rosout-1]: started with pid [{os.getpid()}]"
        assert client.lookup_node("/rosout") not in nodes
    finally:
        client.close()
        core.stop_rosout()
        core.stop_master()
    assert said.empty()


@pytest.fixture
def make_core(tmp_path: Path, free_port: int) -> Callable[..., Core]:
    def make(environ: dict[str, str] | None = None, **options: Any) -> Core:
        return Core(
            port=free_port,
            address=LocalAddress("127.0.0.1", "127.0.0.1", ()),
            uri=f"http://127.0.0.1:{free_port}/",
            log_folder=tmp_path,
            environ={"ROS_HOSTNAME": "127.0.0.1", **(environ or {})},
            on_shutdown=lambda reason: None,
            **options,
        )

    return make


def kill_rosout(port: int) -> None:
    client = MasterClient("/tool", f"http://127.0.0.1:{port}/")
    with ServerProxy(client.lookup_node("/rosout")) as node:
        node.shutdown("/tool", "user request")
    client.close()


def test_a_rosout_node_that_cannot_start_is_an_error(make_core: Callable[..., Core]) -> None:
    core = make_core({"PYROS1_PORTS": "nonsense"})
    core.start_master()
    try:
        core.start_rosout()
        with pytest.raises(SettingError, match="nonsense"):
            core.await_rosout()
    finally:
        core.stop_rosout()
        core.stop_master()


def test_a_rosout_node_that_cannot_start_again_is_told_of(
    make_core: Callable[..., Core], free_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: queue.Queue[str] = queue.Queue()
    core = make_core()

    def refuse(*arguments: Any, **options: Any) -> None:
        raise SettingError("no more nodes")

    core.start_master()
    try:
        core.start_rosout(said.put)
        core.await_rosout()
        monkeypatch.setattr("pyros1.node.node.Node", refuse)
        kill_rosout(free_port)
        texts = [said.get(timeout=DEADLINE) for _ in range(3)]
        assert texts[2] == "[rosout-1] cannot be started again: no more nodes"
    finally:
        core.stop_rosout()
        core.stop_master()


def test_a_core_that_ends_starts_no_rosout_node_again(
    make_core: Callable[..., Core], free_port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.launch.running.core.RESTART_DELAY_S", 1000.0)
    said: queue.Queue[str] = queue.Queue()
    core = make_core()
    core.start_master()
    core.start_rosout(said.put)
    core.await_rosout()
    kill_rosout(free_port)
    assert said.get(timeout=DEADLINE) == "[rosout-1] process has finished cleanly"
    core.stop_rosout()
    core.stop_master()
    assert said.empty()


@pytest.mark.parametrize(("level", "has_info", "has_calls"), [("error", 0, 0), ("info", 1, 0), ("debug", 1, 1)])
def test_the_log_of_the_master_has_what_was_asked_for(
    make_core: Callable[..., Core], tmp_path: Path, free_port: int, level: str, has_info: int, has_calls: int
) -> None:
    core = make_core(log_level=level)
    core.start_master()
    client = MasterClient("/tool", f"http://127.0.0.1:{free_port}/")
    client.has_param("/a")
    client.close()
    core.stop_master()
    log = (tmp_path / "master.log").read_text()
    assert ("[INFO]" in log, "hasParam" in log) == (bool(has_info), bool(has_calls))


def test_a_node_that_does_not_respond_is_given_up_after_the_given_time(
    make_core: Callable[..., Core], tmp_path: Path, free_port: int
) -> None:
    core = make_core(notify_timeout=0.05)
    core.start_master()
    try:
        with socket.create_server(("127.0.0.1", 0)) as silent, ServerProxy(f"http://127.0.0.1:{free_port}/") as master:
            silent.settimeout(DEADLINE)
            api = f"http://127.0.0.1:{silent.getsockname()[1]}/"
            master.registerSubscriber("/silent", "/t", "std_msgs/Empty", api)
            master.registerPublisher("/talker", "/t", "std_msgs/Empty", "http://127.0.0.1:1/")
            connection, _ = silent.accept()
            with connection:
                connection.settimeout(DEADLINE)
                while connection.recv(4096):  # until the master closes it
                    pass
    finally:
        core.stop_master()
    assert "did not answer within 0.05 s" in (tmp_path / "master.log").read_text()


def test_the_process_id_of_a_core_is_noted_where_that_is_possible(tmp_path: Path) -> None:
    write_pid_file({}, 11311, tmp_path / "home")
    assert (tmp_path / "home" / "roscore-11311.pid").read_text() == str(os.getpid())
    write_pid_file({}, 11311, tmp_path / "home" / "roscore-11311.pid")
