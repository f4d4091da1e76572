"""What there is at the ROS 2 side, from tokens that come and go."""

from __future__ import annotations

import random
from collections import Counter

import pytest

from pyros1.ros2.zenoh.graph import Changes, HashedType, Ros2Graph, Service, Topic
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2.zenoh.tokens import Entity, Kind, encode_token

OWN = "b0b"
NODE = Entity(3, "a11ce", 0, 0, Kind.NODE, "talker")
PUBLISHER = Entity(3, "a11ce", 0, 1, Kind.PUBLISHER, "talker", "/", "/", "/chatter", "std_msgs/msg/String", "RIHS01_1")
SUBSCRIBER = PUBLISHER._replace(zid="ca401", kind=Kind.SUBSCRIBER, node_name="listener", qos=Qos(False, False, 1))
SERVICE = PUBLISHER._replace(kind=Kind.SERVICE, entity_id=2, topic="/add", type="a/srv/Add")
CLIENT = SERVICE._replace(zid="ca401", kind=Kind.CLIENT, node_name="listener")
ALL = [NODE, PUBLISHER, SUBSCRIBER, SERVICE, CLIENT]


@pytest.fixture
def graph() -> Ros2Graph:
    return Ros2Graph(3, OWN)


def add(graph: Ros2Graph, *entities: Entity) -> list[bool]:
    return [graph.add(encode_token(entity)) for entity in entities]


def test_all_kinds(graph: Ros2Graph) -> None:
    assert all(add(graph, *reversed(ALL)))
    assert graph.nodes() == (NODE,)
    assert graph.topics() == {"/chatter": Topic((PUBLISHER,), (SUBSCRIBER,))}
    assert graph.services() == {"/add": Service((SERVICE,), (CLIENT,))}
    assert graph.topic("/chatter") == Topic((PUBLISHER,), (SUBSCRIBER,))
    assert graph.service("/add") == Service((SERVICE,), (CLIENT,))
    assert graph.topic("/add") == Topic() and graph.service("/chatter") == Service()
    assert graph.topic("/chatter").types == (HashedType("std_msgs/msg/String", "RIHS01_1"),)
    assert graph.service("/add").types == (HashedType("a/srv/Add", "RIHS01_1"),)


def test_what_goes_leaves_nothing(graph: Ros2Graph) -> None:
    add(graph, *ALL)
    assert all(graph.remove(encode_token(entity)) for entity in ALL)
    assert graph.nodes() == () and graph.topics() == {} and graph.services() == {}
    assert not any(graph.remove(encode_token(entity)) for entity in ALL)
    graph.take_changes()
    assert vars(graph) == vars(Ros2Graph(3, OWN))  # sessions come and go for ever
    assert all(add(graph, *ALL))


def test_order(graph: Ros2Graph) -> None:
    late = PUBLISHER._replace(entity_id=10)
    add(graph, late, PUBLISHER, NODE._replace(node_name="z"), NODE._replace(namespace="/b"), NODE)
    add(graph, PUBLISHER._replace(topic="/a"))
    assert graph.topic("/chatter").publishers == (PUBLISHER, late)
    assert list(graph.topics()) == ["/a", "/chatter"]
    assert [node.full_node_name for node in graph.nodes()] == ["/b/talker", "/talker", "/z"]


def test_ignored_tokens(graph: Ros2Graph) -> None:
    assert add(graph, PUBLISHER._replace(zid=OWN), PUBLISHER._replace(domain=4)) == [False, False]
    assert not graph.add("nonsense")
    assert add(graph, PUBLISHER, PUBLISHER) == [True, False]
    assert graph.topics() == {"/chatter": Topic((PUBLISHER,))}
    assert graph.refused == 0
    assert graph.take_changes() == Changes(topics=frozenset(["/chatter"]))


def test_different_types(graph: Ros2Graph) -> None:
    other = SUBSCRIBER._replace(type="std_msgs/msg/Int32")
    old = CLIENT._replace(hash="TypeHashNotSupported")
    add(graph, *ALL, other, old)
    string = HashedType("std_msgs/msg/String", "RIHS01_1")
    assert graph.topic("/chatter").types == (HashedType("std_msgs/msg/Int32", "RIHS01_1"), string)
    assert graph.service("/add").types == (
        HashedType("a/srv/Add", "RIHS01_1"),
        HashedType("a/srv/Add", "TypeHashNotSupported"),
    )
    graph.remove(encode_token(other))
    assert graph.topic("/chatter").types == (string,)


