"""What a viewer is told, and what is done for it."""

from __future__ import annotations

import json
import math
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.web.foxglove import requests, state_machine
from pyros1.web.foxglove.frames import Frame
from pyros1.web.foxglove.offers import Channel, Nodes, Offers, Service
from pyros1.web.foxglove.parameters import ParameterValues
from pyros1.web.foxglove.state_machine import StateMachine

A = Channel(1, "/a", "std_msgs/Float64", "float64 data\n", "1")
B = Channel(2, "/b", "std_msgs/String", "string data\n", "2")
ADD = Service(9, "/add", "rospy_tutorials/AddTwoInts", "int64 a\nint64 b\n", "int64 sum\n")


def offers(*channels: Channel, services: tuple[Service, ...] = (), **has_pending_queries: Any) -> Offers:
    return Offers(
        {each.topic: each for each in channels}, {each.name: each for each in services}, **has_pending_queries
    )


def text(op: str, **fields: Any) -> str:
    return json.dumps({"op": op, **fields})


def read(found: list[Frame]) -> list[dict[str, Any]]:
    return [json.loads(frame) for frame in found]


def viewer(**options: Any) -> StateMachine:
    found = StateMachine(**options)
    found.update_offers(offers(A, B, services=(ADD,)))
    return found


def test_the_greeting() -> None:
    info, advertise = read(StateMachine().hello("name", "s1", False))
    assert (info["op"], info["name"], info["sessionId"]) == ("serverInfo", "name", "s1")
    wanted = {"clientPublish", "parameters", "parametersSubscribe", "services", "connectionGraph", "assets"}
    assert {*info["capabilities"]} == wanted
    assert info["supportedEncodings"] == ["ros1", "json"]
    assert advertise == {"op": "advertise", "channels": []}
    assert "time" in read(StateMachine().hello("name", "s1", True))[0]["capabilities"]
    read_only = read(StateMachine(read_only=True).hello("name", "s1", False))[0]["capabilities"]
    assert {"clientPublish", "services"}.isdisjoint(read_only)


def test_channels_and_services_come_and_go() -> None:
    one = StateMachine()
    actions, found = one.update_offers(offers(A, services=(ADD,)))
    channels, services = read(found)
    assert not actions
    assert channels["channels"] == [
        {
            "id": 1,
            "topic": "/a",
            "encoding": "ros1",
            "schemaName": "std_msgs/Float64",
            "schema": "float64 data\n",
            "schemaEncoding": "ros1msg",
        }
    ]
    told = services["services"][0]
    assert (told["id"], told["name"], told["requestSchema"]) == (9, "/add", "int64 a\nint64 b\n")
    assert told["response"] == {
        "encoding": "ros1",
        "schemaName": "rospy_tutorials/AddTwoInts_Response",
        "schemaEncoding": "ros1msg",
        "schema": "int64 sum\n",
    }
    assert one.update_offers(offers(A, services=(ADD,))) == ([], [])
    assert read(one.update_offers(offers(A, B))[1])[0]["channels"][0]["topic"] == "/b"
    assert read(one.update_offers(offers(B))[1]) == [{"op": "unadvertise", "channelIds": [1]}]


def test_many_channels_come_in_several_frames() -> None:
    many = [Channel(number, f"/{number}", "t", "s", "m") for number in range(450)]
    found = read(StateMachine().update_offers(offers(*many))[1])
    assert [len(frame["channels"]) for frame in found] == [200, 200, 50]


def test_subscriptions() -> None:
    one = viewer()
    pairs = [{"id": 5, "channelId": 1}, {"id": 6, "channelId": 2}]
    assert one.handle(text("subscribe", subscriptions=pairs)) == (
        [state_machine.Listen(5, A), state_machine.Listen(6, B)],
        [],
    )
    wrong = [{"id": 5, "channelId": 2}, {"id": 7, "channelId": 1}, {"id": 8, "channelId": 99}]
    actions, found = one.handle(text("subscribe", subscriptions=wrong))
    assert not actions
    assert read(found)[0]["message"] == "subscription 5 already exists (and 2 more such problems)"
    assert one.handle(text("unsubscribe", subscriptionIds=[5, 5, 77])) == ([state_machine.StopListening(5)], [])
    assert one.update_offers(offers(A, services=(ADD,)))[0] == [state_machine.StopListening(6)]  # its channel has gone
    again = text("subscribe", subscriptions=[{"id": 6, "channelId": 1}])
    assert one.handle(again)[0] == [state_machine.Listen(6, A)]
    one.remove_subscription(6)
    assert one.handle(again)[0] == [state_machine.Listen(6, A)]


