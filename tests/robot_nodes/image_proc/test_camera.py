from __future__ import annotations

from math import atan, cos, hypot, sin
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.sensor_msgs.msg import CameraInfo
from pyros1.robot_nodes.image_proc.camera import Camera, UncalibratedError, is_undistorted
from pyros1.robot_nodes.image_proc.pixels import ImageError

COUNTS = {"plumb_bob": 5, "rational_polynomial": 8, "equidistant": 4}


def make_info(seed: int, model: str, count: int | None = None) -> Any:
    chance = np.random.default_rng(seed)
    info = CameraInfo(height=12, width=16, distortion_model=model)
    info.D = chance.normal(0, 0.05, COUNTS[model] if count is None else count).tolist()
    fx, fy, cx, cy = 14 + chance.random() * 4, 13 + chance.random() * 4, 7 + chance.random(), 5 + chance.random()
    info.K = [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0]
    c, s = cos(seed / 20), sin(seed / 20)
    info.R = [c, 0.0, s, 0.0, 1.0, 0.0, -s, 0.0, c]
    info.P = [15.0, 0.0, 8.0, -3.0, 0.0, 15.0, 6.0, 0.0, 0.0, 0.0, 1.0, 0.0]
    return info


def simple_position(info: Any, u: float, v: float) -> tuple[float, float]:
    """The formulas of the page CameraInfo, and of the fisheye model, for one pixel."""
    ray = np.array([(u - info.P[2]) / info.P[0], (v - info.P[6]) / info.P[5], 1.0])
    x, y, w = np.array(info.R).reshape(3, 3).T @ ray
    x, y = x / w, y / w
    d = [*info.D, *[0.0] * 12]
    r2 = x * x + y * y
    if info.distortion_model == "equidistant":
        r = hypot(x, y)
        t = atan(r)
        scale = (t + d[0] * t**3 + d[1] * t**5 + d[2] * t**7 + d[3] * t**9) / r if r else 1.0
        x, y = x * scale, y * scale
    else:
        radial = (1 + d[0] * r2 + d[1] * r2**2 + d[4] * r2**3) / (1 + d[5] * r2 + d[6] * r2**2 + d[7] * r2**3)
        x, y = (
            x * radial + 2 * d[2] * x * y + d[3] * (r2 + 2 * x * x) + d[8] * r2 + d[9] * r2**2,
            y * radial + d[2] * (r2 + 2 * y * y) + 2 * d[3] * x * y + d[10] * r2 + d[11] * r2**2,
        )
    return info.K[0] * x + info.K[2], info.K[4] * y + info.K[5]


@pytest.mark.parametrize("model", COUNTS)
@pytest.mark.parametrize("seed", range(4))
def test_positions_follow_the_models(model: str, seed: int) -> None:
    info = make_info(seed, model)
    x, y = Camera.from_info(info).source_positions()
    assert x.shape == y.shape == (12, 16)
    for v in range(12):
        for u in range(16):
            assert (x[v, u], y[v, u]) == pytest.approx(simple_position(info, u, v), abs=1e-9)


def test_models_with_fewer_and_more_coefficients() -> None:
    for model, count in (("plumb_bob", 4), ("rational_polynomial", 12), ("rational_polynomial", 14)):
        info = make_info(1, model, count)
        x, y = Camera.from_info(info).source_positions()
        info.D = info.D[:12]
        assert (x[3, 4], y[3, 4]) == pytest.approx(simple_position(info, 4, 3), abs=1e-9)


def test_a_region_of_interest_is_a_part_of_the_full_map() -> None:
    info = make_info(2, "plumb_bob")
    x, y = Camera.from_info(info).source_positions()
    info.roi.x_offset, info.roi.y_offset, info.roi.width, info.roi.height = 3, 2, 9, 7
    camera = Camera.from_info(info)
    part_x, part_y = camera.source_positions()
    assert camera.size == (7, 9)
    assert np.allclose(part_x, x[2:9, 3:12] - 3) and np.allclose(part_y, y[2:9, 3:12] - 2)


def test_binning_scales_the_matrices() -> None:
    info = make_info(3, "plumb_bob")
    info.binning_x, info.binning_y = 2, 3
    x, y = Camera.from_info(info).source_positions()
    assert x.shape == (4, 8)
    whole_x, whole_y = simple_position(info, 5 * 2, 3 * 3)
    assert (x[3, 5], y[3, 5]) == pytest.approx((whole_x / 2, whole_y / 3), abs=1e-9)


def test_missing_matrices_are_the_usual_ones() -> None:
    info = make_info(0, "plumb_bob")
    info.R, info.P = [0.0] * 9, [0.0] * 12
    info.D = [0.0] * 5
    x, y = Camera.from_info(info).source_positions()
    v, u = np.mgrid[0:12, 0:16]
    assert np.allclose(x, u) and np.allclose(y, v) and is_undistorted(info)


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"distortion_model": "fov"}, "the distortion model 'fov' is unknown: use plumb_bob"),
        ({"D": [float("nan")]}, "not finite"),
        ({"P": [1.0, *[0.0] * 11]}, "cannot be inverted"),
    ],
)
def test_camera_infos_that_cannot_be_used(changes: dict[str, Any], problem: str) -> None:
    info = make_info(0, "plumb_bob")
    for name, value in changes.items():
        setattr(info, name, value)
    with pytest.raises(ImageError, match=problem):
        Camera.from_info(info).source_positions()


def test_an_uncalibrated_camera() -> None:
    with pytest.raises(UncalibratedError, match="uncalibrated"):
        Camera.from_info(CameraInfo(height=4, width=4, distortion_model="plumb_bob"))


def test_equal_cameras_need_no_new_map() -> None:
    assert Camera.from_info(make_info(1, "plumb_bob")) == Camera.from_info(make_info(1, "plumb_bob"))
    assert Camera.from_info(make_info(1, "plumb_bob")) != Camera.from_info(make_info(2, "plumb_bob"))
