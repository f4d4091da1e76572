"""Frames of viewers, as they should be and as attackers send them."""

from __future__ import annotations

import json
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.web.foxglove import requests
from pyros1.web.foxglove.requests import FrameError, parse


def text(op: str, **fields: Any) -> str:
    return json.dumps({"op": op, **fields})


def test_each_text_frame() -> None:
    assert parse(text("subscribe", subscriptions=[{"id": 0, "channelId": 3}])) == requests.Subscribe(((0, 3),))
    assert parse(text("unsubscribe", subscriptionIds=[0, 1])) == requests.Unsubscribe((0, 1))
    channel = {"id": 1, "topic": "/a", "encoding": "ros1", "schemaName": "std_msgs/Float64"}
    wanted = requests.ClientChannel(1, "/a", "ros1", "std_msgs/Float64", "")
    assert parse(text("advertise", channels=[channel])) == requests.ClientAdvertise((wanted,))
    assert parse(text("unadvertise", channelIds=[1])) == requests.ClientUnadvertise((1,))
    assert parse(text("getParameters", parameterNames=["/a"], id="x")) == requests.GetParameters(("/a",), "x")
    assert parse(text("getParameters", parameterNames=[])) == requests.GetParameters((), None)
    parameter = {"name": "/a", "value": 3, "type": "float64"}
    set_ = requests.SetParameters((requests.SetParameter("/a", 3, "float64"),), None)
    assert parse(text("setParameters", parameters=[parameter])) == set_
    unset = requests.SetParameters((requests.SetParameter("/a", None, ""),), "y")
    assert parse(text("setParameters", parameters=[{"name": "/a"}], id="y")) == unset
    assert parse(text("subscribeParameterUpdates", parameterNames=["/a"])) == requests.WatchParameters(("/a",))
    assert parse(text("unsubscribeParameterUpdates", parameterNames=[])) == requests.UnwatchParameters(())
    assert parse(text("subscribeConnectionGraph")) == requests.WatchGraph()
    assert parse(text("unsubscribeConnectionGraph")) == requests.UnwatchGraph()
    assert parse(text("fetchAsset", uri="package://a/b", requestId=5)) == requests.FetchAsset("package://a/b", 5)


def test_each_binary_frame() -> None:
    assert parse(b"\x01" + struct.pack("<I", 7) + b"abc") == requests.ClientMessage(7, b"abc")
    call = b"\x02" + struct.pack("<III", 1, 2, 4) + b"ros1" + b"xyz"
    assert parse(call) == requests.CallService(1, 2, "ros1", b"xyz")


@pytest.mark.parametrize(
    ("frame", "reason"),
    [
        ("", "JSON"),
        ("[" * 100_000, "JSON"),
        ("[]", "object"),
        ('{"op": 3}', "op"),
        (text("fly"), "unknown op 'fly'"),
        (text("subscribe"), "subscriptions must be a list"),
        (text("subscribe", subscriptions=[3]), "objects"),
        (text("subscribe", subscriptions=[{"id": True, "channelId": 1}]), "id must be a number"),
        (text("unsubscribe", subscriptionIds=[1 << 32]), "number"),
        (text("unsubscribe", subscriptionIds=[-1]), "number"),
        (text("unsubscribe", subscriptionIds=[1.5]), "number"),
        (text("getParameters", parameterNames=[3]), "strings"),
        (text("getParameters", parameterNames=[], id=3), "id must be a string"),
        (text("fetchAsset", uri=3, requestId=1), "uri must be a string"),
        ("x" * (requests.MAX_TEXT_LENGTH + 1), "at most"),
        (b"", "without an opcode"),
        (b"\x09", "unknown binary frame 09"),
        (b"\x01\x00", "cut off"),
        (b"\x02" + struct.pack("<III", 1, 2, 1 << 31), "cut off"),
        (b"\x02" + struct.pack("<III", 1, 2, 1) + b"\xff", "not text"),
    ],
    ids=range(20),
)
def test_what_is_no_request(frame: str | bytes, reason: str) -> None:
    with pytest.raises(FrameError, match=reason):
        parse(frame)


_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=10),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=10), inner, max_size=3),
    max_leaves=8,
)
_OPS = ("subscribe", "unsubscribe", "advertise", "unadvertise", "getParameters", "setParameters", "fetchAsset")
_FIELDS = ("subscriptions", "subscriptionIds", "channels", "channelIds", "parameterNames", "parameters", "id", "uri")


@pytest.mark.slow
@given(
    st.binary(max_size=100)
    | st.text(max_size=100)
    | st.fixed_dictionaries({"op": st.sampled_from(_OPS)}, optional=dict.fromkeys(_FIELDS, _VALUES)).map(json.dumps)
)
def test_any_frame_is_a_request_or_an_error(frame: str | bytes) -> None:
    try:
        parse(frame)
    except FrameError as error:
        assert len(str(error)) < 500
