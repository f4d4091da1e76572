"""Messages of rcl_interfaces: against those that rosbags encodes, and with the hashes that ROS 2 Kilted has."""

from __future__ import annotations

import random
from contextlib import suppress

import pytest

from pyros1.ground.errors import MessageError
from pyros1.ros2.bridge.parameters.messages import Descriptor, ParameterMessages

from .fake_node import EVENT_HASH, HASHES, Encoding


@pytest.fixture(scope="module")
def messages() -> ParameterMessages:
    return ParameterMessages()


@pytest.fixture(scope="module")
def encoding() -> Encoding:
    return Encoding()


def test_hashes(messages: ParameterMessages) -> None:
    assert messages.hashes == HASHES and messages.event_hash == EVENT_HASH


def test_requests(messages: ParameterMessages, encoding: Encoding) -> None:
    def read(name: str, body: bytes) -> object:
        return encoding.store.deserialize_cdr(body, f"rcl_interfaces/msg/{name}_Request")

    listed = vars(read("ListParameters", messages.list_request()))
    assert (listed["prefixes"], listed["depth"]) == ([], 0), "those of all depths"
    names = vars(read("GetParameters", messages.names_request("get_parameters", ["a", "ö.p"])))
    assert names["names"] == ["a", "ö.p"]
    values: dict[str, bool | int | float | str] = {"flag": True, "count": -(1 << 31), "gain": 0.5, "text": "x"}
    asked = vars(read("SetParameters", messages.set_parameters_request(values)))["parameters"]
    assert {each.name: encoding.read(each.value) for each in asked} == values


VALUES = [True, 1 << 62, -0.5, "tëxt", b"\0\xff", [True, False], [-(1 << 63), 5], [0.5], ["a", ""], None]


def test_values(messages: ParameterMessages, encoding: Encoding) -> None:
    body = encoding.encode(encoding.make("msg/GetParameters_Response", [encoding.value(each) for each in VALUES]))
    read = messages.values(body)
    assert read == [[*each] if isinstance(each, bytes) else each for each in VALUES]
    assert [type(each) for each in read[:4]] == [bool, int, float, str]
    unknown = encoding.encode(
        encoding.make("msg/GetParameters_Response", [encoding.value(1, kind) for kind in (10, 255)])
    )
    assert messages.values(unknown) == [None, None]


def test_descriptors(messages: ParameterMessages, encoding: Encoding) -> None:
    said = {"text": "how fast.", "constraints": "odd", "integers": (1, 9), "doubles": (0.5, 2.0), "read_only": True}
    described = [encoding.descriptor("a", said, 1), encoding.descriptor("b", {}, 1)]
    body = encoding.encode(encoding.make("msg/DescribeParameters_Response", described))
    assert messages.descriptors(body) == [
        Descriptor("a", "how fast. odd", True, (1, 9), (0.5, 2.0)),
        Descriptor("b", "", False, None, None),
    ]


def test_events(messages: ParameterMessages, encoding: Encoding) -> None:
    assert messages.event(encoding.event("/n", {}, {"a": 1, "b": [1.0]}, {})) == ("/n", {"a": 1, "b": [1.0]}, False)
    assert messages.event(encoding.event("/n", {"a": 1}, {}, {})) == ("/n", {}, True)
    assert messages.event(encoding.event("/n", {}, {}, {"a": 1})).has_others


def test_damaged_messages(messages: ParameterMessages, encoding: Encoding) -> None:
    good = encoding.encode(encoding.make("msg/GetParameters_Response", [encoding.value(each) for each in VALUES]))
    chance = random.Random(5)
    for _ in range(300):
        damaged = bytearray(good[: chance.randrange(len(good) + 1)])
        for _ in range(chance.randrange(3)):
            if damaged:
                damaged[chance.randrange(len(damaged))] = chance.randrange(256)
        with suppress(MessageError):
            messages.values(bytes(damaged))
    with pytest.raises(MessageError, match="too large"):
        messages.values(good + bytes(4 << 20))
