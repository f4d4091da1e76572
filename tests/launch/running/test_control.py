"""Running launches are asked and told through their server, and shown in a table.

Feature: nodes of a running launch can be stopped, started, restarted -- with a table of pid, CPU, memory, uptime
"""

from __future__ import annotations

import io
import os
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from pyros1.cli.commands.node.status import as_json, format_table
from pyros1.cli.main import entry as entry_point
from pyros1.ground.errors import Error, ProtocolError
from pyros1.launch.running.api import LaunchServer
from pyros1.launch.running.console import Console
from pyros1.launch.running.control import URIS_PARAM, Launch, Status, launch_uris, running_launches, stock_status
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.supervisor import Supervisor
from pyros1.launch.running.usage import group_usages, launch_files, process_age
from pyros1.master.server import Master
from pyros1.net.hosts import addresses_from_environment
from pyros1.net.master_client import MasterClient
from pyros1.net.xmlrpc_client import XmlRpcClient

DEADLINE = 20.0


@pytest.fixture
def launch(tmp_path: Path) -> Iterator[Launch]:
    supervisor = Supervisor(Console(io.StringIO(), io.StringIO()), sigint_timeout=5.0)
    for label, script in (("long-1", "exec sleep 100"), ("short-2", "exit 4")):
        spec = ProcessSpec(label, f"/{label[:-2]}", ["sh", "-c", script], dict(os.environ), str(tmp_path))
        supervisor.start(spec)
    runner = threading.Thread(target=supervisor.run)
    runner.start()
    server = LaunchServer(supervisor, addresses_from_environment({"ROS_HOSTNAME": "localhost"}, {}))
    launch = Launch(server.uri)
    yield launch
    launch.close()
    server.close()
    supervisor.stop()
    runner.join(DEADLINE)
    supervisor.shut_down()


def entry(launch: Launch, label: str) -> Status:
    return next(one for one in launch.status() if one.label == label)


def until(reached: Callable[[], object]) -> None:
    deadline = time.monotonic() + DEADLINE
    while not reached():
        assert time.monotonic() < deadline
        time.sleep(0.01)


@pytest.mark.slow
def test_states_and_orders(launch: Launch) -> None:
    until(lambda: entry(launch, "short-2").state == "died")
    assert entry(launch, "short-2").exit_code == 4
    first = entry(launch, "long-1")
    assert (first.state, first.starts, first.node) == ("running", 1, "/long") and first.uptime >= 0
    launch.request("stop", "/long")
    until(lambda: entry(launch, "long-1").state == "stopped")
    launch.request("start", "/long")
    until(lambda: entry(launch, "long-1").state == "running")
    launch.request("restart", "/long")
    until(lambda: entry(launch, "long-1").starts == 3 and entry(launch, "long-1").state == "running")
    launch.request("start", "/short")
    until(lambda: entry(launch, "short-2").starts == 2)
    launch.request("stop", "long-1")  # by its label, too
    until(lambda: entry(launch, "long-1").state == "stopped")
    for verb, node in (("stop", "/none"), ("explode", "/long")):
        with pytest.raises(Error):
            launch.request(verb, node)


def test_launches_are_found_through_the_master(launch: Launch) -> None:
    master = Master(port=0, bind_host="127.0.0.1", advertised_host="localhost")
    master.start()
    client = MasterClient("/me", master.uri)
    try:
        assert running_launches(client) == []
        client.set_param(f"{URIS_PARAM}/host_a", launch.uri)
        client.set_param(f"{URIS_PARAM}/host_gone", "http://127.0.0.1:1/")
        ((found, entries),) = running_launches(client)
        found.close()
        assert found.uri == launch.uri and {one.node for one in entries} == {"/long", "/short"}
    finally:
        client.close()
        master.stop()


def test_parameters_of_any_shape_do_no_harm(master: Master) -> None:
    client = MasterClient("/me", master.uri)
    try:
        for value in (5, {"a": {"b": 1}, "c": "no uri", "d": 7}):
            client.set_param(URIS_PARAM, value)
            assert running_launches(client) == []
        assert launch_uris(client) == {f"{URIS_PARAM}/c": "no uri"}
        client.set_param(f"{URIS_PARAM}/e", master.uri)  # it answers, but is no launch
        assert running_launches(client) == []
    finally:
        client.close()


@pytest.mark.parametrize("uptime", ["1e999", 1.0])
def test_a_launch_that_talks_nonsense_is_left_out(master: Master, monkeypatch: pytest.MonkeyPatch, uptime: Any) -> None:
    about = {"title": "x", "pid": 1, "uptime": uptime, "expected": 0, "refusal": ""}
    monkeypatch.setattr(XmlRpcClient, "call", lambda *_: [1, "", {"launch": about, "processes": ["no process"]}])
    with pytest.raises(ProtocolError, match="is not the address of a launch"):
        Launch(master.uri).report()


