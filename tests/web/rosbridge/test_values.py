"""Messages as clients see and write them."""

from __future__ import annotations

import json
import math
from typing import Any

import cbor2
import pytest

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time
from pyros1.msgs import Message, from_definition
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Imu, JointState, LaserScan
from pyros1.msgs.std_msgs.msg import Float64, Header, UInt8MultiArray
from pyros1.msgs.visualization_msgs.msg import MarkerArray
from pyros1.web.rosbridge import frames, values

from ...bodies import encode

NOW = Time(5, 6)
ALL = from_definition(
    "test_msgs/All",
    """bool flag
uint8[] bytes
char[3] letters
int8[] small
byte[] octets
uint16[] u16
int64[2] i64
float32[] f32
float64[] f64
bool[] flags
string text
string[] words
time at
duration[] spans
""",
)


def sent(message: Message) -> Message:
    """Return a message as it comes from the network."""
    return values.decode(type(message), encode(message))


def as_json(message: Message) -> Any:
    return json.loads(frames.to_json(sent(message)))


def test_json() -> None:
    from pyros1.ground.timing import Duration

    message = ALL(
        flag=True,
        bytes=b"abc",
        letters=b"xyz",
        small=[-1, 2],
        octets=[-3],
        u16=[1, 65535],
        i64=[-(1 << 62), 3],
        f32=[0.5, math.nan],
        f64=[math.inf, -0.25],
        flags=[True, False],
        text="ä",
        words=["a", "b"],
        at=Time(1, 2),
        spans=[Duration(3, 4)],
    )
    plain = as_json(message)
    assert plain == {
        "flag": True,
        "bytes": "YWJj",
        "letters": "eHl6",
        "small": [-1, 2],
        "octets": [-3],
        "u16": [1, 65535],
        "i64": [-(1 << 62), 3],
        "f32": [0.5, None],
        "f64": [None, -0.25],
        "flags": [True, False],
        "text": "ä",
        "words": ["a", "b"],
        "at": {"secs": 1, "nsecs": 2},
        "spans": [{"secs": 3, "nsecs": 4}],
    }
    again: Any = values.from_client(ALL, plain, NOW)
    assert list(again.f64)[1:] == [-0.25]
    assert math.isnan(again.f64[0])
    assert math.isnan(again.f32[1])
    assert (again.bytes, again.at) == (b"abc", Time(1, 2))
    encode(again)


def test_json_of_messages_that_were_not_received() -> None:
    message = Imu()
    assert frames.to_json(message) == frames.to_json(sent(message))
    assert json.loads(frames.to_json(CompressedImage(data=b"abc")))["data"] == "YWJj"


def test_cbor() -> None:
    scan = LaserScan(ranges=[0.5, math.inf], range_max=2.0)
    found = cbor2.loads(frames.to_cbor(values.for_cbor(sent(scan))))
    assert found["range_max"] == 2.0
    assert (found["ranges"].tag, found["ranges"].value) == (85, b"\x00\x00\x00\x3f\x00\x00\x80\x7f")
    assert cbor2.loads(frames.to_cbor(values.for_cbor(sent(CompressedImage(data=b"abc")))))["data"] == b"abc"
    tags = {
        name: value.tag
        for name, value in cbor2.loads(frames.to_cbor(values.for_cbor(sent(ALL(i64=[1, 2]))))).items()
        if isinstance(value, cbor2.CBORTag)
    }
    assert tags == {"small": 72, "octets": 72, "u16": 69, "i64": 79, "f32": 85, "f64": 86}


def test_headers_that_are_mentioned_get_the_time() -> None:
    """At any depth, and what a stamp lacks; `test_suite.py` has many more."""
    for given in ({}, {"frame_id": "a"}, {"stamp": None}, {"stamp": {}}, {"stamp": {"sec": 5}}):
        message: Any = values.from_client(Imu, {"header": given}, NOW)
        assert message.header.stamp == NOW
        message = values.from_client(MarkerArray, {"markers": [{"header": given}, {}]}, NOW)
        assert [each.header.stamp for each in message.markers] == [NOW, Time()]
    for stamp, expected in (
        ({"secs": 0, "nsecs": 0}, Time()),
        ({"secs": 1, "nsecs": 0}, Time(1, 0)),
        ({"secs": 1}, Time(1, NOW.nsecs)),
    ):
        message = values.from_client(Imu, {"header": {"stamp": stamp}}, NOW)
        assert message.header.stamp == expected
    message = values.from_client(Imu, {}, NOW)
    assert message.header.stamp == Time()


@pytest.mark.parametrize(
    ("cls", "value"),
    [
        (Float64, {"wrong": 1}),
        (Float64, []),
        (Float64, "x"),
        (Float64, {"data": "x"}),
        (Float64, {"data": {}}),
        (CompressedImage, {"data": "YWJjZA"}),
        (CompressedImage, {"data": [256]}),
        (Header, {"stamp": {"secs": "1"}}),
        (Header, {"seq": 1 << 40}),
        (Header, {"frame_id": "\ud800"}),
        (MarkerArray, {"markers": [{"pose": {"position": {"w": 1}}}]}),
        (MarkerArray, {"markers": {}}),
    ],
)
def test_what_does_not_fit(cls: type[Message], value: Any) -> None:
    with pytest.raises(MessageError):
        encode(values.from_client(cls, value, NOW))


@pytest.mark.parametrize(
    ("cls", "is_flat"),
    [
        (Imu, True),
        (LaserScan, True),
        (CompressedImage, True),
        (MarkerArray, False),
        (JointState, False),  # an array of strings
        (UInt8MultiArray, False),  # an array of messages in a nested message
        (ALL, False),
    ],
)
def test_types_whose_conversion_takes_equally_long(cls: type[Message], is_flat: bool) -> None:
    assert values.is_flat(cls) == is_flat


def test_args_as_lists() -> None:
    from pyros1.msgs.rospy_tutorials.srv import AddTwoIntsRequest

    for args in ([1, 2], [{"a": 1, "b": 2}], {"a": 1, "b": 2}):
        assert values.from_args(AddTwoIntsRequest, args, NOW) == AddTwoIntsRequest(1, 2)
    assert values.from_args(AddTwoIntsRequest, [], NOW) == AddTwoIntsRequest(0, 0)
    assert values.from_args(AddTwoIntsRequest, [1], NOW) == AddTwoIntsRequest(1, 0)
    assert values.from_args(AddTwoIntsRequest, [1, 2, 3], NOW) == AddTwoIntsRequest(1, 2)
