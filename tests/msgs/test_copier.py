"""Copies within a process: equal to what would have gone through a wire, and independent of the original."""

from __future__ import annotations

from typing import Any

import codec
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pyros1.ground.errors import SerializationError
from pyros1.msgs import from_definition, load_message
from pyros1.msgs.base import nested_classes

from .message_strategies import messages

SEPARATOR = "=" * 80
NAMES = [
    "std_msgs/Float64", "geometry_msgs/Twist", "sensor_msgs/JointState", "nav_msgs/Odometry", "std_msgs/String",
    "tf2_msgs/TFMessage", "sensor_msgs/Image", "sensor_msgs/PointCloud2", "sensor_msgs/LaserScan", "sensor_msgs/Imu",
    "diagnostic_msgs/DiagnosticArray", "trajectory_msgs/JointTrajectory", "visualization_msgs/Marker",
]  # fmt: skip
EVERY: Any = from_definition(
    "p/Every",
    "bool b\nint8 i8\nuint8 u8\nint16 i16\nuint16 u16\nint32 i32\nuint32 u32\nint64 i64\nuint64 u64\nfloat32 f\n"
    "float64 d\nstring s\ntime t\nduration u\nuint8[] bytes\nuint8[4] four\nbool[] bs\nfloat32[] fs\nint16[3] is_\n"
    f"string[] ss\ntime[] ts\nA[] as_\nA[2] two\n{SEPARATOR}\nMSG: p/A\nint16[] i\nstring s",
)
A: Any = nested_classes(EVERY)["p/A"]


def through_wire(message: Any) -> Any:
    body = codec.encode(message)
    return codec.decode(type(message), body, 0, len(body))


@pytest.mark.slow
@pytest.mark.parametrize("cls", [EVERY, *map(load_message, NAMES)], ids=lambda cls: cls._type)
@given(data=st.data())
@settings(max_examples=25)
def test_a_copy_is_what_the_wire_would_have_given(cls: Any, data: st.DataObject) -> None:
    message = data.draw(messages(cls))
    copy = codec.copy(message)
    assert copy == through_wire(message)
    assert codec.encode(copy) == codec.encode(message)


def test_values_of_other_types_become_what_the_wire_makes_of_them() -> None:
    message = EVERY(
        b=1, i8=True, f=0.1, d=3, bytes=bytearray(b"xy"), four=[1, 2, 3, 4], bs=(1, 0), fs=[0.1], is_=[1, 2, 3]
    )
    message.two = [A((1, 2), "é"), A([3], "z")]
    copy, sent = codec.copy(message), through_wire(message)
    for name in EVERY.__slots__:
        mine, theirs = getattr(copy, name), getattr(sent, name)
        assert mine == theirs and type(mine) is type(theirs), name
    message.four = b"ab"
    assert codec.copy(message).four == through_wire(message).four == b"ab\0\0"


def test_what_can_change_is_not_shared_and_what_cannot_is() -> None:
    message = EVERY(bytes=b"large" * 1000, s="text", ss=["a"], as_=[A([1], "a")])
    copy = codec.copy(message)
    assert copy.bytes is message.bytes and copy.s is message.s
    message.ss.append("b")
    message.as_[0].s = "changed"
    message.t.secs = 7
    assert (copy.ss, copy.as_[0].s, copy.t.secs) == (["a"], "a", 0)


@pytest.mark.parametrize(
    ("field", "value"),
    [("i8", 200), ("u8", -1), ("u64", 1 << 64), ("i32", 1.5), ("f", "x"), ("d", None), ("s", 3), ("s", b"bytes"),
     ("s", "\ud800"), ("b", "x"), ("t", 5), ("bytes", 7), ("four", b"12345"), ("is_", [1]), ("fs", ["x"]), ("ss", [1]),
     ("ts", [1]), ("as_", [1]), ("two", [])],
)  # fmt: skip
def test_what_the_encoder_refuses_the_copier_refuses_with_the_same_words(field: str, value: Any) -> None:
    message = EVERY()
    setattr(message, field, value)
    with pytest.raises(SerializationError) as encoding:
        codec.encode(message)
    with pytest.raises(SerializationError) as copying:
        codec.copy(message)
    assert str(copying.value) == str(encoding.value)
