"""Which topics a bridge finds on its master."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pyros1.bridge.local_graph import STAND_IN_SERVICE, LocalGraph, find_bridges
from pyros1.doctor.bridge_status import STATUS_SERVICE
from pyros1.doctor.facts import Failure, ReportedType
from pyros1.doctor.probe import query_publisher
from pyros1.graph import Graph, SystemState
from pyros1.msgs.std_msgs.msg import Int64, String
from pyros1.node import Node


@pytest.fixture
def asked() -> list[tuple[str, str]]:
    """The publishers' addresses and topics that were asked."""
    return []


@pytest.fixture
def local_graph(make_node: Callable[..., Node], asked: list[tuple[str, str]]) -> LocalGraph:
    def query(caller_id: str, uri: str, topic: str) -> ReportedType:
        asked.append((uri, topic))
        return query_publisher(caller_id, uri, topic)

    node = make_node("bridge")
    return LocalGraph(Graph(node.master), lambda topic: topic != "/secret" and not topic.startswith("/rosout"), query)


def test_bridges_are_recognised_by_their_service() -> None:
    services = {f"/a/{STATUS_SERVICE}": ["/a"], f"/b/{STATUS_SERVICE}": ["/other"], f"/{STATUS_SERVICE}": ["/c"]}
    services[f"/base/talker/{STAND_IN_SERVICE}"] = ["/base/talker"]
    assert find_bridges(SystemState({}, {}, services)) == {"/a", "/base/talker"}


def test_topics_with_types_and_definitions(
    local_graph: LocalGraph, make_node: Callable[..., Node], asked: list[tuple[str, str]]
) -> None:
    left, right = make_node("left"), make_node("right")
    left.advertise("/text", String)
    right.advertise("/text", String, latch=True)
    left.advertise("/secret", String)
    (topic,) = local_graph.topics()
    assert topic[:6] == ("/text", "std_msgs/String", String._md5sum, String._full_text, True, ("/left", "/right"))
    assert sorted(asked) == sorted([(left.uri, "/text"), (right.uri, "/text")])
    local_graph.topics()
    assert len(asked) == 2, "each publisher is asked once"
    right.shutdown()
    assert [(each.latched, each.publishers) for each in local_graph.topics()] == [(False, ("/left",))]


def test_topics_of_bridges_are_left_out(local_graph: LocalGraph, make_node: Callable[..., Node]) -> None:
    bridge, user = make_node("other_bridge"), make_node("user")
    bridge.advertise_service(f"~{STATUS_SERVICE}", "std_srvs/Trigger", lambda _: (True, ""))
    bridge.advertise("/far", String)
    bridge.advertise("/both", String)
    user.advertise("/both", String)
    assert [(topic.name, topic.publishers) for topic in local_graph.topics()] == [("/both", ("/user",))]
    assert local_graph.bridges == {"/other_bridge"}


def test_topics_that_are_used_whether_or_not_they_can_be_sent(
    local_graph: LocalGraph, make_node: Callable[..., Node]
) -> None:
    bridge, user = make_node("other_bridge"), make_node("user")
    bridge.advertise_service(f"~{STATUS_SERVICE}", "std_srvs/Trigger", lambda _: (True, ""))
    bridge.advertise("/far", String)
    bridge.subscribe("/near", String, print)
    bridge.advertise("/both", String)
    user.advertise("/secret", String)
    user.subscribe("/both", String, print)
    user.subscribe("/goal", String, print)
    local_graph.topics()
    assert local_graph.used.published - {"/rosout"} == {"/secret"}
    assert local_graph.used.subscribed == {"/both", "/goal"}


def test_publishers_that_differ(local_graph: LocalGraph, make_node: Callable[..., Node]) -> None:
    make_node("a").advertise("/text", String)
    make_node("b").advertise("/text", Int64)
    (topic,) = local_graph.topics()
    assert topic.type == "std_msgs/String"
    assert local_graph.problems == {"/text": "messages of other types than std_msgs/String are left out"}


def test_publishers_that_do_not_answer(make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch) -> None:
    node = make_node("bridge")
    node.advertise("/text", String)
    answers: list[Any] = [ReportedType(failure=Failure("refused", "no")), ReportedType(), ReportedType("a/B", "1" * 32)]
    now = [100.0]
    monkeypatch.setattr("pyros1.bridge.local_graph.monotonic", lambda: now[0])
    graph = LocalGraph(Graph(node.master), lambda topic: topic == "/text", lambda *_: answers.pop(0))
    assert graph.topics() == [] and graph.problems == {"/text": "its publishers have not reported its type"}
    assert graph.topics() == [] and len(answers) == 2, "it is not asked again at once"
    now[0] += 11
    assert graph.topics() == [], "any type is no type"
    now[0] += 11
    assert [topic.type for topic in graph.topics()] == ["a/B"] and graph.problems == {}


