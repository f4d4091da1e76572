from __future__ import annotations

from math import floor, inf, isfinite, nan
from typing import Any

import numpy as np
import pytest

from pyros1.robot_nodes.image_proc.remap import LINEAR, NEAREST, Remap

TYPES = ["u1", "u2", "i2", "i4", "f4", "f8"]


def simple_remap(pixels: Any, x: float, y: float, interpolation: int) -> Any:
    """The value at one place of a channel; 0 outside of it."""

    def at(row: int, column: int) -> Any:
        inside = 0 <= row < pixels.shape[0] and 0 <= column < pixels.shape[1]
        return pixels[row, column].item() if inside else 0

    if not (isfinite(x) and isfinite(y)):
        return 0
    x, y = round(x * 32) / 32, round(y * 32) / 32
    if interpolation == NEAREST:
        return at(floor(y + 0.5), floor(x + 0.5))
    left, top = floor(x), floor(y)
    a, b = x - left, y - top
    value = (1 - b) * ((1 - a) * at(top, left) + a * at(top, left + 1))
    value += b * ((1 - a) * at(top + 1, left) + a * at(top + 1, left + 1))
    return value if pixels.dtype.kind == "f" else floor(value + 0.5)


def random_map(seed: int) -> tuple[Any, Any]:
    chance = np.random.default_rng(seed)
    x, y = chance.uniform(-3, 11, (40, 6)), chance.uniform(-3, 9, (40, 6))
    x[chance.random(x.shape) < 0.2] //= 1  # on the pixels
    y[chance.random(y.shape) < 0.2] //= 1
    x[0], y[1] = [nan, inf, -inf, 1e300, -1e300, -1], [nan, inf, -inf, 1e300, -1e300, -1]
    return x, y


@pytest.mark.parametrize("dtype", TYPES)
@pytest.mark.parametrize("interpolation", [NEAREST, LINEAR])
@pytest.mark.parametrize("channels", [0, 1, 3, 4])
def test_pixels_come_from_where_the_map_says(dtype: str, interpolation: int, channels: int) -> None:
    x, y = random_map(channels)
    chance = np.random.default_rng(9)
    shape = (7, 9, channels) if channels else (7, 9)
    top = 1000.0 if dtype[0] == "f" else min(np.iinfo(dtype).max, 2**30)
    low = -top if dtype[0] in "fi" else 0
    pixels = chance.uniform(low, top, shape).astype(dtype)
    found = Remap(x, y, (7, 9), interpolation).apply(pixels)
    assert found.dtype == pixels.dtype and found.shape == (40, 6, *shape[2:])
    for row in range(40):
        for column in range(6):
            for channel in range(max(1, channels)):
                source = pixels[..., channel] if channels else pixels
                value = found[row, column, channel] if channels else found[row, column]
                assert value == pytest.approx(simple_remap(source, x[row, column], y[row, column], interpolation))


def test_the_same_map_may_be_used_for_images_of_several_types() -> None:
    y, x = np.mgrid[0:7, 0:9].astype(float)
    remap = Remap(x, y, (7, 9))
    for dtype in TYPES:
        pixels = np.arange(63 * 3).reshape(7, 9, 3).astype(dtype)
        assert (remap.apply(pixels) == pixels).all() and (remap.apply(pixels[..., 0]) == pixels[..., 0]).all()


def test_large_images_are_the_same_as_their_rows() -> None:
    chance = np.random.default_rng(4)
    x, y = chance.uniform(-3, 203, (430, 210)), chance.uniform(-3, 453, (430, 210))
    pixels = chance.integers(0, 256, (450, 200, 3), np.uint8)
    found = Remap(x, y, (450, 200)).apply(pixels)
    for row in (0, 189, 190, 191, 200, 379, 380, 429):
        one = Remap(x[row : row + 1], y[row : row + 1], (450, 200))
        for channel in range(3):
            assert (found[row, :, channel] == one.apply(pixels[..., channel])[0]).all()
