"""The launcher's XML-RPC interface (X92, X81)."""

from __future__ import annotations

import io
import os
import socket
import time
from pathlib import Path

import pytest

from pyros1.ground.errors import XmlRpcFault
from pyros1.launch.plan import ExitPolicy
from pyros1.launch.running.api import LaunchServer
from pyros1.launch.running.console import Console
from pyros1.launch.running.process import Process
from pyros1.launch.running.process_spec import ProcessSpec
from pyros1.launch.running.supervisor import Supervisor
from pyros1.net.hosts import LocalAddress
from pyros1.net.xmlrpc_client import XmlRpcClient


def test_questions_about_processes(tmp_path: Path) -> None:
    supervisor = Supervisor(Console(io.StringIO(), io.StringIO()), sigint_timeout=0.1, sigterm_timeout=0.1)
    server = LaunchServer(supervisor, LocalAddress("localhost", "127.0.0.1", socket.AF_INET))
    client = XmlRpcClient(server.uri)
    words = ["/bin/sleep", "60"]  # unlike an interpreter that is just starting, it dies of the signal itself
    try:
        supervisor.start(ProcessSpec("ns/a-1", "/ns/a", words, dict(os.environ), str(tmp_path), str(tmp_path / "a")))
        assert server.param_name() == f"/roslaunch/uris/host_localhost__{server.uri.rstrip('/').rpartition(':')[2]}"
        assert client.call("get_pid") == [1, str(os.getpid()), os.getpid()]
        assert client.call("list_processes") == [1, "processes on parent machine", [[["ns/a-1", 1]], []]]
        assert client.call("get_node_names") == [1, "node names", ["ns/a-1"]]
        assert client.call("list_children") == [1, "roslaunch children", []]
        code, _, info = client.call("process_info", "ns/a-1")
        assert (code, info["alive"], info["spawn_count"], info["pid"]) == (1, True, 1, supervisor.active[0].pid)
        assert client.call("process_info", "nope")[0] == -1
        for wrong in ([], {}, 5):
            assert client.call("control", wrong, "ns/a-1")[0] == client.call("process_info", wrong)[0] == -1
        with pytest.raises(XmlRpcFault):
            client.call("no_such_method")
        supervisor.shut_down()
        assert client.call("list_processes")[2] == [[], [["ns/a-1", 1]]]
        assert client.call("process_info", "ns/a-1")[2]["exit_code"] < 0
    finally:
        supervisor.shut_down()
        client.close()
        server.close()


def test_the_states_of_processes(tmp_path: Path) -> None:
    supervisor = Supervisor(Console(io.StringIO(), io.StringIO()), sigint_timeout=0.1, sigterm_timeout=0.1)
    server = LaunchServer(supervisor, LocalAddress("localhost", "127.0.0.1", socket.AF_INET))
    client = XmlRpcClient(server.uri)

    def states() -> list[str]:
        return [node["state"] for node in client.call("status")[2]["processes"]]

    try:
        for name in "abc":
            supervisor.start(
                ProcessSpec(f"{name}-1", f"/{name}", ["/bin/sleep", "60"], dict(os.environ), str(tmp_path))
            )
        stopping, restarting, _ = supervisor.active
        stopping.stopped_by_user, restarting.is_restarting = True, True
        assert states() == ["stopping", "stopping", "running"]
        policy = ExitPolicy(respawn=True)
        supervisor.start(ProcessSpec("d-1", "/d", ["/bin/true"], dict(os.environ), str(tmp_path), exit_policy=policy))
        ended = supervisor.find("/d")
        assert ended.wait(time.monotonic() + 20)
        assert states()[3:] == ["waiting"]
        ended.stopped_by_user = True
        assert states()[3:] == ["stopped"]
        supervisor.start(ProcessSpec("e-1", "/e", ["/bin/false"], dict(os.environ), str(tmp_path)))
        supervisor.start(ProcessSpec("f-1", "/f", ["/bin/true"], dict(os.environ), str(tmp_path)))
        supervisor.keep_running = True
        deaths: list[str] = []

        def on_death(process: Process) -> None:
            deaths.append(process.spec.label)
            if {"e-1", "f-1"} <= {*deaths}:
                supervisor.stop()

        supervisor.on_process_exit = on_death
        supervisor.run()
        assert sorted(states()) == ["died", "finished", "running", "stopped", "stopping", "stopping"]
    finally:
        supervisor.shut_down()
        client.close()
        server.close()


def test_who_may_not_control_it_sees_it_but_not_its_secrets(tmp_path: Path) -> None:
    supervisor = Supervisor(Console(io.StringIO(), io.StringIO()), sigint_timeout=0.1, sigterm_timeout=0.1)
    address = LocalAddress("localhost", "127.0.0.1", socket.AF_INET)
    callers: list[tuple[str, int]] = []

    def refuse(connection: socket.socket) -> str:
        callers.append(connection.getpeername())
        return "not for you"

    server = LaunchServer(supervisor, address, "robot.launch", refuse)
    client = XmlRpcClient(server.uri)
    try:
        supervisor.start(ProcessSpec("a-1", "/a", ["/bin/sleep", "60"], {"SECRET": "word"}, str(tmp_path)))
        assert client.call("control", "stop", "/a") == [-1, "not for you", 0]
        assert client.call("process_info", "a-1")[2]["env"] == {}
        launch = client.call("status")[2]["launch"]
        assert (launch["title"], launch["pid"], launch["refusal"]) == ("robot.launch", os.getpid(), "not for you")
        assert callers and callers[0][0] == "127.0.0.1"
        assert not supervisor.find("/a").stopped_by_user
    finally:
        supervisor.shut_down()
        client.close()
        server.close()
