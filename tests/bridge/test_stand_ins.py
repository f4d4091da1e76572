"""Nodes that stand in for those of other sites: they come, go, and never take the name of a node that runs here."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.bridge.exchange.actions import RepresentNode
from pyros1.bridge.local_graph import find_bridges
from pyros1.bridge.stand_ins import StandIns
from pyros1.graph import Graph
from pyros1.net.master_client import MasterClient
from pyros1.node import Node

from .conftest import wait_until

MakeNode = Callable[..., Node]
TALKER = RepresentNode("/red/talker", "red", "/talker")
RESEND_REFUSAL = RepresentNode("/red/talker", "", "")


@pytest.fixture
def bridge(make_node: MakeNode) -> Node:
    return make_node("bridge")


@pytest.fixture
def stand_ins(bridge: Node, monkeypatch: pytest.MonkeyPatch) -> Iterator[StandIns]:
    monkeypatch.setattr("pyros1.bridge.stand_ins.RETRY_PERIOD", 0.0)
    stand_ins = StandIns(bridge)
    yield stand_ins
    stand_ins.close()


def uri(bridge: Node) -> str | None:
    """Return the URI of the node that stands in for the talker."""
    return Graph(bridge.master).node_uri("/red/talker")


def test_a_node_comes_and_goes(stand_ins: StandIns, bridge: Node) -> None:
    stand_ins.note(TALKER)
    assert uri(bridge) is None
    stand_ins.update()
    assert bridge.service("/red/talker/bridged_node", "std_srvs/Trigger")().message == "/talker of site red"
    state = Graph(bridge.master).state()
    assert find_bridges(state) == {"/red/talker"}, "bridges send nothing of it"
    assert not any("/red/talker" in nodes for nodes in state.publishers.values())
    provided = {service for service, nodes in state.services.items() if "/red/talker" in nodes}
    assert provided == {"/red/talker/bridged_node"}, "the others are the real node's"
    stand_ins.note(RESEND_REFUSAL)
    stand_ins.update()
    assert uri(bridge) is None


def test_a_node_that_was_replaced_gets_another_one(stand_ins: StandIns, bridge: Node) -> None:
    stand_ins.note(TALKER)
    stand_ins.update()
    before = uri(bridge)
    stand_ins.update()
    assert uri(bridge) == before
    for action in (RESEND_REFUSAL, TALKER):
        stand_ins.note(action)
    stand_ins.update()
    assert uri(bridge) not in (None, before)


def test_a_node_here_keeps_its_name(stand_ins: StandIns, bridge: Node, make_node: MakeNode) -> None:
    own = make_node("talker", namespace="/red")
    stand_ins.note(TALKER)
    stand_ins.update()
    assert uri(bridge) == own.uri and own.ok()
    own.shutdown()
    stand_ins.update()
    assert uri(bridge) not in (None, own.uri)


def test_a_node_that_starts_here_takes_its_name(stand_ins: StandIns, bridge: Node, make_node: MakeNode) -> None:
    stand_ins.note(TALKER)
    stand_ins.update()
    own = make_node("talker", namespace="/red")
    for _ in range(3):
        stand_ins.update()
    assert uri(bridge) == own.uri and own.ok()
    own.shutdown()

    def is_back() -> bool:
        stand_ins.update()
        return uri(bridge) not in (None, own.uri)

    wait_until(is_back, "and gives it back")  # the node here may still be shutting down


def test_a_registration_that_is_left_of_a_dead_node_does_not_count(
    stand_ins: StandIns, bridge: Node, closed_port: int
) -> None:
    dead = f"http://127.0.0.1:{closed_port}/"
    master = MasterClient("/red/talker", bridge.master_uri)
    master.register_publisher("/x", "std_msgs/String", dead)
    master.close()
    stand_ins.note(TALKER)
    stand_ins.update()
    assert uri(bridge) not in (None, dead)


def test_not_all_start_at_once(stand_ins: StandIns, bridge: Node, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.stand_ins.MAX_STARTS", 2)
    for number in range(5):
        stand_ins.note(RepresentNode(f"/red/n{number}", "red", f"/n{number}"))
    counts = []
    for _ in range(3):
        stand_ins.update()
        counts.append(len(find_bridges(Graph(bridge.master).state())))
    assert counts == [2, 4, 5]


def test_a_node_that_starts_while_all_end(stand_ins: StandIns, bridge: Node, monkeypatch: pytest.MonkeyPatch) -> None:
    """The thread that starts nodes may wait for a slow master meanwhile."""
    stand_ins.note(TALKER)
    stand_ins.update()
    advertise_service = Node.advertise_service

    def close_first(node: Node, *arguments: Any) -> Any:
        closing = threading.Thread(target=stand_ins.close)
        closing.start()
        closing.join()
        return advertise_service(node, *arguments)

    monkeypatch.setattr(Node, "advertise_service", close_first)
    for name in ("listener", "other"):
        stand_ins.note(RepresentNode(f"/red/{name}", "red", f"/{name}"))
    stand_ins.update()
    assert find_bridges(Graph(bridge.master).state()) == frozenset()