def advertisement(number: int, encoding: str = "ros1") -> dict[str, Any]:
    return {"id": number, "topic": "/cmd", "encoding": encoding, "schemaName": "std_msgs/Float64"}


def test_publishing() -> None:
    one = viewer()
    channel = requests.ClientChannel(3, "/cmd", "ros1", "std_msgs/Float64", "")
    frame = text("advertise", channels=[advertisement(3), advertisement(4, "cdr"), advertisement(3)])
    actions, found = one.handle(frame)
    assert actions == [state_machine.Advertise(channel)]
    assert "not as 'cdr' (and 1 more" in read(found)[0]["message"]
    message = b"\x01" + struct.pack("<I", 3) + b"12345678"
    assert one.handle(message) == ([state_machine.Publish(channel, b"12345678")], [])
    assert one.handle(text("unadvertise", channelIds=[3, 3, 4])) == ([state_machine.Unadvertise(channel)], [])
    actions, found = one.handle(message)
    assert not actions
    assert read(found) == [{"op": "status", "level": 2, "message": "you have not advertised channel 3"}]


def test_a_type_that_the_topic_does_not_have_is_told() -> None:
    one = viewer()
    channel = {**advertisement(3), "topic": "/b", "schemaName": "std_msgs/msg/Float64"}
    actions, found = one.handle(text("advertise", channels=[channel]))
    assert len(actions) == 1
    assert "/b carries std_msgs/String" in read(found)[0]["message"]
    assert one.handle(text("advertise", channels=[{**channel, "id": 4, "topic": "/a"}]))[1] == []


def test_the_number_of_channels_of_a_viewer_is_bounded() -> None:
    one = viewer()
    many = [advertisement(number) for number in range(state_machine.MAX_CLIENT_CHANNELS + 5)]
    actions, found = one.handle(text("advertise", channels=many))
    assert len(actions) == state_machine.MAX_CLIENT_CHANNELS
    assert "(and 4 more" in read(found)[0]["message"]


def call(service: int, encoding: bytes = b"ros1") -> bytes:
    return b"\x02" + struct.pack("<III", service, 4, len(encoding)) + encoding + b"payload"


def test_services() -> None:
    one = viewer()
    assert one.handle(call(9)) == ([state_machine.Call(ADD, 4, "ros1", b"payload")], [])
    for frame, reason in ((call(8), "no service 8"), (call(9, b"cdr"), "not as 'cdr'")):
        actions, found = one.handle(frame)
        assert not actions
        answer = read(found)[0]
        assert (answer["op"], answer["callId"]) == ("serviceCallFailure", 4)
        assert reason in answer["message"]


def test_read_only() -> None:
    one = viewer(read_only=True)
    for frame in (text("advertise", channels=[advertisement(3)]), b"\x01\x00\x00\x00\x00", call(9)):
        actions, found = one.handle(frame)
        assert not actions
        assert "read-only" in read(found)[0]["message"]
    actions, found = one.handle(text("setParameters", parameters=[{"name": "/a", "value": 1}], id="x"))
    assert actions == [requests.GetParameters(("/a",), "x")]  # so that the viewer shows what it is
    assert "read-only" in read(found)[0]["message"]


