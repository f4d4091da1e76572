"""A launch of stock roslaunch, which tells of its nodes but takes no orders; a server stands for it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import pytest

from pyros1.ground.errors import LaunchError, ProtocolError, XmlRpcFault
from pyros1.launch.running.control import URIS_PARAM, Launch, Status, running_launches
from pyros1.master.server import Master
from pyros1.net.loop import Loop
from pyros1.net.master_client import MasterClient
from pyros1.net.xmlrpc_server import XmlRpcServer

LOG = "/home/me/.ros/log/1/g-relay-2"
RUNNING = {
    "args": ["/usr/lib/x/y", "__name:=relay", f"__log:={LOG}.log"],
    "env": {"ROS_NAMESPACE": "/g"},
    "alive": True,
    "pid": os.getpid(),
}
Serve = Callable[[dict[str, Any]], Launch]


@pytest.fixture
def serve() -> Iterator[Serve]:
    """Return a function that serves answers by method, and returns the launch that gives them."""
    loop = Loop("stock")
    opened: list[Any] = []

    def serve(answers: dict[str, Any]) -> Launch:
        def dispatch(method: str, params: Sequence[Any]) -> Any:
            answer = answers.get(method, XmlRpcFault(1, f'method "{method}" is not supported'))
            answer = answer(*params) if callable(answer) else answer
            if isinstance(answer, Exception):
                raise answer
            return answer

        server = XmlRpcServer(loop, dispatch, bind_host="127.0.0.1", advertised_host="localhost")
        launch = Launch(server.uri)
        opened.extend((launch, server))
        return launch

    loop.start()
    yield serve
    for each in opened:
        each.close()
    loop.stop()


def stock(active: list[Any], dead: list[Any], infos: dict[str, Any], pid: Any = 1 << 30) -> dict[str, Any]:
    return {
        "list_processes": [1, "processes on parent machine", [active, dead]],
        "get_pid": [1, "", pid],
        "process_info": lambda label: [1, "", infos[label]] if label in infos else [-1, "no process by that name", {}],
    }


def test_the_nodes_of_a_stock_launch_are_reported(serve: Serve) -> None:
    launch = serve(stock([["g/relay-2", 1]], [["gone-1", 3]], {"g/relay-2": RUNNING}))
    report = launch.report()
    assert (report.title, report.pid, report.uptime, report.expected) == ("a stock roslaunch", 1 << 30, -1.0, 0)
    relay, gone = report.processes
    assert (relay.label, relay.node, relay.state, relay.log) == ("g/relay-2", "/g/relay", "running", LOG)
    assert (relay.uptime >= 0) is os.path.exists("/proc/self/stat")  # it is this process, in truth
    assert gone == Status("gone-1", "/gone", "ended", 0, 3)
    assert "cannot stop or start them" in report.refusal


def test_a_stock_launch_takes_no_orders(serve: Serve) -> None:
    with pytest.raises(LaunchError, match="the launch of /relay cannot stop it: this is a stock roslaunch"):
        serve(stock([], [], {})).request("stop", "/relay")


def test_a_long_list_is_not_asked_for_each_process(serve: Serve, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.launch.running.control.MAX_QUERIED", 1)
    monkeypatch.setattr("pyros1.launch.running.control.MAX_PROCESSES", 3)
    asked: list[str] = []
    answers = stock([[f"n-{number}", 1] for number in range(9)], [], {})
    answers["process_info"] = lambda label: asked.append(label) or [1, "", {}]
    assert [entry.label for entry in serve(answers).status()] == ["n-0", "n-1", "n-2"]
    assert asked == ["n-0"]


@pytest.mark.parametrize("info", [[1, "", "no dictionary"], [0, "error", 0], XmlRpcFault(1, "it has failed"), 5])
def test_what_a_process_does_not_tell_is_unknown(serve: Serve, info: Any) -> None:
    launch = serve({**stock([["relay-2", 1]], [], {}), "process_info": lambda label: info})
    ((entry),) = launch.status()
    assert (entry.node, entry.pid, entry.log) == ("/relay", 0, "")


@pytest.mark.parametrize("wrong", [5, [[], [], []], [[["a-1"]], []], [[[7, 1]], []], [[["a-1", "often"]], []]])
def test_lists_of_another_shape_are_no_launch(serve: Serve, wrong: Any) -> None:
    launch = serve({**stock([], [], {}), "list_processes": [1, "", wrong]})
    with pytest.raises(ProtocolError, match="is not the address of a launch"):
        launch.report()


def test_texts_that_are_too_long_are_cut(serve: Serve) -> None:
    (entry,) = serve(stock([["x" * 5000, 1]], [], {})).status()
    assert entry.label == "x" * 1000 + "..."


def test_an_address_that_is_none_is_left_out(master: Master) -> None:
    client = MasterClient("/test", master.uri)
    client.set_param(URIS_PARAM, {"a": "nonsense", "b": "http://[::"})
    try:
        assert running_launches(client) == []
    finally:
        client.close()
