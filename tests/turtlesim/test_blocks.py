"""The picture as text."""

from __future__ import annotations

import re

from pyros1.turtlesim.blocks import render_blocks
from pyros1.turtlesim.canvas import Canvas
from pyros1.turtlesim.turtle import PICTURE_SIZE, WORLD_SIZE, Pen, Position

ESCAPE = re.compile("\x1b\\[[0-9;]*m")


def drawn(canvas: Canvas, columns: int, rows: int, **turtles: tuple[float, float, float]) -> list[str]:
    return render_blocks(canvas.pixels(), PICTURE_SIZE, PICTURE_SIZE, turtles, columns, rows)


def test_it_fits_and_is_not_distorted() -> None:
    for columns, rows in ((80, 24), (30, 50), (1, 1), (200, 60)):
        lines = [ESCAPE.sub("", line) for line in drawn(Canvas((1, 2, 3)), columns, rows)]
        assert 1 <= len(lines) <= rows and all(len(line) <= columns for line in lines)
        assert {len(line) for line in lines} == {max(1, min(columns, 2 * rows))}
        assert len(lines) == max(1, min(columns, 2 * rows) // 2)


def test_thin_lines_are_not_lost() -> None:
    canvas = Canvas((1, 2, 3))
    canvas.draw_line(Position(0, 3), Position(WORLD_SIZE, 3), Pen(200, 100, 50, 3))
    assert sum("200;100;50" in line for line in drawn(canvas, 40, 20)) in (1, 2)
    assert drawn(Canvas((1, 2, 3)), 40, 20)[0].count("\x1b") == 3, "colours are said when they change"


def test_turtles_look_where_they_go() -> None:
    lines = drawn(
        Canvas((255, 255, 255)),
        80,
        40,
        one=(WORLD_SIZE / 2, WORLD_SIZE / 2, 1.6),
        two=(WORLD_SIZE, WORLD_SIZE, -3.1),
        three=(0, 0, 0),
    )
    plain = [ESCAPE.sub("", line) for line in lines]
    assert "↑▀one" in plain[20] or "↑▀one" in plain[19]
    assert plain[0].endswith("←") and plain[-1].startswith("→▀three")


def test_turtles_that_are_nowhere_are_left_out() -> None:
    lines = drawn(Canvas((1, 2, 3)), 40, 20, lost=(float("nan"), 1.0, 0.0), far=(1.0, float("inf"), 0.0))
    assert not any(name in line for line in lines for name in ("lost", "far"))
