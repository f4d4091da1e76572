from __future__ import annotations

from io import BytesIO
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image as PillowImage

from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.topic_tools.image_encoding import compress
from pyros1.web.web_video_server.pictures import compressed_type, render
from pyros1.web.web_video_server.requests import Rendering

PNG = Rendering("png", 3)


def image(pixels: NDArray[Any], encoding: str, padding: int = 0, bigendian: bool = False) -> Any:
    height, width = pixels.shape[:2]
    rows = pixels.astype(pixels.dtype.newbyteorder(">" if bigendian else "<")).reshape(height, -1)
    data = b"".join(row.tobytes() + b"\xab" * padding for row in rows)
    step = len(data) // height if height else 0
    return Image(None, height, width, encoding, int(bigendian), step, data)


def pixels_of(data: bytes, file_format: str = "PNG") -> NDArray[Any]:
    with PillowImage.open(BytesIO(data)) as picture:
        assert picture.format == file_format
        return np.asarray(picture)


def test_colours_and_padding() -> None:
    rgb = np.random.default_rng(1).integers(0, 256, (5, 7, 3), np.uint8)
    assert np.array_equal(pixels_of(render(image(rgb, "rgb8", padding=3), PNG)), rgb)
    assert np.array_equal(pixels_of(render(image(rgb[:, :, ::-1], "bgr8"), PNG)), rgb)
    assert np.array_equal(pixels_of(render(image(rgb[:, :, 0], "mono8"), PNG)), rgb[:, :, 0])
    deep = rgb.astype(np.uint16) * 257
    assert np.array_equal(pixels_of(render(image(deep, "rgb16", bigendian=True), PNG)), rgb)
    assert np.array_equal(pixels_of(render(image(deep[:, :, 0], "mono16"), PNG)), rgb[:, :, 0])


def test_jpeg_and_its_quality() -> None:
    rgb = np.random.default_rng(1).integers(0, 256, (50, 70, 3), np.uint8)
    good, bad = (render(image(rgb, "rgb8"), Rendering("jpeg", quality)) for quality in (95, 5))
    assert pixels_of(good, "JPEG").shape == (50, 70, 3) and len(bad) < len(good) / 2
    alpha = np.dstack([rgb, np.full((50, 70), 9, np.uint8)])
    assert pixels_of(render(image(alpha, "rgba8"), Rendering("jpeg", 95)), "JPEG").shape == (50, 70, 3)
    assert np.array_equal(pixels_of(render(image(alpha, "rgba8"), PNG)), alpha)


def test_sizes_and_turning() -> None:
    grey = np.arange(12, dtype=np.uint8).reshape(3, 4)
    turned = pixels_of(render(image(grey, "mono8"), Rendering("png", 3, is_inverted=True)))
    assert np.array_equal(turned, np.rot90(grey, 2))
    assert pixels_of(render(image(grey, "mono8"), Rendering("png", 3, width=8))).shape == (3, 8)
    rgb = np.zeros((3, 4, 3), np.uint8)
    assert pixels_of(render(image(rgb, "rgb8"), Rendering("png", 3, 5, 6, True))).shape == (6, 5, 3)


@pytest.mark.parametrize(("dtype", "encoding"), [(np.float32, "32FC1"), (np.float64, "64FC1"), (np.uint16, "16UC1")])
def test_the_farthest_depth_is_white(dtype: Any, encoding: str) -> None:
    depth = np.array([[0, 500], [1000, 2000]], dtype)
    for bigendian in (False, True):
        shown = pixels_of(render(image(depth, encoding, 2 if bigendian else 0, bigendian), PNG))
        assert shown.tolist() == [[0, 64], [128, 255]]


def test_depths_that_are_no_numbers_are_black() -> None:
    depth = np.array([[np.nan, 1.0], [np.inf, -2.0]], np.float32)
    assert pixels_of(render(image(depth, "32FC1"), PNG)).tolist() == [[0, 255], [0, 0]]
    assert pixels_of(render(image(np.zeros((1, 2), np.float32), "32FC1"), PNG)).tolist() == [[0, 0]]


def test_compressed_images() -> None:
    rgb = np.random.default_rng(1).integers(0, 256, (5, 7, 3), np.uint8)
    message = compress(image(rgb, "rgb8"), "png")
    assert np.array_equal(pixels_of(render(message, PNG)), rgb)
    formats = {"jpeg": "image/jpeg", "rgb8; jpeg compressed bgr8": "image/jpeg", "png": "image/png", "tiff": "", "": ""}
    assert {name: compressed_type(CompressedImage(None, name, b"")) for name in formats} == formats


@pytest.mark.parametrize(
    "message",
    [
        Image(None, 2, 2, "rgb8", 0, 6, b"short"),
        Image(None, 2, 2, "32FC1", 0, 8, b"short"),
        Image(None, 2, 2, "32FC1", 0, 1, b"x" * 100),
        Image(None, 0, 0, "32FC1", 0, 0, b""),
        Image(None, 0, 0, "mono8", 0, 0, b""),
        Image(None, 2, 2, "yuv422", 0, 4, b"x" * 8),
        Image(None, 2**31, 2**31, "64FC4", 0, 2**31, b""),
        CompressedImage(None, "jpeg", b"nonsense"),
        CompressedImage(None, "", b""),
    ],
)
def test_damaged_images(message: Any) -> None:
    with pytest.raises(MessageError):
        render(message, PNG)


@pytest.mark.filterwarnings("error")
def test_depths_beyond_float32() -> None:
    far = np.array([[1e300, 2.0], [1.0, -1e300]], np.float64)
    assert pixels_of(render(image(far, "64FC1"), PNG)).tolist() == [[0, 255], [128, 0]]
    near = np.array([[1e-45, 0.0]], np.float32)
    assert pixels_of(render(image(near, "32FC1"), PNG)).tolist()[0][1] == 0
