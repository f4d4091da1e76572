"""The picture of the turtles as text: two pixels in each character, in colour. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, pi
from typing import TYPE_CHECKING, Any

import numpy

from pyros1.turtlesim.turtle import PIXELS_PER_UNIT

if TYPE_CHECKING:
    from pyros1.turtlesim.canvas import Colour

_ARROWS = "→↗↑↖←↙↓↘"
_SAMPLES = 4
"""Pixels inspected for each displayed one, across and down, so that thin lines are not lost."""
_RESET = "\x1b[0m"


def blocks(
    pixels: bytes, width: int, height: int, turtles: Mapping[str, tuple[float, float, float]], columns: int, rows: int
) -> list[str]:
    """Return the lines of a picture, with escape sequences for its colours.

    Args:
        pixels: red, green and blue bytes, row by row from the top.
        width, height: of the picture in pixels.
        turtles: name -> x and y in units, and angle in radians.
        columns, rows: available space in characters; the picture fills as much of it as possible without distortion.
    """
    across = max(1, min(columns, 2 * rows * width // height))
    down = max(1, across * height // width // 2)
    shown = _shrink(numpy.frombuffer(pixels, numpy.uint8).reshape(height, width, 3), across, 2 * down)
    marks = _marks(turtles, width, height, across, down)
    lines = []
    for row in range(down):
        line = []
        before = ""
        for column in range(across):
            top, bottom = shown[2 * row][column], shown[2 * row + 1][column]
            mark = marks.get((column, row))
            colours = _foreground(top if mark is None else _contrast(bottom)) + _background(bottom)
            line.append((colours if colours != before else "") + (mark or "▀"))
            before = colours
        lines.append("".join(line) + _RESET)
    return lines


def _shrink(picture: Any, across: int, down: int) -> Any:
    """Return a smaller picture, as lists; each place has the pixel that differs most from the background."""
    height, width, _ = picture.shape
    rows = numpy.arange(down * _SAMPLES) * height // (down * _SAMPLES)
    columns = numpy.arange(across * _SAMPLES) * width // (across * _SAMPLES)
    parts = picture[rows][:, columns].reshape(down, _SAMPLES, across, _SAMPLES, 3).swapaxes(1, 2)
    parts = parts.reshape(down, across, _SAMPLES * _SAMPLES, 3)
    background = numpy.median(picture[:: _SAMPLES * 2, :: _SAMPLES * 2].reshape(-1, 3), axis=0)
    drawn = numpy.abs(parts - background).sum(axis=3).argmax(axis=2)
    return numpy.take_along_axis(parts, drawn[:, :, None, None], axis=2)[:, :, 0].tolist()


def _marks(
    turtles: Mapping[str, tuple[float, float, float]], width: int, height: int, across: int, down: int
) -> dict[tuple[int, int], str]:
    marks: dict[tuple[int, int], str] = {}
    for name, (x, y, theta) in turtles.items():
        if not isfinite(x + y + theta):  # other nodes may publish that
            continue
        column = min(max(int(x * PIXELS_PER_UNIT * across / width), 0), across - 1)
        row = min(max(int((height - 1 - y * PIXELS_PER_UNIT) * down / height), 0), down - 1)
        for position, letter in enumerate(name[: max(across - column - 2, 0)], column + 2):
            marks.setdefault((position, row), letter)
        marks[column, row] = _ARROWS[round(theta / (pi / 4)) % len(_ARROWS)]
    return marks


def _contrast(colour: Colour) -> Colour:
    return (0, 0, 0) if sum(colour) > 480 else (255, 255, 255)


def _foreground(colour: Colour) -> str:
    return "\x1b[38;2;{};{};{}m".format(*colour)


def _background(colour: Colour) -> str:
    return "\x1b[48;2;{};{};{}m".format(*colour)
