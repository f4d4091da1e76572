"""Messages in pieces around their byte array."""

from __future__ import annotations

from typing import Any

import codec
import pytest

from pyros1.ground.errors import LengthError
from pyros1.msgs import AnyMsg, from_definition, load_message
from pyros1.msgs.array_views import memoryview_view
from pyros1.msgs.large_arrays import Layout, SplitBody, decode_split, find_layout, split_frame

IMAGE: Any = load_message("sensor_msgs/Image")
CLOUD: Any = load_message("sensor_msgs/PointCloud2")


def image(size: int = 100_000) -> Any:
    message = IMAGE(height=3, encoding="mono8", data=bytes(range(256)) * (size // 256))
    message.header.frame_id = "camera"
    return message


def cloud() -> Any:
    message = CLOUD(data=b"xyz" * 20_000, is_dense=True)
    message.fields = [load_message("sensor_msgs/PointField")("x", 0, 7, 1)]
    return message


def pieces(message: Any) -> SplitBody:
    """Cut an encoded message around its array."""
    where = find_layout(type(message))
    body = codec.encode(message)
    assert where is not None
    end = len(body) - where.tail_size
    begin = end - len(message.data)
    return SplitBody(body[: begin - 4], body[begin:end], body[end:])


@pytest.mark.parametrize(
    ("definition", "expected"),
    [
        ("uint8[] a", Layout("a", 0)),
        ("string s\nuint8[] a\nbool b\nint32[3] c\ntime t", Layout("a", 21)),
        ("char[] a", Layout("a", 0)),
        ("uint8[] a\nstring s", None),
        ("uint8[] a\nuint8[] b", None),
        ("uint8[4] a", None),
        ("int8[] a", None),
        ("uint8[] a\nfloat32[] f", None),
    ],
)
def test_layout(definition: str, expected: Layout | None) -> None:
    assert find_layout(from_definition("p/T", definition)) == expected


@pytest.mark.parametrize("make", [image, cloud])
def test_the_array_is_taken_as_it_is(make: Any) -> None:
    message = make()
    body = pieces(message)
    decoded = decode_split(type(message), find_layout(type(message)), body)
    assert decoded == message
    assert decoded.data is body.data
    assert body.join() == codec.encode(message)


@pytest.mark.parametrize("make", [image, cloud])
def test_views_of_the_array(make: Any) -> None:
    message = make()
    decoded = decode_split(type(message), find_layout(type(message)), pieces(message), memoryview_view)
    assert isinstance(decoded.data, memoryview) and decoded.data == message.data and decoded.data.readonly


def test_an_array_length_inside_the_head_is_not_believed() -> None:
    """Head and tail make a valid message of their own, with an array that is not empty: the whole one decides."""
    cls: Any = from_definition("p/T", "uint8[] a")
    body = SplitBody(b"\x04\0\0\0", b"12345", b"")  # as one piece: a length of 4, followed by 9 bytes
    assert decode_split(cls, find_layout(cls), body).a == body.join()[4:8]
    with pytest.raises(LengthError):
        decode_split(cls, find_layout(cls), body, exact=True)


def test_undecoded_messages_are_the_array() -> None:
    body = SplitBody(b"", b"whatever", b"", has_length_field=False)
    assert decode_split(AnyMsg, find_layout(AnyMsg), body)._buff is body.data
    message = image()
    whole = SplitBody(b"", codec.encode(message), b"", has_length_field=False)
    assert decode_split(IMAGE, find_layout(IMAGE), whole) == message
    assert decode_split(AnyMsg, find_layout(AnyMsg), pieces(message))._buff == whole.data


@pytest.mark.parametrize("make", [image, cloud])
def test_frames_from_the_encoder(make: Any) -> None:
    message = make()
    where = find_layout(type(message))
    assert where is not None
    body = split_frame(codec.encode_frame(message), where.tail_size)
    assert body is not None and body.data is message.data
    assert decode_split(type(message), where, body) == message


def test_frames_of_other_shapes_are_not_split() -> None:
    assert split_frame([b"12345678", b"data", b"t"], 0) is None
    assert split_frame([b"1234\x04\0\0\0", b"data", b"t", b"u"], 1) is None
    assert split_frame([b"1234\x05\0\0\0", b"data"], 0) is None
    assert split_frame([b"\x04\0\0\0", b"data"], 0) is None
    # Pieces are only kept if they cannot change.
    head, data = b"1234\x04\0\0\0", b"data"
    assert split_frame([head, data], 0) is not None
    assert split_frame([bytearray(head), data], 0) is None
    assert split_frame([head, bytearray(data)], 0) is None
    assert split_frame([head, memoryview(data)], 0) is None
