from __future__ import annotations

import numpy as np
import pytest

from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Header
from pyros1.robot_nodes.image_proc.pixels import ImageError, parse_encoding, to_array, to_image

SHAPES = {
    "mono8": ("u1", 1), "mono16": ("u2", 1), "bgr8": ("u1", 3), "rgb16": ("u2", 3), "rgba8": ("u1", 4),
    "bgra16": ("u2", 4), "bayer_rggb8": ("u1", 1), "bayer_gbrg16": ("u2", 1), "8UC1": ("u1", 1), "8UC": ("u1", 1),
    "16SC2": ("i2", 2), "32FC1": ("f4", 1), "64FC3": ("f8", 3), "32SC1": ("i4", 1), "yuv422": ("u1", 2),
}  # fmt: skip


@pytest.mark.parametrize("encoding", SHAPES)
@pytest.mark.parametrize("extra", [0, 3, 8])
@pytest.mark.parametrize("big", [False, True])
def test_images_become_arrays_and_images_again(encoding: str, extra: int, big: bool) -> None:
    dtype, channels = SHAPES[encoding]
    chance = np.random.default_rng(1)
    values = chance.integers(0, 100, (4, 5, channels)).astype(dtype)
    raw = values.astype(np.dtype(dtype).newbyteorder(">" if big else "<")).reshape(4, -1).view("u1")
    rows = np.hstack([raw, np.full((4, extra), 7, "u1")])
    image = Image(height=4, width=5, encoding=encoding, step=rows.shape[1], data=rows.tobytes(), is_bigendian=big)
    found = to_array(image)
    expected = values[..., 0] if channels == 1 else values
    assert found.shape == expected.shape and found.dtype == np.dtype(dtype) and (found == expected).all()
    again = to_image(Header(frame_id="camera"), found, encoding)
    assert (again.height, again.width, again.encoding, again.header.frame_id) == (4, 5, encoding, "camera")
    assert again.step * 4 == len(again.data) and (to_array(again) == expected).all()


@pytest.mark.parametrize("name", ["", "jpeg", "8FC1", "64UC1", "bgr32", "bayer_rgbg8", "mono8\n", "8UC0"])
def test_unknown_encodings(name: str) -> None:
    with pytest.raises(ImageError, match="not supported"):
        parse_encoding(name)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"height": 0}, "no pixels"),
        ({"width": 0}, "no pixels"),
        ({"step": 14}, "too few"),
        ({"height": 5}, "too few"),
        ({"height": 2**32 - 1, "width": 2**32 - 1, "step": 2**32 - 1}, "too few"),
    ],
)
def test_images_that_claim_more_than_they_have(changes: dict[str, int], problem: str) -> None:
    image = Image(height=4, width=5, encoding="bgr8", step=15, data=bytes(60))
    assert to_array(image).shape == (4, 5, 3)
    for name, value in changes.items():
        setattr(image, name, value)
    with pytest.raises(ImageError, match=problem):
        to_array(image)


def test_what_encodings_mean() -> None:
    assert parse_encoding("bayer_grbg16").bayer == "grbg" and not parse_encoding("mono8").bayer
    assert [name for name in SHAPES if parse_encoding(name).is_colour] == ["bgr8", "rgb16", "rgba8", "bgra16"]
    assert [name for name in SHAPES if parse_encoding(name).is_mono] == ["mono8", "mono16", "8UC1"]
    assert [name for name in SHAPES if parse_encoding(name).is_yuv] == ["yuv422"]