def test_changes_of_parameters() -> None:
    one = viewer()
    values = ParameterValues({"a": 1, "b": {"c": 2.0, "d": "x"}})
    assert read(one.watch((), values))[0]["parameters"] == [
        {"name": "/a", "value": 1},
        {"name": "/b/c", "value": 2.0, "type": "float64"},
        {"name": "/b/d", "value": "x"},
    ]
    assert one.watch(("/a",), values) == []
    assert read(one.watch(("/b", "/later"), values))[0]["parameters"] == [
        {"name": "/b", "value": {"c": 2.0, "d": "x"}},
        {"name": "/later"},
    ]
    assert one.update_parameters(values) == []
    changed = read(one.update_parameters(ParameterValues({"a": True, "b": {"c": 2.0}, "later": [1, 2]})))[0][
        "parameters"
    ]
    assert changed == [
        {"name": "/a", "value": True},
        {"name": "/b/d"},
        {"name": "/b", "value": {"c": 2.0}},
        {"name": "/later", "value": [1, 2]},
    ]
    assert one.watches_parameters
    one.handle(text("unsubscribeParameterUpdates", parameterNames=["/a"]))
    assert one.update_parameters(ParameterValues({"a": 1, "b": {"c": 2.0}, "later": [1, 2]})) == []
    one.handle(text("unsubscribeParameterUpdates", parameterNames=[]))
    assert not one.watches_parameters


def test_parameters_that_are_equal_but_not_the_same() -> None:
    one = StateMachine()
    first = {"a": [1, 2], "b": math.nan, "c": [math.nan], "d": {}, "e": 1}
    one.watch(tuple(f"/{name}" for name in first), ParameterValues(first))
    assert one.update_parameters(ParameterValues(first)) == []  # told once, although NaN is not equal to itself
    second = {"a": [1.0, 2.0], "b": math.nan, "c": [math.nan], "d": {}, "e": True}
    changed = read(one.update_parameters(ParameterValues(second)))[0]["parameters"]
    assert changed == [
        {"name": "/a", "value": [1.0, 2.0], "type": "float64_array"},
        {"name": "/e", "value": True},
    ]


def test_the_number_of_watched_parameters_is_bounded() -> None:
    one = viewer()
    names = [f"/p{number}" for number in range(state_machine.MAX_WATCHED_PARAMETERS + 5)]
    told, warning = read(one.watch(names, ParameterValues({})))
    assert len(told["parameters"]) == state_machine.MAX_WATCHED_PARAMETERS
    assert "at most" in warning["message"]


def test_the_graph() -> None:
    one = StateMachine()
    one.update_offers(offers(A, nodes=Nodes({"/a": ["/n1"]}, {"/a": ["/n2"], "/b": ["/n2"]}, {"/add": ["/n1"]})))
    first = read(one.handle(text("subscribeConnectionGraph"))[1])[0]
    assert first["publishedTopics"] == [{"name": "/a", "publisherIds": ["/n1"]}]
    assert first["subscribedTopics"] == [
        {"name": "/a", "subscriberIds": ["/n2"]},
        {"name": "/b", "subscriberIds": ["/n2"]},
    ]
    assert first["advertisedServices"] == [{"name": "/add", "providerIds": ["/n1"]}]
    change = read(one.update_offers(offers(A, nodes=Nodes({}, {"/a": ["/n2", "/n3"]}, {})))[1])[0]
    assert change["publishedTopics"] == [{"name": "/a", "publisherIds": []}]
    assert change["subscribedTopics"] == [{"name": "/a", "subscriberIds": ["/n2", "/n3"]}]
    assert (change["removedTopics"], change["removedServices"]) == (["/b"], ["/add"])
    assert one.handle(text("subscribeConnectionGraph")) == ([], [])
    one.handle(text("unsubscribeConnectionGraph"))
    assert one.update_offers(offers(A, nodes=Nodes({}, {}, {}))) == ([], [])


def test_problems_are_told_once_and_taken_back() -> None:
    one = viewer()
    told = [{"op": "status", "level": 1, "message": "gone", "id": "master"}]
    assert read(one.update_problems({"master": "gone"})) == told
    assert one.update_problems({"master": "gone"}) == []
    assert read(one.update_problems({"/a": "?"}))[0] == {"op": "removeStatus", "statusIds": ["master"]}


@pytest.mark.slow
@given(st.binary(max_size=60) | st.text(max_size=60))
def test_any_frame_gives_a_bounded_answer(frame: str | bytes) -> None:
    actions, found = viewer().handle(frame)
    assert len(actions) + len(found) <= 1
    assert sum(map(len, found)) < 1000
