from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest

from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image, RegionOfInterest
from pyros1.robot_nodes.depthimage_to_laserscan.conversion import Camera, convert, read_depths


def slow_ranges(
    rows: list[list[float]], unit: float, camera: Camera, scan_height: int, limits: tuple[float, float]
) -> list[float]:
    """One pixel after the other, as the package's documentation and REP 117 say."""
    ranges = [math.nan] * camera.width
    first, _, step = camera.angles
    top = int(camera.center_y - scan_height // 2)
    for row in rows[top : top + scan_height]:
        for column, depth in enumerate(row):
            right = (column - camera.center_x) / camera.focal_length
            ray = int((-math.atan2(right, 1.0) - first) / step) if step else 0
            ray = min(max(ray, 0), camera.width - 1)
            if depth == math.inf:
                if math.isnan(ranges[ray]):
                    ranges[ray] = depth
                continue
            distance = math.hypot(depth * unit * right, depth * unit)
            if depth > 0 and limits[0] <= distance <= limits[1] and not distance >= ranges[ray]:
                ranges[ray] = distance
    return ranges


@pytest.mark.parametrize("seed", range(40))
def test_any_image(seed: int) -> None:
    chance = random.Random(seed)
    width, height = chance.choice([1, 2, 7, 64]), chance.choice([1, 3, 20])
    if chance.random() < 0.5:
        dtype, unit = "u2", 0.001
        rows = [[float(chance.choice([0, chance.randrange(12000)])) for _ in range(width)] for _ in range(height)]
    else:
        dtype, unit = "f4", 1.0
        special = [math.nan, math.inf, -math.inf, -1.0, 0.0]
        rows = [
            [chance.choice(special) if chance.random() < 0.2 else chance.uniform(0, 12) for _ in range(width)]
            for _ in range(height)
        ]
    depths = np.array(rows, dtype)
    camera = Camera(width, height, chance.uniform(5, 80), chance.uniform(-1, width), chance.uniform(0, height))
    scan_height = chance.randint(1, height)
    limits = (chance.uniform(0, 3), chance.uniform(3, 15))
    top = int(camera.center_y - scan_height // 2)
    if top < 0 or top + scan_height > height:
        with pytest.raises(MessageError, match="set a smaller scan_height"):
            convert(depths, unit, camera, scan_height, *limits)
        return
    found = convert(depths, unit, camera, scan_height, *limits)
    expected = slow_ranges(depths.astype(float).tolist(), unit, camera, scan_height, limits)
    np.testing.assert_allclose(found, np.array(expected, np.float32), rtol=1e-6)


def test_a_wall_in_front_of_the_camera() -> None:
    """All its points have the same x in the frame of the scan, whose y points to the left."""
    camera = Camera(641, 480, 500.0, 320.0, 240.0)
    depths = np.full((480, 641), 2000, np.uint16)
    depths[:, 600:] = 1000  # a nearer part on the right
    ranges = convert(depths, 0.001, camera, 10, 0.45, 10.0)
    first, last, step = camera.angles
    assert (first, last) == pytest.approx((-math.atan(320 / 500), math.atan(320 / 500)))
    directions = first + step * np.arange(641)
    seen = np.isfinite(ranges)
    assert seen.sum() > 500
    np.testing.assert_allclose((ranges * np.cos(directions))[seen & (directions > -0.5)], 2.0, rtol=3e-3)
    np.testing.assert_allclose((ranges * np.cos(directions))[seen & (directions < -0.515)], 1.0, rtol=3e-3)


def info(**fields: Any) -> CameraInfo:
    return CameraInfo(**{"K": [400.0, 0, 300, 0, 400, 200, 0, 0, 1], **fields})


def test_the_camera() -> None:
    assert Camera.of(info(), 640, 480) == Camera(640, 480, 400.0, 300.0, 200.0)
    projection = [500.0, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0]
    assert Camera.of(info(P=projection), 640, 480) == Camera(640, 480, 500.0, 320.0, 240.0)
    roi = RegionOfInterest(x_offset=20, y_offset=40)
    assert Camera.of(info(P=projection, binning_x=2, binning_y=4, roi=roi), 9, 9) == Camera(9, 9, 250.0, 150.0, 50.0)


@pytest.mark.parametrize("matrix", [[0.0] * 9, [math.nan] * 9, [-1.0] + [0.0] * 8, [1.0, 0, math.inf] + [0.0] * 6])
def test_a_camera_without_calibration(matrix: list[float]) -> None:
    with pytest.raises(MessageError, match="no calibration"):
        Camera.of(info(K=matrix), 640, 480)


def test_encodings() -> None:
    for encoding, code, unit in (("16UC1", "u2", 0.001), ("mono16", "u2", 0.001), ("32FC1", "f4", 1.0)):
        for order in "<>":
            pixels = np.arange(6, dtype=order + code).reshape(2, 3)
            padded = b"".join(row.tobytes() + b"!" for row in pixels)
            step = len(padded) // 2
            image = Image(height=2, width=3, encoding=encoding, is_bigendian=order == ">", step=step, data=padded)
            depths, found_unit = read_depths(image)
            assert (depths.tolist(), found_unit) == (pixels.tolist(), unit)


@pytest.mark.parametrize(
    ("fields", "problem"),
    [
        ({"encoding": "rgb8"}, "'rgb8' is not the encoding of a depth image: 16UC1"),
        ({"data": b"12345"}, "5 bytes in rows of 4 are too few for 2 x 2 16UC1"),
        ({"step": 3}, "rows of 3"),
        ({"width": 0}, "too few"),
        ({"height": 2**32 - 1, "width": 2**32 - 1, "step": 2**32 - 1}, "too few"),
    ],
)
def test_damaged_images(fields: dict[str, Any], problem: str) -> None:
    image = Image(**{"height": 2, "width": 2, "encoding": "16UC1", "step": 4, "data": bytes(8), **fields})
    with pytest.raises(MessageError, match=problem):
        read_depths(image)
