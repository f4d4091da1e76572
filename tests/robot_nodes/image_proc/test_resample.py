from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pyros1.robot_nodes.image_proc.resample import AREA, CUBIC, LINEAR, NEAREST, decimate, resize


def simple_linear(pixels: Any, height: int, width: int) -> Any:
    """Bilinear interpolation between the centres of the pixels, for one after the other."""
    rows, columns = pixels.shape
    result = np.empty((height, width))
    for y in range(height):
        for x in range(width):
            v = min(max((y + 0.5) * rows / height - 0.5, 0), rows - 1)
            u = min(max((x + 0.5) * columns / width - 0.5, 0), columns - 1)
            top, left = int(v), int(u)
            low, right = min(top + 1, rows - 1), min(left + 1, columns - 1)
            upper = pixels[top, left] * (1 - u + left) + pixels[top, right] * (u - left)
            lower = pixels[low, left] * (1 - u + left) + pixels[low, right] * (u - left)
            result[y, x] = upper * (1 - v + top) + lower * (v - top)
    return result


@pytest.mark.parametrize("size", [(1, 1), (3, 4), (5, 14), (6, 8), (12, 5), (7, 9)])
@pytest.mark.parametrize("dtype", ["u1", "u2", "f4"])
def test_linear(size: tuple[int, int], dtype: str) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (6, 8)).astype(dtype)
    expected = simple_linear(pixels.astype(float), *size)
    tolerance = 1e-2 if dtype == "f4" else 0.501
    for method in (LINEAR, CUBIC):
        found = resize(pixels, *size, method)
        assert found.dtype == pixels.dtype and np.abs(found - expected).max() <= tolerance
    colours = resize(np.dstack([pixels, pixels + 1]), *size)
    assert colours.shape == (*size, 2) and np.abs(colours[..., 0] - expected).max() <= tolerance


def test_nearest_and_area() -> None:
    pixels = np.arange(48, dtype="u1").reshape(6, 8)
    assert resize(pixels, 3, 4, NEAREST).tolist() == pixels[::2, ::2].tolist()
    assert resize(pixels, 12, 8, NEAREST).tolist() == pixels.repeat(2, axis=0).tolist()
    found = resize(pixels, 3, 4, AREA)
    exact = pixels.reshape(3, 2, 4, 2).mean(axis=(1, 3))
    assert np.abs(found - exact).max() <= 0.5
    assert (resize(pixels, 6, 8, AREA) == pixels).all()


def test_a_factor_may_not_fit_the_size() -> None:
    """Of 10 pixels and the factor 0.33, 3 are left, 3.03 pixels apart."""
    ramp = np.arange(10, dtype="f4").reshape(1, 10) * 100
    found = resize(ramp, 1, 3, LINEAR, (1.0, 1 / 0.33))
    assert np.allclose(found, [[100 * ((x + 0.5) / 0.33 - 0.5) for x in range(3)]], atol=1e-2)
    assert resize(ramp, 1, 7, NEAREST, (1.0, 1.9)).tolist() == [[0, 100, 300, 500, 700, 900, 900]]


def test_decimation_leaves_the_rest_out() -> None:
    pixels = np.arange(63, dtype="u2").reshape(7, 9)
    assert decimate(pixels, 2, 4, NEAREST).tolist() == pixels[:6:2, :8:4].tolist()
    assert decimate(pixels, 2, 4, AREA).shape == decimate(pixels, 2, 4, LINEAR).shape == (3, 2)
    assert decimate(pixels, 2, 4, AREA)[0, 0] == round(pixels[:2, :4].mean())
