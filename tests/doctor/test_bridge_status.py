"""How bridges are found and asked: by any program that has a node's service, with answers of any kind."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from pyros1.doctor.bridge_status import call_trigger, fetch_statuses, find_providers, parse_status
from pyros1.graph import Graph, SystemState
from pyros1.ground.errors import ServiceError, ServiceUnavailableError
from pyros1.node import Node


def test_only_services_below_the_own_name_count() -> None:
    services = {"/a/bridge_status": ["/a"], "/b/bridge_status": ["/other"], "/bridge_status": ["/c"]}
    assert find_providers(SystemState({}, {}, services), "bridge_status") == ["/a"]


def test_a_status_is_fetched_without_a_node(make_node: Callable[..., Node]) -> None:
    text = '{"site": "' + "ä" * 100_000 + '"}'
    node = make_node("bridge")
    node.advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, text))
    make_node("other").advertise_service("~bridge_status", "std_srvs/SetBool", lambda _: (True, text))
    graph = Graph(node.master)
    found = fetch_statuses(graph, graph.state())
    assert found["/bridge"] == {"site": "ä" * 100_000}
    assert isinstance(found["/other"], ServiceError), "it has another type"


def test_calls_that_fail(make_node: Callable[..., Node], closed_port: int) -> None:
    node, end = make_node("bridge"), threading.Event()

    def refuse(_: object) -> None:
        raise RuntimeError("out of order")

    def hang(_: object) -> tuple[bool, str]:
        end.wait(10)
        return True, ""

    node.advertise_service("/refuse", "std_srvs/Trigger", refuse)
    node.advertise_service("/hang", "std_srvs/Trigger", hang)
    uri = node.master.lookup_service("/refuse")
    with pytest.raises(ServiceError, match="out of order"):
        call_trigger("/refuse", uri, "/test")
    with pytest.raises(ServiceUnavailableError):
        call_trigger("/hang", uri, "/test", timeout=0.2)
    end.set()
    with pytest.raises(ServiceError):
        call_trigger("/nowhere", uri, "/test")
    with pytest.raises(ServiceUnavailableError):
        call_trigger("/a", f"rosrpc://127.0.0.1:{closed_port}", "/test")


@pytest.mark.parametrize("text", ["", "5", "[]", "{}", '{"site": 5}', "[" * 100_000, '{"site": "' + "x" * (8 << 20)])
def test_what_is_not_a_status(text: str) -> None:
    with pytest.raises(ServiceError):
        parse_status(text)
