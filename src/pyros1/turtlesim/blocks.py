"""Renders the turtles and their drawing as coloured text, with two pixels per character (no I/O)."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, pi
from typing import TYPE_CHECKING, Any

import numpy

from pyros1.turtlesim.turtle import PIXELS_PER_UNIT

if TYPE_CHECKING:
    from pyros1.turtlesim.canvas import Colour

_ARROW_CHARACTERS = "→↗↑↖←↙↓↘"
_OVERSAMPLING = 4
"""Number of pixels inspected per displayed pixel, in each direction, so that thin lines are not lost."""
_RESET = "\x1b[0m"


def render_blocks(
    pixels: bytes, width: int, height: int, turtles: Mapping[str, tuple[float, float, float]], columns: int, rows: int
) -> list[str]:
    """Return a picture with turtles as lines of text, with escape sequences for the colours.

    Args:
        pixels: red, green and blue bytes, row by row from the top.
        width, height: size of the picture in pixels.
        turtles: name -> x and y (in units), and heading (in radians).
        columns, rows: the available space in characters. The picture is made as large as fits without distortion.
    """
    used_columns = max(1, min(columns, 2 * rows * width // height))
    used_rows = max(1, used_columns * height // width // 2)
    grid = _shrink(numpy.frombuffer(pixels, numpy.uint8).reshape(height, width, 3), used_columns, 2 * used_rows)
    marks = _turtle_marks(turtles, width, height, used_columns, used_rows)
    lines = []
    for row in range(used_rows):
        line = []
        previous_colours = ""
        for column in range(used_columns):
            top, bottom = grid[2 * row][column], grid[2 * row + 1][column]
            mark = marks.get((column, row))
            colours = _foreground_code(top if mark is None else _contrasting_colour(bottom)) + _background_code(bottom)
            line.append((colours if colours != previous_colours else "") + (mark or "▀"))
            previous_colours = colours
        lines.append("".join(line) + _RESET)
    return lines


def _shrink(picture: Any, new_width: int, new_height: int) -> Any:
    """Return a smaller picture, as lists. Each pixel gets the colour in its area that is least like the background."""
    height, width, _ = picture.shape
    rows = numpy.arange(new_height * _OVERSAMPLING) * height // (new_height * _OVERSAMPLING)
    columns = numpy.arange(new_width * _OVERSAMPLING) * width // (new_width * _OVERSAMPLING)
    samples = picture[rows][:, columns].reshape(new_height, _OVERSAMPLING, new_width, _OVERSAMPLING, 3).swapaxes(1, 2)
    samples = samples.reshape(new_height, new_width, _OVERSAMPLING * _OVERSAMPLING, 3)
    background = numpy.median(picture[:: _OVERSAMPLING * 2, :: _OVERSAMPLING * 2].reshape(-1, 3), axis=0)
    most_distinct = numpy.abs(samples - background).sum(axis=3).argmax(axis=2)
    return numpy.take_along_axis(samples, most_distinct[:, :, None, None], axis=2)[:, :, 0].tolist()


def _turtle_marks(
    turtles: Mapping[str, tuple[float, float, float]], width: int, height: int, columns: int, rows: int
) -> dict[tuple[int, int], str]:
    marks: dict[tuple[int, int], str] = {}
    for name, (x, y, theta) in turtles.items():
        if not isfinite(x + y + theta):  # other nodes may publish infinity or NaN
            continue
        column = min(max(int(x * PIXELS_PER_UNIT * columns / width), 0), columns - 1)
        row = min(max(int((height - 1 - y * PIXELS_PER_UNIT) * rows / height), 0), rows - 1)
        for position, letter in enumerate(name[: max(columns - column - 2, 0)], column + 2):
            marks.setdefault((position, row), letter)
        marks[column, row] = _ARROW_CHARACTERS[round(theta / (pi / 4)) % len(_ARROW_CHARACTERS)]
    return marks


def _contrasting_colour(colour: Colour) -> Colour:
    return (0, 0, 0) if sum(colour) > 480 else (255, 255, 255)


def _foreground_code(colour: Colour) -> str:
    return "\x1b[38;2;{};{};{}m".format(*colour)


def _background_code(colour: Colour) -> str:
    return "\x1b[48;2;{};{};{}m".format(*colour)
