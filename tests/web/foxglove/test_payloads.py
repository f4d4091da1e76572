"""Messages in the encodings of viewers."""

from __future__ import annotations

import json

import pytest

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time
from pyros1.msgs.geometry_msgs.msg import PoseStamped
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.web.foxglove.payloads import check_encoding, decode, encode, message_class
from pyros1.web.foxglove.requests import ClientChannel, FrameError

NOW = Time(7, 8)


def channel(kind: str, schema: str = "") -> ClientChannel:
    return ClientChannel(1, "/a", "ros1", kind, schema)


def test_types() -> None:
    assert message_class(channel("std_msgs/Float64")) is Float64
    assert message_class(channel("std_msgs/msg/Float64")) is Float64
    own = message_class(channel("my_msgs/Pair", "float64 a\nfloat64 b\n"))
    assert own._slot_types == ["float64", "float64"]
    for kind, schema in (("my_msgs/Pair", ""), ("my_msgs/Pair", "float65 a"), ("", ""), ("../x", "float64 a")):
        with pytest.raises(MessageError):
            message_class(channel(kind, schema))


def test_ros1() -> None:
    payload = encode(Float64(2.5), "ros1")
    assert decode(Float64, "ros1", payload, NOW).data == 2.5  # type: ignore[attr-defined]
    assert decode(Float64, "ros1", payload + b"x", NOW).data == 2.5  # type: ignore[attr-defined]
    for cls, wrong in ((Float64, b""), (Float64, payload[:-1]), (String, b"\5\0\0\0text")):
        with pytest.raises(MessageError):
            decode(cls, "ros1", wrong, NOW)


def test_json() -> None:
    text = b'{"header": {"stamp": {"sec": 3, "nsec": 4}, "frame_id": "map"}, "pose": {"position": {"x": 1}}}'
    pose = decode(PoseStamped, "json", text, NOW)
    assert isinstance(pose, PoseStamped)
    assert (pose.header.stamp, pose.header.frame_id, pose.pose.position.x) == (Time(3, 4), "map", 1.0)
    again = json.loads(encode(pose, "json"))
    assert again["header"]["stamp"] == {"sec": 3, "nsec": 4}
    assert decode(PoseStamped, "json", encode(pose, "json"), NOW) == pose
    for wrong in (b"", b"\xff", b"[" * 10_000, b'{"hedder": 1}', b'{"header": {"stamp": {"sec": 1, "x": 2}}}'):
        with pytest.raises(MessageError):
            decode(PoseStamped, "json", wrong, NOW)


def test_encodings() -> None:
    check_encoding("json")
    with pytest.raises(FrameError, match="ros1 or json"):
        check_encoding("cdr")
