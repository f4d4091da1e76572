"""Depths as clouds of points."""

from __future__ import annotations

import io
import math
import struct
from typing import Any

import numpy as np
import pytest
from PIL import Image as Pictures

from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.web.scene.camera import Camera
from pyros1.web.scene.depth import colours, depth_cloud, depths
from pyros1.web.scene.shape import ShapeError
from pyros1.web.transforms import image_size

CAMERA = Camera(2.0, 4.0, 0.5, 0.0, 0.0, 0.0, 2, 2)


def image(rows: list[list[Any]], encoding: str, kind: str, bigendian: bool = False) -> Image:
    array = np.array(rows, np.dtype(kind).newbyteorder(">" if bigendian else "<"))
    step = array.strides[0]
    return Image(
        height=len(rows),
        width=len(rows[0]),
        encoding=encoding,
        is_bigendian=bigendian,
        step=step,
        data=array.tobytes(),
    )


def packed(rows: list[list[int]], form: str, head: bytes = bytes(12)) -> CompressedImage:
    file = io.BytesIO()
    Pictures.fromarray(np.array(rows, np.uint16)).save(file, "PNG")
    return CompressedImage(format=form, data=head + file.getvalue())


def points(shape: Any) -> list[list[float]]:
    facts, blob = shape
    found: list[list[float]] = np.frombuffer(blob, np.float32, 3 * facts["count"]).reshape(-1, 3).tolist()
    return found


@pytest.mark.parametrize("bigendian", [False, True])
def test_millimetres_and_metres(bigendian: bool) -> None:
    assert depths(image([[1000, 0]], "16UC1", "u2", bigendian)).tolist() == [[1.0, 0.0]]
    metres = depths(image([[1.5, math.nan]], "32FC1", "f4", bigendian))
    assert metres[0, 0] == 1.5
    assert np.isnan(metres[0, 1])


def test_compressed_depths() -> None:
    assert depths(packed([[2000, 0]], "16UC1; compressedDepth png")).tolist() == [[2.0, 0.0]]
    quantized = depths(packed([[300, 0]], "32FC1; compressedDepth", struct.pack("<iff", 0, 100.0, 50.0)))
    assert quantized[0, 0] == np.float32(0.4)
    assert np.isnan(quantized[0, 1])


@pytest.mark.parametrize(
    ("message", "said"),
    [
        (image([[1]], "mono8", "u1"), "16UC1 or 32FC1, but this one is mono8"),
        (Image(encoding="16UC1", width=5, height=5, step=10, data=b"12"), "2 bytes"),
        (CompressedImage(format="jpeg", data=b"123456789012"), "of the format jpeg"),
        (CompressedImage(format="16UC1; compressedDepth", data=bytes(20)), "only PNG"),
        (CompressedImage(format="16UC1; compressedDepth", data=bytes(12) + b"\x89PNG\r\n"), "cannot be read"),
        (CompressedImage(format="16UC1; compressedDepth", data=b"1"), "not a depth image"),
    ],
)
def test_pictures_that_are_no_depths(message: Any, said: str) -> None:
    with pytest.raises(ShapeError, match=said):
        depths(message)


def test_a_picture_that_would_unpack_to_gigabytes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.web.scene.depth.MAX_PIXELS", 3)
    assert image_size.MAX_PIXELS > 3
    with pytest.raises(ShapeError, match="too large"):
        depths(packed([[1, 2], [3, 4]], "16UC1; compressedDepth"))


def test_where_the_points_are() -> None:
    shape = depth_cloud(np.array([[2, math.nan], [math.inf, 4]], np.float32), CAMERA, None, 100)
    assert points(shape) == [[-0.5, 0.0, 2.0], [1.0, 1.0, 4.0]]
    assert shape[0] == {
        "kind": "cloud",
        "count": 2,
        "every": 1,
        "fields": ["z"],
        "by": "z",
        "colour": "z",
        "least": 2.0,
        "most": 4.0,
    }
    nothing, _ = depth_cloud(np.zeros((2, 2), np.float32), CAMERA, None, 100)
    assert (nothing["count"], nothing["least"], nothing["most"]) == (0, 0.0, 1.0)


def test_of_large_pictures_some_rows_and_columns_are_left_out() -> None:
    depth = np.ones((40, 60), np.float32)
    shape = depth_cloud(depth, Camera(1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 60, 40), None, 400)
    assert (shape[0]["count"], shape[0]["every"]) == (14 * 20, 9)
    assert points(shape)[:2] == [[0.0, 0.0, 1.0], [3.0, 0.0, 1.0]]
    depth[10:] = 0  # what is not there does not count
    assert depth_cloud(depth, CAMERA, None, 700)[0]["every"] == 1


def test_colours_of_a_picture_of_another_size() -> None:
    picture = colours(image([[[1, 2, 3], [4, 5, 6]]], "rgb8", "u1"))
    assert picture.tolist() == [[[3, 2, 1, 0], [6, 5, 4, 0]]]
    facts, blob = depth_cloud(np.ones((2, 4), np.float32), CAMERA, picture, 100)
    assert (facts["colour"], facts["by"]) == ("rgb", "rgb")
    assert [*blob[8 * 12 :]] == [3, 2, 1, 0, 3, 2, 1, 0, 6, 5, 4, 0, 6, 5, 4, 0] * 2


def test_colours_of_other_kinds() -> None:
    assert colours(image([[7]], "mono8", "u1")).tolist() == [[[7, 7, 7, 0]]]
    assert colours(image([[[1, 2, 3, 4]]], "bgra8", "u1")).tolist() == [[[1, 2, 3, 0]]]
    file = io.BytesIO()
    Pictures.new("RGB", (1, 1), (10, 20, 30)).save(file, "PNG")
    assert colours(CompressedImage(format="png", data=file.getvalue())).tolist() == [[[30, 20, 10, 0]]]
    with pytest.raises(ShapeError, match="colours: the image cannot be read: its format is unknown"):
        colours(CompressedImage(format="jpeg", data=b"no"))


def test_which_pixels_the_points_are() -> None:
    depth = np.array([[0, 0, 1], [0, 0, 0], [1, 0, 1]], np.float32)
    facts, blob = depth_cloud(depth, CAMERA, None, 100, with_indices=True)
    assert (facts["numbers"], np.frombuffer(blob[36:], np.uint32).tolist()) == (True, [2, 6, 8])
    _, blob = depth_cloud(np.ones((4, 4), np.float32), CAMERA, None, 4, with_indices=True)
    assert np.frombuffer(blob[48:], np.uint32).tolist() == [0, 2, 8, 10]