def test_changes(graph: Ros2Graph) -> None:
    assert graph.take_changes() == Changes()
    add(graph, PUBLISHER, SERVICE)
    assert graph.take_changes() == Changes(frozenset(["/chatter"]), frozenset(["/add"]))
    assert graph.take_changes() == Changes()
    add(graph, NODE, CLIENT, SUBSCRIBER)
    assert graph.take_changes() == Changes(frozenset(["/chatter"]), frozenset(["/add"]), nodes=True)
    graph.remove(encode_token(PUBLISHER))
    assert graph.take_changes() == Changes(frozenset(["/chatter"]))
    graph.remove(encode_token(NODE))
    assert graph.take_changes() == Changes(nodes=True)


def test_changes_are_bounded() -> None:
    graph = Ros2Graph(3, OWN, max_entities=4)
    for number in range(4):
        for entity in (PUBLISHER, SERVICE)[number % 2 :][:1]:
            token = encode_token(entity._replace(topic=f"/t{number}"))
            assert graph.add(token) and graph.remove(token)
    assert not graph.take_changes().everything
    for number in range(5):
        token = encode_token((PUBLISHER, SERVICE)[number % 2]._replace(topic=f"/t{number}"))
        assert graph.add(token) and graph.remove(token)
    add(graph, NODE, PUBLISHER)
    assert graph.take_changes() == Changes(nodes=True, everything=True)
    add(graph, SUBSCRIBER)
    assert graph.take_changes() == Changes(frozenset(["/chatter"]))


def test_room_of_all() -> None:
    graph = Ros2Graph(3, OWN, max_entities=2)
    assert add(graph, NODE, SUBSCRIBER, PUBLISHER, PUBLISHER) == [True, True, False, False]
    assert graph.refused == 1
    graph.remove(encode_token(NODE))
    assert graph.topics() == {"/chatter": Topic((PUBLISHER,), (SUBSCRIBER,))}, "it has waited for room"
    assert add(graph, PUBLISHER, NODE) == [False, False]


def test_room_of_one_session() -> None:
    graph = Ros2Graph(3, OWN, max_session_entities=2)
    assert add(graph, NODE, PUBLISHER, SERVICE, CLIENT, SUBSCRIBER) == [True, True, False, True, True]
    assert graph.refused == 1
    graph.remove(encode_token(CLIENT))
    assert not graph.service("/add").servers, "the room is that of another session"
    graph.remove(encode_token(NODE))
    assert graph.service("/add").servers == (SERVICE,)


def test_what_is_gone_does_not_wait_for_room() -> None:
    graph = Ros2Graph(3, OWN, max_entities=1)
    assert add(graph, NODE, SERVICE, SUBSCRIBER) == [True, False, False]
    assert not graph.remove(encode_token(SERVICE))
    assert graph.remove(encode_token(NODE))
    assert not graph.services() and graph.topic("/chatter").subscribers == (SUBSCRIBER,)
    assert graph.remove(encode_token(SUBSCRIBER)) and not graph.topics()


def test_those_who_wait_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.ros2.zenoh.graph.MAX_WAITING", 1)
    graph = Ros2Graph(3, OWN, max_entities=1)
    assert add(graph, NODE, SERVICE, SUBSCRIBER) == [True, False, False] and graph.refused == 2
    graph.remove(encode_token(NODE))
    graph.remove(encode_token(SERVICE))
    assert not graph.topics()
    assert add(graph, SUBSCRIBER) == [True]


@pytest.mark.slow
def test_any_order_of_coming_and_going() -> None:
    """The graph always has as many of the present tokens as there is room for."""
    chance = random.Random(7)
    graph = Ros2Graph(3, OWN, max_entities=25, max_session_entities=8)
    present: dict[str, Entity] = {}
    was_full = False
    for _ in range(2000):
        kind = chance.choice(list(Kind))
        entity = Entity(3, f"a{chance.randrange(5)}", 0, chance.randrange(3), kind, f"n{chance.randrange(2)}")
        if kind is not Kind.NODE:
            type_ = "a/msg/B" if kind in (Kind.PUBLISHER, Kind.SUBSCRIBER) else "a/srv/B"
            entity = entity._replace(topic=f"/t{chance.randrange(3)}", type=type_, hash="RIHS01_1")
        token = encode_token(entity)
        if chance.random() < 0.6:
            graph.add(token)
            present[token] = entity
        else:
            graph.remove(token)
            present.pop(token, None)
        shown = [*graph.nodes()]
        for topic in graph.topics().values():
            assert topic.publishers or topic.subscribers
            shown += [*topic.publishers, *topic.subscribers]
        for service in graph.services().values():
            assert service.servers or service.clients
            shown += [*service.servers, *service.clients]
        sizes = Counter(each.zid for each in shown)
        assert len({*shown}) == len(shown) <= 25 and max(sizes.values(), default=0) <= 8
        missing = {*present.values()} - {*shown}
        assert {*shown} <= {*present.values()}
        assert len(shown) == 25 or all(sizes[each.zid] == 8 for each in missing)
        was_full = was_full or (len(shown) == 25 and bool(missing))
    assert was_full
