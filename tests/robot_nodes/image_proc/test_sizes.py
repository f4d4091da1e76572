from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.robot_nodes.image_proc.pixels import ImageError, to_array
from pyros1.robot_nodes.image_proc.resample import AREA
from pyros1.robot_nodes.image_proc.sizes import Crop, Scaling


def image(height: int = 12, width: int = 16, encoding: str = "mono8") -> Any:
    size = {"mono8": 1, "bgr8": 3, "bayer_rggb8": 1, "bayer_rggb16": 2, "yuv422": 2}[encoding]
    data = bytes(value % 251 for value in range(height * width * size))
    found = Image(height=height, width=width, encoding=encoding, step=width * size, data=data)
    found.header.frame_id = "camera"
    return found


def info(**changes: Any) -> Any:
    found = CameraInfo(height=12, width=16, **changes)
    found.K = [100.0, 0, 8.0, 0, 90.0, 6.0, 0, 0, 1]
    found.P = [100.0, 0, 8.0, -20.0, 0, 90.0, 6.0, 4.0, 0, 0, 1, 0]
    return found


def test_resize_changes_image_and_camera_info_alike() -> None:
    scaling = Scaling(scale_width=0.5, scale_height=2.0)
    found = scaling.apply_to_image(image(encoding="bgr8"))
    assert (found.height, found.width, found.encoding, found.header.frame_id) == (24, 8, "bgr8", "camera")
    before = info()
    before.roi.x_offset, before.roi.width, before.roi.y_offset, before.roi.height = 2, 6, 3, 5
    result = scaling.apply_to_info(before)
    assert (result.height, result.width) == (24, 8)
    assert list(result.K) == [50.0, 0, 4.0, 0, 180.0, 12.0, 0, 0, 1]
    assert list(result.P) == [50.0, 0, 4.0, -10.0, 0, 180.0, 12.0, 8.0, 0, 0, 1, 0]
    roi = result.roi
    assert (roi.x_offset, roi.width, roi.y_offset, roi.height) == (1, 3, 6, 10)
    assert list(before.K) == list(info().K) and before.roi.width == 6  # the original stays as it was


def test_resize_to_a_size() -> None:
    scaling = Scaling(use_scale=False, width=8, height=-1)
    found, result = scaling.apply_to_image(image()), scaling.apply_to_info(info())
    assert (found.height, found.width) == (result.height, result.width) == (12, 8)
    assert (result.K[0], result.K[4]) == (50.0, 90.0)


@pytest.mark.parametrize(
    "scaling", [Scaling(scale_width=0.0), Scaling(use_scale=False, width=0), Scaling(False, 1, 1, 2**31 - 1, 2**31 - 1)]
)
def test_sizes_that_make_no_sense(scaling: Scaling) -> None:
    with pytest.raises(ImageError, match="cannot be resized to"):
        scaling.apply_to_image(image())
    with pytest.raises(ImageError, match="cannot be resized to"):
        scaling.apply_to_info(info())


@pytest.mark.parametrize("encoding", ["bayer_rggb8", "yuv422"])
def test_patterns_cannot_be_resized(encoding: str) -> None:
    with pytest.raises(ImageError, match="take image_color"):
        Scaling().apply_to_image(image(encoding=encoding))


def test_a_camera_info_without_size() -> None:
    with pytest.raises(ImageError, match="has no size"):
        Scaling().apply_to_info(CameraInfo())


def test_without_parameters_messages_are_passed_on() -> None:
    picture, camera = image(), info()
    found = Crop().apply(picture, camera)
    assert found[0] is picture and found[1] is camera


def test_a_part_of_an_image() -> None:
    picture = image()
    found, result = Crop(x_offset=3, y_offset=2, width=5, height=100).apply(picture, info(binning_x=2))
    assert (to_array(found) == to_array(picture)[2:12, 3:8]).all()
    roi = result.roi
    assert (roi.x_offset, roi.y_offset, roi.width, roi.height, roi.do_rectify) == (6, 2, 10, 10, True)
    assert (result.binning_x, result.binning_y) == (2, 1)


def test_fewer_pixels() -> None:
    picture = image()
    found, result = Crop(decimation_x=3, decimation_y=2).apply(picture, info())
    assert (to_array(found) == to_array(picture)[::2, :15:3]).all()
    assert (result.binning_x, result.binning_y, result.roi.width, result.roi.do_rectify) == (3, 2, 16, False)
    averaged, _ = Crop(decimation_x=2, decimation_y=2, interpolation=AREA).apply(picture, info())
    assert to_array(averaged)[0, 0] == round(to_array(picture)[:2, :2].mean())


@pytest.mark.parametrize(("encoding", "dtype"), [("bayer_rggb8", "u1"), ("bayer_rggb16", "u2")])
def test_bayer_patterns_become_colours_when_decimated(encoding: str, dtype: str) -> None:
    picture = image(encoding=encoding)
    raw = to_array(picture)
    found, result = Crop(decimation_x=4, decimation_y=2, x_offset=3, y_offset=1).apply(picture, info())
    assert found.encoding == f"bgr{8 * np.dtype(dtype).itemsize}" and result.roi.x_offset == 2
    pixels = to_array(found)
    assert pixels.shape == (6, 3, 3)
    assert pixels[0, 1].tolist() == [raw[1, 7], (int(raw[0, 7]) + int(raw[1, 6])) // 2, raw[0, 6]]


@pytest.mark.parametrize(
    ("crop", "encoding", "problem"),
    [
        (Crop(x_offset=16), "mono8", "outside of the image"),
        (Crop(y_offset=12), "mono8", "outside of the image"),
        (Crop(decimation_x=3, decimation_y=2), "bayer_rggb8", "must be even"),
        (Crop(decimation_x=2), "yuv422", "cannot be decimated"),
        (Crop(decimation_x=16, width=15), "mono8", "smaller than one pixel"),
    ],
)
def test_parts_that_cannot_be_made(crop: Crop, encoding: str, problem: str) -> None:
    with pytest.raises(ImageError, match=problem):
        crop.apply(image(encoding=encoding), info())


def test_any_parameters_make_an_image_that_fits_its_size_or_an_error() -> None:
    chance = np.random.default_rng(7)
    made = 0
    for _ in range(300):
        by_x, by_y, x, y, width, height = chance.integers([1, 1, 0, 0, 0, 0], [6, 6, 18, 14, 18, 14]).tolist()
        crop = Crop(by_x, by_y, x, y, width, height, int(chance.integers(5)))
        picture = image(encoding=chance.choice(["mono8", "bgr8", "bayer_rggb8", "bayer_rggb16"]))
        try:
            found, result = crop.apply(picture, info())
        except ImageError:
            continue
        made += 1
        pixels = to_array(found)
        assert pixels.shape[0] == result.roi.height // by_y or found is picture
        assert pixels.shape[1] == result.roi.width // by_x or found is picture
    assert made > 60