@pytest.mark.parametrize(
    ("type_name", "md5sum", "problem"),
    [
        ("foo", "1" * 32, "not a message type"),
        ("my-pkg/Thing", "1" * 32, "not a message type"),
        ("a/B", "A" * 32, "not an md5 sum"),
        ("a/B", "1" * 31, "not an md5 sum"),
    ],
)
def test_publishers_whose_types_are_not_valid(
    make_node: Callable[..., Node], type_name: str, md5sum: str, problem: str
) -> None:
    """Other sites would refuse the whole list of topics."""
    make_node("a").advertise("/text", String)
    answers = {"/a": ReportedType(type_name, md5sum)}
    node = make_node("bridge")
    graph = Graph(node.master)

    def query(_: str, uri: str, __: str) -> ReportedType:
        return next(answer for name, answer in answers.items() if graph.node_uri(name) == uri)

    local_graph = LocalGraph(graph, lambda topic: topic == "/text", query)
    assert local_graph.topics() == []
    told = f"a publisher reports the type {type_name} with md5 sum {md5sum}: {problem}"
    assert local_graph.problems == {"/text": told}
    make_node("b").advertise("/text", String)
    answers["/b"] = ReportedType("c/D", "2" * 32)
    assert [topic.type for topic in local_graph.topics()] == ["c/D"], "another publisher of the topic is not affected"
    assert local_graph.problems == {"/text": "messages of other types than c/D are left out"}


def test_many_publishers_are_asked_a_few_at_a_time(
    make_node: Callable[..., Node], asked: list[tuple[str, str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    node = make_node("bridge")
    for number in range(40):
        node.advertise(f"/many/t{number}", String)

    def query(_: str, uri: str, topic: str) -> ReportedType:
        asked.append((uri, topic))
        return ReportedType("std_msgs/String", String._md5sum)

    graph = LocalGraph(Graph(node.master), lambda topic: topic.startswith("/many"), query)
    assert len(graph.topics()) == 40 and not graph.is_behind, "there is time for all"
    asked.clear()
    monkeypatch.setattr("pyros1.bridge.local_graph.ASKING_TIME", 0.0)
    graph = LocalGraph(Graph(node.master), lambda topic: topic.startswith("/many"), query)
    assert len(graph.topics()) == 32 and graph.is_behind
    assert len(graph.topics()) == 40 and not graph.is_behind and len(asked) == 40


def test_publishers_that_never_answer_do_not_keep_others_waiting(
    make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    """All topics of a machine that is gone, and that have to be asked for again as soon as all have been asked for."""
    monkeypatch.setattr("pyros1.bridge.local_graph.RETRY_PERIOD", 0.0)
    monkeypatch.setattr("pyros1.bridge.local_graph.ASKING_TIME", 0.0)
    node = make_node("bridge")
    for number in range(40):
        node.advertise(f"/dead{number}", String)
    node.advertise("/text", String)
    failure = ReportedType(failure=Failure("timeout", "no"))
    graph = LocalGraph(
        Graph(node.master),
        lambda topic: not topic.startswith("/ros"),
        lambda _, __, topic: ReportedType("a/B", "1" * 32) if topic == "/text" else failure,
    )
    assert not graph.topics()
    assert [topic.name for topic in graph.topics()] == ["/text"]


def test_a_publisher_that_has_started_again_with_another_type(make_node: Callable[..., Node]) -> None:
    node = make_node("bridge")
    node.advertise("/text", String)
    answers = [ReportedType("a/B", "1" * 32), ReportedType("c/D", "2" * 32)]
    graph = LocalGraph(Graph(node.master), lambda topic: topic == "/text", lambda *_: answers.pop(0))
    for md5sum in ("", "1" * 32, "2" * 32):
        assert [topic.type for topic in graph.topics()] == ["a/B"]
        graph.check_type("/bridge", "/text", md5sum or "1" * 32)
        graph.check_type("/other", "/text", "3" * 32)
    assert [topic.type for topic in graph.topics()] == ["c/D"]


def test_publishers_that_are_lost_are_left_out(local_graph: LocalGraph, make_node: Callable[..., Node]) -> None:
    left, right = make_node("left"), make_node("right")
    for node in (left, right):
        node.advertise("/text", String)
    left.advertise("/own", String)
    local_graph.lost = frozenset({"/left"})
    assert [(topic.name, topic.publishers) for topic in local_graph.topics()] == [("/text", ("/right",))]
    assert local_graph.publishers == {"/left", "/right"}
