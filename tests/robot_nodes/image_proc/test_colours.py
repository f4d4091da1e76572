from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pyros1.robot_nodes.image_proc.colours import demosaic, halve_bayer, to_bgr, to_mono
from pyros1.robot_nodes.image_proc.pixels import ImageError, parse_encoding

PATTERNS = ("rggb", "bggr", "gbrg", "grbg")
SIZES = [(3, 3), (3, 8), (4, 4), (5, 6), (8, 3), (7, 9)]


def colour_at(pattern: str, y: int, x: int) -> str:
    return pattern[y % 2 * 2 + x % 2]


def simple_demosaic(raw: Any, pattern: str) -> Any:
    """The mean of the nearest pixels of each colour, for one pixel after the other."""
    height, width = raw.shape
    result = np.zeros((height, width, 3), int)
    for y in range(height):
        for x in range(width):
            row, column = min(max(y, 1), height - 2), min(max(x, 1), width - 2)
            for place, colour in enumerate("bgr"):
                near: dict[int, list[int]] = {}
                for dy in (-1, 0, 1):
                    for dx in (-1, 0, 1):
                        if colour_at(pattern, row + dy, column + dx) == colour:
                            near.setdefault(abs(dy) + abs(dx), []).append(int(raw[row + dy, column + dx]))
                values = near[min(near)]
                result[y, x, place] = (sum(values) + len(values) // 2) // len(values)
    return result


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("dtype", ["u1", "u2"])
def test_bayer_patterns_become_colours(pattern: str, size: tuple[int, int], dtype: str) -> None:
    raw = np.random.default_rng(3).integers(0, np.iinfo(dtype).max, size, dtype, endpoint=True)
    found = demosaic(raw, pattern)
    assert found.dtype == raw.dtype and (found == simple_demosaic(raw, pattern)).all()


@pytest.mark.parametrize("size", [(1, 1), (2, 8), (8, 2)])
def test_an_image_may_be_too_small_for_a_pattern(size: tuple[int, int]) -> None:
    with pytest.raises(ImageError, match="3 x 3 pixels or more"):
        demosaic(np.zeros(size, "u1"), "rggb")


@pytest.mark.parametrize("pattern", PATTERNS)
def test_halving_makes_one_pixel_of_four(pattern: str) -> None:
    raw = np.random.default_rng(4).integers(0, 65536, (7, 9), "u2")
    found = halve_bayer(raw, pattern)
    assert found.shape == (3, 4, 3) and found.dtype == np.uint16
    for y in range(3):
        for x in range(4):
            values: dict[str, list[int]] = {"b": [], "g": [], "r": []}
            for place in range(4):
                values[pattern[place]].append(int(raw[2 * y + place // 2, 2 * x + place % 2]))
            assert found[y, x].tolist() == [values["b"][0], sum(values["g"]) // 2, values["r"][0]]


@pytest.mark.parametrize("encoding", ["bgr8", "rgb8", "bgra8", "rgba16", "bgr16"])
def test_greys_weigh_the_colours(encoding: str) -> None:
    meaning = parse_encoding(encoding)
    size = (6, 5, meaning.channels)
    pixels = np.random.default_rng(5).integers(0, np.iinfo(meaning.dtype).max, size, meaning.dtype, endpoint=True)
    grey, name = to_mono(pixels, meaning)
    red, blue = (0, 2) if encoding.startswith("rgb") else (2, 0)
    exact = 0.299 * pixels[..., red] + 0.587 * pixels[..., 1] + 0.114 * pixels[..., blue]
    assert name == f"mono{8 * meaning.dtype.itemsize}" and grey.dtype == meaning.dtype
    assert np.abs(grey - exact).max() <= 0.5 + np.iinfo(meaning.dtype).max / 2**15


def test_white_stays_white() -> None:
    for encoding in ("bgr8", "bgr16", "bayer_rggb8", "bayer_rggb16"):
        meaning = parse_encoding(encoding)
        most = np.iinfo(meaning.dtype).max
        white = np.full((4, 4, 3) if meaning.channels == 3 else (4, 4), most, meaning.dtype)
        assert (to_mono(white, meaning)[0] == most).all()


@pytest.mark.parametrize(("encoding", "order"), [("yuv422", "uyvy"), ("yuv422_yuy2", "yuyv")])
def test_yuv(encoding: str, order: str) -> None:
    """Colours of a television's test picture, with the numbers of its standard."""
    known = {"white": (235, 128, 128), "red": (81, 90, 240), "green": (145, 54, 34), "blue": (41, 240, 110)}
    bgr = {"white": (255, 255, 255), "red": (0, 0, 255), "green": (0, 255, 0), "blue": (255, 0, 0)}
    for name, (y, u, v) in known.items():
        values = {"y": y, "u": u, "v": v}
        pixels = np.array([[values[letter] for letter in order] * 2] * 2, "u1").reshape(2, 4, 2)
        found, kind = to_bgr(pixels, parse_encoding(encoding))
        assert kind == "bgr8" and found.shape == (2, 4, 3) and np.abs(found.astype(int) - bgr[name]).max() <= 2
        grey, kind = to_mono(pixels, parse_encoding(encoding))
        assert kind == "mono8" and (grey == y).all()


def test_depths_have_no_grey() -> None:
    with pytest.raises(ImageError, match="32FC1 cannot be converted"):
        to_mono(np.zeros((4, 4), "f4"), parse_encoding("32FC1"))
