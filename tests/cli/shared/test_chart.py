"""chart: curves as braille dots, with axis and legend."""

from __future__ import annotations

import math

from pyros1.cli.shared.chart import Canvas, nice_range, render_chart


def test_dots_are_where_they_should_be() -> None:
    canvas = Canvas(2, 1)
    canvas.set_dot(0, 0, 0)  # bottom left
    canvas.set_dot(3, 3, 0)  # top right
    canvas.set_dot(99, 99, 0)
    canvas.set_dot(-1, 0, 0)
    assert canvas.render_rows(False) == ["\u2840\u2808"]


def test_a_line_has_no_holes() -> None:
    canvas = Canvas(10, 5)
    canvas.draw_line(0, 0, 19, 19, 0)
    assert (
        sum(bin(ord(char) - 0x2800).count("1") for row in canvas.render_rows(False) for char in row if char != " ")
        == 20
    )


def test_ranges_are_round_and_never_empty() -> None:
    assert nice_range(0.0, 0.98) == (0.0, 1.0)
    low, high = nice_range(-3.2, 17.9)
    assert low <= -3.2 and high >= 17.9
    assert nice_range(5.0, 5.0) == (4.5, 5.5)
    assert nice_range(0.0, 0.0) == (-1.0, 1.0)


def test_a_chart_has_axis_legend_and_curve() -> None:
    points = [(i / 10, math.sin(i / 10)) for i in range(100)]
    text = render_chart([("/a/data", points), ("/b/data", [])], 9.9, 10.0, (60, 20), coloured=False)
    lines = text.split("\n")
    assert max(map(len, lines)) <= 60 and len(lines) <= 20
    assert lines[0].lstrip().startswith("1 ") and any(line.lstrip().startswith("-1 ") for line in lines)
    assert lines[-2].startswith("\u2501\u2501 /a/data = ") and lines[-2].endswith("10.0 Hz")
    assert lines[-1].endswith("/b/data = no data yet")
    assert "\033" not in text and "\033[36m" in render_chart([("/a", points)], 9.9, 10.0, (60, 20), coloured=True)


def test_what_is_old_or_no_number_is_left_out() -> None:
    text = render_chart(
        [("/a", [(0.0, 99.0), (9.0, math.nan), (9.5, 1.0), (9.9, 2.0)])], 10.0, 1.0, (40, 12), coloured=False
    )
    assert "99" not in text.split("\n")[0] and text.split("\n")[0].lstrip().startswith("2 ")
