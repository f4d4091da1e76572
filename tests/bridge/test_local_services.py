"""Which services a bridge finds on its master."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from pyros1.bridge import local_services
from pyros1.bridge.local_services import LocalServices
from pyros1.graph import Graph, SystemState, probe_service
from pyros1.msgs.std_srvs.srv import SetBool, Trigger
from pyros1.node import Node


@pytest.fixture
def asked() -> list[str]:
    """The services whose providers were asked."""
    return []


@pytest.fixture
def graph(make_node: Callable[..., Node]) -> Graph:
    return Graph(make_node("bridge").master)


@pytest.fixture
def services(graph: Graph, asked: list[str]) -> LocalServices:
    def probe(name: str, uri: str, caller_id: str, timeout: float) -> dict[str, str]:
        asked.append(name)
        return probe_service(name, uri, caller_id, timeout)

    return LocalServices(graph, lambda name: name.startswith("/add"), probe)


def test_services_with_types(
    services: LocalServices, graph: Graph, make_node: Callable[..., Node], asked: list[str]
) -> None:
    node = make_node("robot")
    node.advertise_service("/add", Trigger, lambda _: (True, ""))
    node.advertise_service("/secret", Trigger, lambda _: (True, ""))
    make_node("far").advertise_service("/add_far", Trigger, lambda _: (True, ""))
    (found,) = services.services(graph.state(), {"/far"})
    types = ("std_srvs/Trigger", Trigger._md5sum, "std_srvs/TriggerRequest", "std_srvs/TriggerResponse")
    assert found == ("/add", *types, "/robot")
    services.services(graph.state(), {"/far"})
    assert asked == ["/add"], "each provider is asked once"
    assert not services.services(SystemState({}, {}, {}), set())


def test_a_provider_that_starts_again_with_another_type(
    services: LocalServices, graph: Graph, make_node: Callable[..., Node]
) -> None:
    first = make_node("robot")
    first.advertise_service("/add", Trigger, lambda _: (True, ""))
    assert services.services(graph.state(), ())[0].type == "std_srvs/Trigger"
    first.shutdown()
    make_node("robot").advertise_service("/add", SetBool, lambda _: (True, ""))
    assert services.services(graph.state(), ())[0].type == "std_srvs/Trigger"
    services.check("/add")
    assert services.services(graph.state(), ())[0].type == "std_srvs/SetBool"


@pytest.mark.parametrize(
    "header", [{}, {"type": "std_srvs/Trigger"}, {"type": "*", "md5sum": "a" * 32}, {"type": "a/B", "md5sum": "*"}]
)
def test_providers_that_do_not_say_their_type(
    graph: Graph, make_node: Callable[..., Node], header: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    make_node("robot").advertise_service("/add", Trigger, lambda _: (True, ""))
    services = LocalServices(graph, lambda name: name == "/add", lambda *_: header)
    assert services.services(graph.state(), ()) == []
    assert services.problems == {"/add": "/robot does not report its type"}
    header.update(type="std_srvs/Trigger", md5sum="a" * 32)
    assert services.services(graph.state(), ()) == [], "it is not asked again at once"
    monkeypatch.setattr(local_services, "RETRY_PERIOD", 0.0)
    (found,) = services.services(graph.state(), ())
    assert found.request == "std_srvs/TriggerRequest" and not services.problems


def test_providers_that_never_answer_do_not_keep_others_waiting(graph: Graph, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(local_services, "RETRY_PERIOD", 0.0)
    monkeypatch.setattr(graph, "service_uri", lambda service: service)

    def probe(name: str, *_: object) -> dict[str, str]:
        return {"type": "a/B", "md5sum": "1" * 32} if name == "/text" else {}

    services = LocalServices(graph, lambda _: True, probe)
    state = SystemState({}, {}, {name: ["/robot"] for name in (*(f"/dead{number}" for number in range(40)), "/text")})
    assert not services.services(state, ())
    assert [service.name for service in services.services(state, ())] == ["/text"]
