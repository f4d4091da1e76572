"""Parameters for other sites: only what the rules allow, with exact types."""

from __future__ import annotations

import datetime
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.bridge.parameters import (
    ParameterError,
    ParameterRequest,
    decode_parameter_request,
    decode_parameter_response,
    encode_json_response,
    encode_parameter_request,
    respond,
)
from pyros1.bridge.rules.parsing import parse_config
from pyros1.ground.errors import ProtocolError, ServiceRefusal
from pyros1.node import Node

RULES = parse_config("params: [/robot_description, '/camera/**']\ndeny_params: [/camera/password]", "f", "red").rules


@pytest.fixture
def ask(make_node: Callable[..., Node]) -> Callable[..., Any]:
    master = make_node("user").master
    master.set_param("/robot_description", "<robot>\n")
    master.set_param("/camera", {"fps": 30, "gain": 1.0, "password": "x", "sub": {"on": True, "data": b"\0\xff"}})
    master.set_param("/secret", {"a": 1})
    return lambda name="": decode_parameter_response(
        respond(RULES, master, encode_parameter_request(ParameterRequest("red", name)))
    )


def test_values(ask: Callable[..., Any]) -> None:
    assert ask("/robot_description") == "<robot>\n"
    assert ask("/camera") == ask("/camera/") == {"fps": 30, "gain": 1.0, "sub": {"on": True, "data": b"\0\xff"}}
    assert type(ask("/camera/gain")) is float and ask("/camera/sub/on") is True
    assert ask("/") == {"robot_description": "<robot>\n", "camera": ask("/camera")}


def test_names(ask: Callable[..., Any]) -> None:
    assert ask() == ["/camera/fps", "/camera/gain", "/camera/sub/data", "/camera/sub/on", "/robot_description"]


@pytest.mark.parametrize("name", ["/secret", "/secret/a", "/none", "/camera/password", "/camera/none"])
def test_others_look_like_missing_ones(ask: Callable[..., Any], name: str) -> None:
    with pytest.raises(ServiceRefusal, match=f"^site red has no parameter {name} that others may read"):
        ask(name)


@pytest.mark.parametrize(
    "body",
    [b"", b"[]", b'["red"]', b'["red", 5]', b'{"red": "/a"}', b'["red", "a"]', b'["red", "/a\\nb"]', b"[" * 5000],
)
def test_requests_that_are_refused(body: bytes, make_node: Callable[..., Node]) -> None:
    with pytest.raises(ParameterError):
        decode_parameter_request(body)
    with pytest.raises(ServiceRefusal):
        respond(RULES, make_node("user").master, body)


@pytest.mark.parametrize("name", ["/a b", "/camera/a.b", "/camera//fps"])
def test_names_that_only_ros2_allows(name: str, make_node: Callable[..., Node]) -> None:
    body = encode_parameter_request(ParameterRequest("red", name))
    assert decode_parameter_request(body).name == name
    with pytest.raises(ServiceRefusal, match="is not the full name of a parameter"):
        respond(RULES, make_node("user").master, body)


def test_plain_answers() -> None:
    for value in (1 << 60, "a\x01", {"gains.p": 1.0, "x": [True]}, [], "[]"):
        assert decode_parameter_response(encode_json_response(value)) == value


def test_answers_that_are_refused() -> None:
    for body in (b"", b"<a/>", b"\xff", b"[", b"[1, 2]", b"[]", b"[" * 100_000, b"[\xff]"):
        with pytest.raises(ProtocolError):
            decode_parameter_response(body)


def test_times_of_parameters(make_node: Callable[..., Node]) -> None:
    master = make_node("user").master
    when = datetime.datetime(2020, 1, 2, 3, 4, 5)
    master.set_param("/camera/when", when)
    assert (
        decode_parameter_response(
            respond(RULES, master, encode_parameter_request(ParameterRequest("red", "/camera/when")))
        )
        is not None
    )
