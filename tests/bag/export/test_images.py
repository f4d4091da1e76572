"""Pixels of sensor_msgs/Image."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pyros1.bag.export.images import pixels, to_8_bits
from pyros1.ground.errors import MessageError
from pyros1.msgs import load_message


def image(encoding: str, rows: list[bytes], width: int, big: int = 0) -> Any:
    return load_message("sensor_msgs/Image")(
        encoding=encoding, data=b"".join(rows), width=width, height=len(rows), step=len(rows[0]), is_bigendian=big
    )


@pytest.mark.parametrize(
    ("encoding", "data", "width", "expected"),
    [
        ("mono8", b"\1\2", 2, [1, 2]),
        ("8UC1", b"\1\2", 2, [1, 2]),
        ("mono16", b"\1\2", 1, [0x0201]),
        ("16UC1", b"\1\2", 1, [0x0201]),
        ("16SC1", b"\xff\xff", 1, [-1]),
        ("32FC1", b"\0\0\x80\x3f", 1, [1.0]),
        ("64FC1", np.float64(0.5).tobytes(), 1, [0.5]),
        ("rgb8", b"\1\2\3", 1, [[1, 2, 3]]),
        ("bgr8", b"\1\2\3", 1, [[3, 2, 1]]),
        ("8UC3", b"\1\2\3", 1, [[3, 2, 1]]),
        ("rgba8", b"\1\2\3\4", 1, [[1, 2, 3, 4]]),
        ("bgra8", b"\1\2\3\4", 1, [[3, 2, 1, 4]]),
        ("bgr16", b"\1\0\2\0\3\0", 1, [[3, 2, 1]]),
        ("yuv422", b"\x80\x10\x80\xeb", 2, [[0, 0, 0], [255, 255, 255]]),
        ("yuv422_yuy2", b"\x10\x80\xeb\x80", 2, [[0, 0, 0], [255, 255, 255]]),
    ],
)
def test_encodings(encoding: str, data: bytes, width: int, expected: list[Any]) -> None:
    assert pixels(image(encoding, [data], width)).tolist() == [expected]


def test_what_rows_have_behind_them_is_left_out() -> None:
    assert pixels(image("mono8", [b"\1\2\0\0", b"\3\4\0\0"], 2)).tolist() == [[1, 2], [3, 4]]
    cut = image("mono8", [b"\1\2\0\0", b"\3\4\0\0"], 2)
    cut.data = cut.data[:-2]  # the last row's rest is of no use to anyone
    assert pixels(cut).tolist() == [[1, 2], [3, 4]]


def test_big_endian() -> None:
    assert pixels(image("mono16", [b"\1\2"], 1, big=1)).tolist() == [[0x0102]]


@pytest.mark.parametrize("pattern", ["rggb", "bggr", "gbrg", "grbg"])
def test_bayer_gives_back_an_even_colour(pattern: str) -> None:
    levels = {"r": 200, "g": 100, "b": 50}
    first, second = (bytes(levels[name] for name in pair) * 3 for pair in (pattern[:2], pattern[2:]))
    message = image(f"bayer_{pattern}8", [first, second] * 2, 6)
    assert np.array_equal(pixels(message), np.full((4, 6, 3), (200, 100, 50)))
    assert pixels(message, mosaic=True).tolist()[0] == list(first)


@pytest.mark.parametrize(
    ("message", "text"),
    [
        (image("mono8", [b""], 0), "is empty"),
        (image("rgb8", [b"\1\2"], 1), "take 3 bytes"),
        (image("h264", [b"\1"], 1), "'h264' are not supported"),
        (image("16FC1", [b"\1\2"], 1), "not supported"),
        (image("yuv422", [b"\1\2"], 1), "even"),
    ],
)
def test_what_is_no_image(message: Any, text: str) -> None:
    with pytest.raises(MessageError, match=text):
        pixels(message)
    short = image("mono8", [b"\1\2", b"\3\4"], 2)
    short.data = short.data[:3]
    with pytest.raises(MessageError, match="the image has 3 bytes"):
        pixels(short)


def test_8_bits_for_eyes() -> None:
    assert to_8_bits(np.array([[[0x1234, 0, 0xFFFF]]], np.uint16)).tolist() == [[[0x12, 0, 0xFF]]]
    depth = np.array([[1.0, np.nan, 3.0]], np.float32)
    assert to_8_bits(depth).tolist() == [[0, 0, 255]]
    assert to_8_bits(np.full((1, 2), np.inf)).tolist() == [[0, 0]]
    assert to_8_bits(np.array([[5, 5]], np.uint16)).tolist() == [[0, 0]]
