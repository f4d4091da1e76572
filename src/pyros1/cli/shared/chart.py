"""Draws curves in a terminal, using braille characters, each of which is two dots wide and four dots high.

This module has no side effects.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

CurvePoints = Sequence[tuple[float, float]]
"""Points (time in s, value) in chronological order."""

COLOURS = (36, 33, 35, 32, 34, 31)
"""ANSI codes of the curves' colours. If there are more curves, the colours are repeated."""

_DOT_BITS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
"""The bits of the dots in a braille character, by row and column."""
_AXIS_WIDTH = 11  # columns to the left of the canvas


class Canvas:
    """A grid of coloured dots.

    Args:
        columns, rows: the size in characters.

    Attributes:
        width, height: the size in dots.
    """

    def __init__(self, columns: int, rows: int) -> None:
        self.width, self.height = 2 * columns, 4 * rows
        self._columns = columns
        self._cells = [[0] * columns for _ in range(rows)]
        self._colours = [[-1] * columns for _ in range(rows)]

    def set_dot(self, x: int, y: int, colour: int) -> None:
        """Set a dot. x is counted from the left, y from the bottom. Dots outside the canvas are ignored."""
        if 0 <= x < self.width and 0 <= y < self.height:
            row, dot_row = divmod(self.height - 1 - y, 4)
            self._cells[row][x // 2] |= _DOT_BITS[dot_row][x % 2]
            self._colours[row][x // 2] = colour

    def draw_line(self, x0: int, y0: int, x1: int, y1: int, colour: int) -> None:
        """Draw a straight line between two dots."""
        steps = max(abs(x1 - x0), abs(y1 - y0), 1)
        for step in range(steps + 1):
            self.set_dot(round(x0 + (x1 - x0) * step / steps), round(y0 + (y1 - y0) * step / steps), colour)

    def render_rows(self, coloured: bool) -> list[str]:
        """Return the rows of characters as strings, from top to bottom."""
        return [self._render_row(row, coloured) for row in range(len(self._cells))]

    def _render_row(self, row_index: int, coloured: bool) -> str:
        parts, last_colour = [], -1
        for cell, cell_colour in zip(self._cells[row_index], self._colours[row_index], strict=True):
            colour = cell_colour if cell else -1
            if coloured and colour != last_colour:
                parts.append("\033[0m" if colour < 0 else f"\033[{COLOURS[colour % len(COLOURS)]}m")
                last_colour = colour
            parts.append(chr(0x2800 + cell) if cell else " ")
        return "".join(parts) + ("\033[0m" if coloured and last_colour >= 0 else "")


def nice_range(low: float, high: float) -> tuple[float, float]:
    """Return two different round numbers that enclose the range from ``low`` to ``high``."""
    if not low < high:
        margin = abs(low) * 0.1 or 1.0
        low, high = low - margin, high + margin
    step = 10.0 ** math.floor(math.log10((high - low) / 2)) if high - low > 1e-300 else 1e-300
    return math.floor(low / step) * step, math.ceil(high / step) * step


def render_chart(
    curves: Sequence[tuple[str, CurvePoints]], now: float, period: float, size: tuple[int, int], coloured: bool
) -> str:
    """Return a chart of the last ``period`` seconds as lines of text.

    Args:
        curves: the label and points of each curve.
        now: the time at the right edge in s.
        period: the length of the time axis in s.
        size: the numbers of columns and rows of the whole chart, including its axes and legend.
        coloured: whether to use ANSI colours.
    """
    columns, rows = max(10, size[0] - _AXIS_WIDTH - 1), max(4, size[1] - 2 - len(curves))
    canvas = Canvas(columns, rows)
    start_time = now - period
    visible_curves = [
        [(time, value) for time, value in points if time >= start_time and math.isfinite(value)] for _, points in curves
    ]
    values = [value for points in visible_curves for _, value in points]
    low, high = nice_range(min(values), max(values)) if values else (0.0, 1.0)
    for curve_index, curve in enumerate(visible_curves):
        previous_point = None
        for time, value in curve:
            x = round((time - start_time) / period * (canvas.width - 1))
            y = round((value - low) / (high - low) * (canvas.height - 1))
            canvas.draw_line(*(previous_point or (x, y)), x, y, curve_index)
            previous_point = (x, y)
    lines = []
    tick_values = {round(part / 4 * (rows - 1)): high - (high - low) * part / 4 for part in range(5)}
    for row, text in enumerate(canvas.render_rows(coloured)):
        label = f"{tick_values[row]:.4g}" if row in tick_values else ""
        lines.append(f"{label:>{_AXIS_WIDTH - 1}} \u2502{text}")
    lines.append(" " * _AXIS_WIDTH + "\u2514" + "\u2500" * columns)
    start_label = f"{-period:g} s"
    lines.append(" " * (_AXIS_WIDTH + 1) + start_label + "now".rjust(columns - len(start_label)))
    for curve_index, ((label, points), visible_points) in enumerate(zip(curves, visible_curves, strict=True)):
        legend_line = f"\033[{COLOURS[curve_index % len(COLOURS)]}m\u2501\u2501\033[0m" if coloured else "\u2501\u2501"
        last_value = f"{points[-1][1]:.6g}" if points else "no data yet"
        rate = (
            f", {(len(visible_points) - 1) / (visible_points[-1][0] - visible_points[0][0]):.1f} Hz"
            if _spans_time(visible_points)
            else ""
        )
        lines.append(f"{legend_line} {label} = {last_value}{rate}")
    return "\n".join(lines)


def _spans_time(points: CurvePoints) -> bool:
    return len(points) > 1 and points[-1][0] > points[0][0]
