"""Plots of figures over a number that grows, as SVG inside a page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape

from table import number

WIDTH, HEIGHT = 460, 230
LEFT, RIGHT, TOP, BOTTOM = 52, 24, 26, 34

Curve = Sequence[tuple[float, float]]


def curves(title: str, lines: Mapping[str, Curve], across: str) -> str:
    """Return a plot whose axes begin at 0, so that what does not grow is level.

    Args:
        title: what is measured, with its unit.
        lines: points by the name of what they belong to, which is also their style; those without a value are left out.
        across: the name of the number that grows.
    """
    known = {name: [(x, y) for x, y in line if not math.isnan(y)] for name, line in lines.items()}
    points = [point for line in known.values() for point in line]
    if not points:
        return ""
    most_x, top = max(x for x, _ in points), round_up(max(y for _, y in points))

    def place(x: float, y: float) -> tuple[float, float]:
        return (
            LEFT + (WIDTH - LEFT - RIGHT) * x / most_x,
            HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * y / top,
        )

    parts = [
        f'<svg viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" role="img" aria-label="{escape(title)}">',
        f'<text x="0" y="14">{escape(title)}</text>',
    ]
    for step in range(5):
        x, y = place(0, top * step / 4)
        parts.append(f'<line class="grid" x1="{x:.1f}" x2="{WIDTH - RIGHT}" y1="{y:.1f}" y2="{y:.1f}"/>')
        words = number(top * step / 4)
        parts.append(f'<text class="faint" x="{x - 6:.1f}" y="{y + 4:.1f}" text-anchor="end">{words}</text>')
    for x in sorted({x for x, _ in points}):
        at, y = place(x, 0)
        parts.append(f'<text class="faint" x="{at:.1f}" y="{y + 15:.1f}" text-anchor="middle">{x:g}</text>')
    parts.append(f'<text class="faint" x="{LEFT}" y="{HEIGHT - 4}">{escape(across)}</text>')
    for name, line in known.items():
        placed = [place(x, y) for x, y in line]
        drawn = " ".join(f"{x:.1f},{y:.1f}" for x, y in placed)
        parts.append(f'<g class="{name}"><polyline class="trend" points="{drawn}"/>')
        for (x, y), (size, value) in zip(placed, line, strict=True):
            words = f"{name}, {size:g}: {number(value)}"
            parts.append(f'<circle class="dot" cx="{x:.1f}" cy="{y:.1f}" r="4"><title>{words}</title></circle>')
        parts.append("</g>")
    return "".join([*parts, "</svg>"])


def round_up(value: float) -> float:
    """The next number that looks well at the top of an axis."""
    if value <= 0:
        return 1.0
    unit = 10.0 ** math.floor(math.log10(value))
    return next(step * unit for step in (1, 2, 4, 6, 8, 10) if step * unit >= value)
