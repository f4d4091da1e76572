"""json_form: nothing is lost on the way to JSON and back, and what is wrong is named.

Feature: messages to JSON and back, losslessly -- `topic echo --json`, `topic pub -f`
"""

from __future__ import annotations

import json
import math
from typing import Any

import codec
import pytest

from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import from_definition, load_message
from pyros1.msgs.json_form import emit_json, from_json, to_json


def load(name: str) -> Any:
    return load_message(name)


def samples() -> list[Any]:
    image = load("sensor_msgs/Image")(height=2, encoding="mono8", data=b"\x00\xff\x10")
    image.header.stamp = Time(12, 34)
    transform = load("geometry_msgs/TransformStamped")(child_frame_id="grüße")
    joints = load("sensor_msgs/JointState")(name=["a", "b"], position=[0.1, math.inf], velocity=[-math.inf, 1e300])
    info = load("sensor_msgs/CameraInfo")(K=[float(i) for i in range(9)])
    return [
        image,
        joints,
        info,
        load("tf2_msgs/TFMessage")(transforms=[transform, transform]),
        load("std_msgs/Duration")(Duration(-3, 5)),
        load("std_msgs/UInt64")(2**64 - 1),
        load("std_msgs/Empty")(),
    ]


@pytest.mark.parametrize("message", samples(), ids=lambda message: message._type)
def test_there_and_back(message: Any) -> None:
    text = json.dumps(to_json(message), allow_nan=False)
    assert codec.encode(from_json(type(message), json.loads(text))) == codec.encode(message)


@pytest.mark.parametrize(
    "value",
    [
        from_definition(
            "p/N", "string s\nuint8[] u\nint32[] i\nfloat64[] f\nstring[] l\ntime[] t\nint8[] e\nchar[2] c"
        )(
            s='ä"\n' * 20_000,
            u=bytes(range(256)) * 100,
            i=list(range(20_000)),
            f=[math.nan, 1.0],
            l=["a", "b"],
            t=[Time(1)],
            c=[1, 2],
        ),
        from_definition("p/E", "")(),
        Time(1, 2),
        [],
        True,
    ],
)
def test_the_text_in_pieces_is_what_json_makes_of_it(value: Any) -> None:
    pieces: list[str] = []
    emit_json(pieces.append, value)
    assert "".join(pieces) == json.dumps(to_json(value), ensure_ascii=False)
    assert max(map(len, pieces)) < 200_000


def test_fields_that_are_left_out_at_every_depth() -> None:
    path = load("nav_msgs/Path")(poses=[load("geometry_msgs/PoseStamped")()] * 2)
    pieces: list[str] = []
    emit_json(pieces.append, path, includes=lambda field_type: field_type != "std_msgs/Header")
    assert json.loads("".join(pieces)) == {"poses": [{"pose": to_json(load("geometry_msgs/Pose")())}] * 2}


def test_nan() -> None:
    cls = load("std_msgs/Float64MultiArray")
    back: Any = from_json(cls, json.loads(json.dumps(to_json(cls(data=[math.nan, 1.0])))))
    assert math.isnan(back.data[0]) and back.data[1] == 1.0


def test_whole_numbers_as_texts() -> None:
    """JavaScript has no such numbers beyond 2^53."""
    cls = load("std_msgs/Int64MultiArray")
    back: Any = from_json(cls, {"data": [str(-(2**63)), 5, str(2**63 - 1)]})
    assert list(back.data) == [-(2**63), 5, 2**63 - 1]
    for name, text in (("Int64", "1.0"), ("Int64", "one"), ("Int64", ""), ("UInt64", str(2**64)), ("Int32", "5")):
        with pytest.raises(MessageError):
            codec.encode(from_json(load(f"std_msgs/{name}"), {"data": text}))


def test_a_list_in_a_field_that_is_no_array_is_not_taken_apart() -> None:
    message: Any = from_json(load("std_msgs/Float64"), {"data": ["one"]})
    with pytest.raises(MessageError, match=r"^field data must be float type, not list \['one'\]$"):
        codec.encode(message)


def test_parts_of_a_message_and_words() -> None:
    cls = load("geometry_msgs/PointStamped")
    message: Any = from_json(cls, {"header": "auto", "point": {"x": 1}}, Time(7, 8))
    assert message.header.stamp == Time(7, 8) and message.point.x == 1 and message.point.y == 0.0


def test_values_of_fields() -> None:
    assert to_json((1.5, math.nan), "float64[]") == [1.5, "NaN"]
    assert to_json([1, 2], "uint8[]") == "AQI="
    assert to_json(Time(1, 2), "time") == {"secs": 1, "nsecs": 2}


@pytest.mark.parametrize(
    ("name", "value", "path"),
    [
        ("sensor_msgs/Image", {"data": "no base64!"}, "data"),
        ("geometry_msgs/PointStamped", {"point": {"x": "one"}}, "point.x"),
        ("sensor_msgs/JointState", {"position": [1, "two"]}, "position[1]"),
        ("geometry_msgs/PointStamped", {"point": {"q": 1}}, "point.q"),
        ("geometry_msgs/PointStamped", {"nope": 1}, "nope"),
    ],
)
def test_what_is_wrong_is_named(name: str, value: Any, path: str) -> None:
    with pytest.raises(MessageError, match=f"\\[{path.replace('[', '.').replace(']', '.')}\\]"):
        from_json(load(name), value)