def test_answers_of_a_stock_launch() -> None:
    info = {
        "args": ["/usr/lib/x/y", "__name:=relay", "__log:=/home/me/.ros/log/1/g-relay-2.log"],
        "env": {"ROS_NAMESPACE": "/g"}, "alive": True, "respawn": False, "required": True, "pid": 7,
    }  # fmt: skip
    assert stock_status("g/relay-2", 1, True, info) == Status(
        "g/relay-2", "/g/relay", "running", 7, 1, required=True, log="/home/me/.ros/log/1/g-relay-2"
    )
    assert stock_status("a-1", 3, True, {**info, "alive": False, "respawn": True, "exit_code": 1}).state == "waiting"
    assert stock_status("a-1", 1, False, {**info, "alive": False, "exit_code": 1}).state == "died"
    gone = stock_status("g/sub/a-1", 1, False, {})
    assert (gone.node, gone.state, gone.exit_code) == ("/g/sub/a", "ended", None)
    assert stock_status("master", 1, True, {}).node == "/master"
    odd = stock_status("a-1", 1, True, {"args": [5, None], "env": 7, "pid": "x", "alive": "no"})
    assert (odd.node, odd.pid, odd.log) == ("/a", 0, "")


def test_the_table() -> None:
    before = [Status("a-1", "/a", "running", 7, 3, 10.0, 1.0, 2**20)]
    now = [Status("a-1", "/a", "running", 7, 3, 12.0, 2.0, 2**21), Status("b-2", "/b", "died", 8, 1, exit_code=-11)]
    assert format_table(now, before) == [
        "NODE  STATE       PID     CPU  MEMORY  RESTARTS   UPTIME  MACHINE",
        "/a    running       7  50.0 %  2.0 MB         2  0:00:12  -",
        "/b    died (-11)    -       -       -         0        -  -",
    ]


def test_the_table_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    before = [Status("a-1", "/a", "running", 7, 3, 10.0, 1.0, 2**20)]
    now = [Status("a-1", "/a", "running", 7, 3, 12.0, 2.0, 2**21), Status("b-2", "/b", "died", 8, 1, exit_code=-11)]
    first, second = as_json(now, before)
    assert first == {
        "node": "/a", "state": "running", "exit_code": None, "pid": 7, "cpu": 50.0, "memory": 2**21, "restarts": 2,
        "uptime": 12.0, "machine": "",
    }  # fmt: skip
    assert [second[key] for key in ("exit_code", "pid", "cpu", "memory", "uptime")] == [-11, None, None, None, None]


def test_status_of_no_launch_as_json(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    master = Master(port=0, bind_host="127.0.0.1", advertised_host="localhost")
    master.start()
    monkeypatch.setenv("ROS_MASTER_URI", master.uri)
    try:
        assert entry_point(["pyros1", "node", "status", "--json"]) == 0
    finally:
        master.stop()
    assert capsys.readouterr() == ("[]\n", "")


def test_usage_of_a_group_is_summed_up(tmp_path: Path) -> None:
    tail = "0 0 0 0 0 0 0 {ticks} 0 0 0 0 0 0 0 0 0 {pages} 0"
    for pid, group, ticks, pages in ((1, 1, 100, 3), (2, 1, 50, 4), (3, 3, 7, 1)):
        (tmp_path / str(pid)).mkdir()
        stat = f"{pid} (a (b) c) S 0 {group} 0 " + tail.format(ticks=ticks, pages=pages)
        (tmp_path / str(pid) / "stat").write_text(stat)
    usages = group_usages(tmp_path)
    assert usages[1].cpu == 150 / os.sysconf("SC_CLK_TCK")
    assert usages[1].memory == 7 * os.sysconf("SC_PAGE_SIZE")
    assert set(usages) == {1, 3}


def test_age_and_files_of_a_process_of_others(tmp_path: Path) -> None:
    (tmp_path / "7").mkdir()
    (tmp_path / "7" / "cmdline").write_bytes(
        b"/usr/bin/python3\0/usr/bin/roslaunch\0-v\0/home/me/a.launch\0b.launch\0x:=1\0"
    )
    (tmp_path / "7" / "stat").write_text("nonsense")
    assert launch_files(7, tmp_path) == "a.launch,b.launch"
    assert launch_files(8, tmp_path) == ""
    assert process_age(7, tmp_path) == process_age(8, tmp_path) == -1.0
    if Path("/proc/self/stat").exists():
        assert 0 <= process_age(os.getpid()) < 1e6
