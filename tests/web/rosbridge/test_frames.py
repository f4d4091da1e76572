"""CBOR as cbor2 reads it."""

from __future__ import annotations

import struct
from typing import Any

import cbor2
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.msgs.sensor_msgs.msg import ChannelFloat32, Image, PointCloud, PointCloud2, PointField
from pyros1.web.rosbridge import frames, values

from ...bodies import encode

_DATA = st.sampled_from([0, 1, 16_384, 16_385, 65_535, 65_536, 100_000]).map(bytes)
_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats(allow_nan=False) | st.text() | _DATA,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=30),
    max_leaves=40,
)


@given(_VALUES)
def test_any_value(value: Any) -> None:
    assert cbor2.loads(frames.to_cbor(value)) == value


@pytest.mark.parametrize("tag", [85, 255, 500, 65_537, 1 << 33])
@pytest.mark.parametrize("size", [10, 16_385])
def test_tags(tag: int, size: int) -> None:
    value = {"a": [1, 2], "b": {"c": frames.with_cbor_tag(tag, bytes(size))}}
    assert cbor2.loads(frames.to_cbor(value)) == {"a": [1, 2], "b": {"c": cbor2.CBORTag(tag, bytes(size))}}


@pytest.mark.parametrize("size", [4096, 4097, 50_000])
def test_large_arrays_in_arrays_of_messages(size: int) -> None:
    numbers = [float(number % 1000) for number in range(size)]
    cloud = PointCloud(channels=[ChannelFloat32("intensity", numbers)] * 2)
    converted = values.for_cbor(values.decode(PointCloud, encode(cloud)))
    found = cbor2.loads(frames.to_cbor({"op": "publish", "msg": converted}))["msg"]["channels"]
    assert [each["values"].tag for each in found] == [85, 85]
    assert [each["values"].value for each in found] == [struct.pack(f"<{size}f", *numbers)] * 2


@pytest.mark.parametrize("size", [0, 3, 100_000])
def test_messages_with_large_data(size: int) -> None:
    data = bytes(range(256)) * (size // 256) + bytes(size % 256)
    for message in (
        Image(height=1, width=size, data=data),
        PointCloud2(fields=[PointField("x", 4, 7, 1)], data=data, is_dense=True),
    ):
        body = encode(message)
        converted = values.for_cbor(values.decode(type(message), body))
        assert cbor2.loads(frames.to_cbor({"op": "publish", "msg": converted})) == {
            "op": "publish",
            "msg": cbor2.loads(cbor2.dumps(values.for_cbor(message))),
        }
