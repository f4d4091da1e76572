"""All standard messages that ROS 1 and ROS 2 have in common, against rosbags' conversion."""

from __future__ import annotations

import random
import struct
from typing import Any

import pytest
from rosbags.convert.converter import is_same_wireformat
from rosbags_models import ros1_specs, ros1_store, ros2_store, ros2_types

from pyros1.ros2_types.model import STRUCT_CODES, FieldType, Length
from pyros1.ros2_types.transcoding.plan import FILLER
from pyros1.ros2_types.transcoding.transcoder import Transcoder

_PACKAGES = ("std_msgs", "geometry_msgs", "sensor_msgs", "nav_msgs")
_NAMES = [
    name
    for name in sorted(ros2_types())
    if name.startswith(_PACKAGES)
    and name in ros1_store().fielddefs
    and is_same_wireformat(ros1_store(), ros2_store(), name, name)
]


def _random_cdr(name: str, randoms: random.Random) -> bytes:
    """Return a random message of a ROS 2 type."""
    data = bytearray()

    def number(code: str, value: Any) -> None:
        encoded = struct.pack("<" + code, value)
        data.extend(bytes(-len(data) % len(encoded)) + encoded)

    def element(field_type: FieldType) -> None:
        if field_type.base == "string":
            text = randoms.randbytes(randoms.randrange(9)).hex().encode() + b"\0"
            number("I", len(text))
            data.extend(text)
        elif field_type.is_nested:
            message(field_type.base)
        else:
            code = STRUCT_CODES[field_type.base]
            number(code, randoms.randrange(2 if code == "?" else 100))

    def message(name: str) -> None:
        for field_name, field_type in ros2_types()[name].fields:
            if field_name == FILLER:
                number("B", 0)
                continue
            count = {Length.SINGLE: 1, Length.FIXED: field_type.size}.get(field_type.length, randoms.randrange(4))
            if field_type.length in (Length.BOUNDED, Length.UNBOUNDED):
                number("I", count)
            for _ in range(count):
                element(field_type)

    message(name)
    return b"\0\1\0\0" + data


def test_enough_types() -> None:
    assert len(_NAMES) > 80


@pytest.mark.parametrize("start", range(8))
def test_same_as_rosbags(start: int) -> None:
    randoms = random.Random(start)
    for name in _NAMES[start::8]:
        ros1_name = name.replace("/msg/", "/")
        transcoder = Transcoder(ros1_name, ros1_specs(ros1_name), name, ros2_types())
        assert not transcoder.only_ros1 and not transcoder.only_ros2, name
        for _ in range(3):
            cdr = _random_cdr(name, randoms)
            body = transcoder.from_cdr(cdr, 0)  # rosbags numbers headers 0
            assert body == ros2_store().cdr_to_ros1(cdr, name), name
            assert transcoder.to_cdr(body) == ros2_store().ros1_to_cdr(body, name) == cdr, name
