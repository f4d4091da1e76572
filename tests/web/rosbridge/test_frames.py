"""CBOR as cbor2 reads it."""

from __future__ import annotations

import base64
import json
import struct
from typing import Any

import cbor2
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.msgs.sensor_msgs.msg import ChannelFloat32, Image, PointCloud, PointCloud2, PointField
from pyros1.web.rosbridge import frames, values
from pyros1.web.server.sending import LargeFrame

from ...bodies import encode

_DATA = st.sampled_from([0, 1, 16_384, 16_385, 65_535, 65_536, 100_000]).map(bytes)
_VALUES = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**63), 2**64 - 1) | st.floats(allow_nan=False) | st.text() | _DATA,
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=30),
    max_leaves=40,
)


@pytest.mark.slow
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


@pytest.mark.parametrize("size", [0, 10, 16_384, 16_385, 100_000])
@pytest.mark.parametrize("type_", ["none", "array"])
def test_frames_with_messages_in_cbor(size: int, type_: str) -> None:
    data = bytes(size)
    message = {"bytes": data} if type_ == "none" else {"x": [1, {"y": frames.with_cbor_tag(85, data)}], "bytes": data}
    frame = frames.publish_cbor("/ä", message, size)
    whole = b"".join(frame.pieces) if isinstance(frame, LargeFrame) else frame
    assert cbor2.loads(whole) == {"op": "publish", "topic": "/ä", "msg": message}
    if isinstance(frame, LargeFrame):
        assert not frame.is_text and frame.size == len(whole)
        assert any(piece is data for piece in frame.pieces), "large data is not copied"
    assert isinstance(frame, LargeFrame) is (size > 16_384)


@pytest.mark.parametrize("size", [3, 12_000, 12_300, 100_000])
def test_frames_with_large_data_in_json(size: int) -> None:
    data = bytes(range(256)) * (size // 256) + bytes(size % 256)
    message = Image(encoding="ä", data=data, step=7)
    frame = frames.publish("/t", values.decode(Image, encode(message)))
    text = frames.as_text(frame)
    found = json.loads(text)["msg"]
    assert (base64.b64decode(found["data"]), found["encoding"], found["step"]) == (data, "ä", 7)
    assert isinstance(frame, LargeFrame) is (size > 12_288)
    if isinstance(frame, LargeFrame):
        assert frame.is_text and frame.size == len(text) and len(frame.pieces) == 3
