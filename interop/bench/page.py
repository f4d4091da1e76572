"""The figures as an HTML page with plots, and the history of runs, a line of JSON each.

The page is one file: styles and plots (SVG) are inside, and it asks no server for anything.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator
from html import escape
from itertools import groupby
from pathlib import Path
from typing import Any

from conditions import QUIET
from model import OURS
from table import number

STYLE = """
:root { color-scheme: light dark; --ink: #1b1f24; --faint: #68727d; --line: #d5dae0; --back: #ffffff; --roscpp: #0b6bcb;
  --rospy: #b35900; --bad: #c4261d; --good: #1a7f37 }
@media (prefers-color-scheme: dark) { :root { --ink: #e6e9ed; --faint: #97a1ac; --line: #39414a; --back: #14181d;
  --roscpp: #5cacff; --rospy: #f0a04b; --bad: #ff7b72; --good: #4cc26a } }
body { font: 15px/1.45 system-ui, sans-serif; color: var(--ink); background: var(--back); margin: 2rem auto;
  max-width: 72rem; padding: 0 1rem }
h1 { font-size: 1.5rem }
h2 { font-size: 1.15rem; margin-top: 2.2rem; border-top: 1px solid var(--line); padding-top: 1rem }
p.about, .faint { color: var(--faint) } .bad { color: var(--bad) } .good { color: var(--good) }
div.wide { overflow-x: auto } table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .87rem }
td, th { padding: .2rem .7rem .2rem 0; text-align: right; white-space: nowrap; border-bottom: 1px solid var(--line) }
td:first-child, th:first-child, td.goals { text-align: left } svg { display: block; max-width: 100%; height: auto }
svg text { font: 12px system-ui, sans-serif; fill: var(--ink) } svg text.faint { fill: var(--faint) }
svg text.bad { fill: var(--bad) } .roscpp { --kind: var(--roscpp) } .rospy { --kind: var(--rospy) }
svg .dot { fill: var(--kind) } svg .range { stroke: var(--kind); stroke-width: 3; opacity: .45 }
svg .goal { stroke: var(--kind); stroke-width: 2 } svg .trend { stroke: var(--kind); fill: none; stroke-width: 1.5 }
svg .grid { stroke: var(--line) } svg .even { stroke: var(--faint) }
.legend span { color: var(--kind); margin-right: 1.2rem }
"""

LABEL, WIDTH, HIGH = 330, 980, 22
"""Pixels: the names' column, the plot, and one row of it."""


def history_line(report: dict[str, Any]) -> str:
    """One run as a line of a history file: where and when, and the ratios and medians of its rows."""
    rows = {f"{row['group']}: {label(row)}": {"ratio": row["ratio"], "median": row["median"]} for row in report["rows"]}
    return json.dumps({"about": report["about"], "rows": rows}, separators=(",", ":"))


def label(row: dict[str, Any]) -> str:
    """A row's name with the condition, unless the machine was quiet."""
    return row["name"] if row["condition"] == QUIET else f"{row['name']} [{row['condition']}]"


def read_history(file: Path) -> list[dict[str, Any]]:
    """The runs in a history file, the oldest first; none if there is no such file.

    Raises:
        ValueError: a line is not a run; the error names file and line.
    """
    runs = []
    lines = file.read_text(encoding="utf-8").splitlines() if file.exists() else []
    for place, line in enumerate(lines, 1):
        try:
            run = json.loads(line)
            run["about"]["date"], run["rows"].items()
        except (ValueError, KeyError, TypeError, AttributeError):
            raise ValueError(f"{file}:{place}: not a run as --history writes it") from None
        runs.append(run)
    return runs


def page(report: dict[str, Any], history: list[dict[str, Any]]) -> str:
    """The page of one run.

    Args:
        report: what `table.report` returns.
        history: earlier runs and this one, the oldest first.

    Returns:
        The HTML.
    """
    rows = report["rows"]
    goals = [goal for row in rows for goal in row["goals"]]
    missed = [row for row in rows if not all(goal["met"] for goal in row["goals"])]
    parts = [
        f'<!doctype html><html lang="en"><meta charset="utf-8"><title>pyros1: benchmarks</title><style>{STYLE}</style>',
        '<meta name="viewport" content="width=device-width"><h1>pyros1 beside stock ROS 1</h1>',
        f'<p class="about">{escape(circumstances(report["about"]))}</p>',
        f"<p>{sum(goal['met'] for goal in goals)} of {len(goals)} goals are met.</p>",
    ]
    if missed:
        parts += ["<p>Missed:</p><ul>", *(f"<li>{missed_text(row)}</li>" for row in missed), "</ul>"]
    if report["losses"]:
        lines = (f'<li class="bad">{escape(text)}</li>' for text in report["losses"])
        parts += ["<p>Better than:</p><ul>", *lines, "</ul>"]
    parts.append(
        '<p class="legend">How many times better than another library (log scale; right is better): '
        '<span class="roscpp">● the column roscpp</span><span class="rospy">● the column rospy</span>'
        "bars: all runs; a stroke: the goal</p>"
    )
    parts.append(
        '<p class="faint">Other libraries are in these columns, too: rosmaster, rostopic and other tools, roslaunch '
        "and genpy in the last one; stock's recorder and player in the one before, rosbag and rosbags in the last one "
        "of the bags. In the group rospy the first one is our rospy, the second one our Node.</p>"
    )
    for group, members in groupby(rows, lambda row: row["group"]):
        few = list(members)
        parts += [f"<h2>{escape(group)}</h2>", plot(few), figures(few, history)]
    parts += ["<h2>Runs</h2>", runs_table(history), "</html>"]
    return "\n".join(parts) + "\n"


def circumstances(about: dict[str, Any]) -> str:
    """The line below the title."""
    return (
        f"{about['date']}, commit {about['commit']}, Python {about['python']}, {about['cpu']} with {about['cores']} "
        f"processors, {about['system']}; {about['runs']} x {about['seconds']:g} s; load before: {about['load']:.1f}"
    )


def missed_text(row: dict[str, Any]) -> str:
    """A row that misses its goals, and by how much."""
    goals = ", ".join(goal["goal"] for goal in row["goals"] if not goal["met"])
    ratios = ", ".join(f"{ratio:.2f} x {column}" for column, ratio in row["ratio"].items() if ratio is not None)
    ours = row["median"].get(OURS)
    figure = "no figure" if ours is None else f"{number(ours)} {row['unit']}"
    words = escape(f"{figure}; {ratios}; goal {goals}")
    return f'{escape(row["group"])}: {escape(label(row))}: <span class="bad">{words}</span>'


def plot(rows: list[dict[str, Any]]) -> str:
    """The ratios of a group as SVG: a dot at the median, a bar from the least to the most, a stroke at the goal."""
    marks = [value for row in rows for value in plotted(row)]
    if not marks:
        return ""
    low, high = min(0.5, *marks), max(2.0, *marks)
    room = WIDTH - LABEL - 20

    def across(ratio: float) -> float:
        return LABEL + room * math.log(ratio / low) / math.log(high / low)

    height = HIGH * (len(rows) + 1)
    parts = [f'<svg viewBox="0 0 {WIDTH} {height}" width="{WIDTH}" role="img" aria-label="ratios">']
    for ratio in steps_of_two(low, high):
        style, x = "even" if ratio == 1 else "grid", across(ratio)
        parts.append(f'<line class="{style}" x1="{x:.1f}" x2="{x:.1f}" y1="0" y2="{height - HIGH}"/>')
        parts.append(f'<text class="faint" x="{x:.1f}" y="{height - 6}" text-anchor="middle">{ratio:g}</text>')
    for place, row in enumerate(rows):
        parts += plot_row(row, place * HIGH, across)
    return "\n".join([*parts, "</svg>"])


def plot_row(row: dict[str, Any], top: float, across: Any) -> Iterator[str]:
    """The marks of one row."""
    style = "" if all(goal["met"] for goal in row["goals"]) else ' class="bad"'
    yield f'<text{style} x="0" y="{top + 15}">{escape(label(row))}</text>'
    for offset, (column, ratio) in zip((7, 15), row["ratio"].items(), strict=False):
        y = top + offset
        for goal in row["goals"]:
            if goal["than"] == column:
                x = across(goal["bound"])
                yield f'<line class="goal {column}" x1="{x:.1f}" x2="{x:.1f}" y1="{y - 5}" y2="{y + 5}"/>'
        if not ratio:
            continue
        ends = positive(row["ratios"].get(column, ()))
        if len(ends) > 1:
            left, right = across(min(ends)), across(max(ends))
            yield f'<line class="range {column}" x1="{left:.1f}" x2="{right:.1f}" y1="{y}" y2="{y}"/>'
        words = f"{ratio:.2f} x {column}"
        yield f'<circle class="dot {column}" cx="{across(ratio):.1f}" cy="{y}" r="4"><title>{words}</title></circle>'


def plotted(row: dict[str, Any]) -> list[float]:
    """All ratios and bounds that a row's plot has to hold."""
    found = positive([ratio for ratio in row["ratio"].values() if ratio])
    for ratios in row["ratios"].values():
        found += positive(ratios)
    return found + [goal["bound"] for goal in row["goals"] if goal["than"]]


def positive(ratios: Iterable[float]) -> list[float]:
    """Those that a log scale can show."""
    return [ratio for ratio in ratios if 0 < ratio < math.inf]


def steps_of_two(low: float, high: float) -> list[float]:
    """The numbers at the axis: powers of two, at most about ten of them."""
    first, last = math.ceil(math.log2(low)), math.floor(math.log2(high))
    every = max(1, -(-(last - first + 1) // 10))
    return [2.0**power for power in range(first, last + 1) if power % every == 0]


def figures(rows: list[dict[str, Any]], history: list[dict[str, Any]]) -> str:
    """The figures of a group as a table, with the way that its ratios took from run to run."""
    heads = ["", "unit"]
    for condition in dict.fromkeys(row["condition"] for row in rows):
        where = "" if condition == QUIET else f"{condition}: "
        heads += [f"{where}{head}" for head in ("ours", "roscpp", "rospy", "vs roscpp", "vs rospy", "goal")]
        heads.append("earlier runs")
    parts = ['<div class="wide"><table><tr>', *(f"<th>{escape(head)}</th>" for head in heads), "</tr>"]
    for name, conditions in groupby(rows, lambda row: row["name"]):
        parts.append(f"<tr><td>{escape(name)}</td>")
        for place, row in enumerate(conditions):
            if not place:
                parts.append(f"<td>{escape(row['unit'])}</td>")
            ratios = [row["ratio"].get(column) for column in ("roscpp", "rospy")]
            cells = [figure(row, column) for column in (OURS, "roscpp", "rospy")]
            cells += ["-" if ratio is None else f"{ratio:.2f}" for ratio in ratios]
            parts += [*(f"<td>{cell}</td>" for cell in cells), f'<td class="goals">{goals_text(row)}</td>']
            parts.append(f"<td>{trend(row, history)}</td>")
        parts.append("</tr>")
    return "".join([*parts, "</table></div>"])


def figure(row: dict[str, Any], column: str) -> str:
    """A cell: the median, and the range below the pointer."""
    values = row["figures"].get(column)
    if values is None:
        return "-"
    if not values:
        return '<span class="bad">failed</span>'
    ends = f"{number(min(values))} to {number(max(values))}"
    return f'<span title="{ends}">{number(row["median"][column])}</span>'


def goals_text(row: dict[str, Any]) -> str:
    """The goals, marked."""
    texts = []
    for goal in row["goals"]:
        style, word = ("good", "✓") if goal["met"] else ("bad", "missed")
        texts.append(f'<span class="{style}">{escape(goal["goal"])} {word}</span>')
    return ", ".join(texts)


def trend(row: dict[str, Any], history: list[dict[str, Any]]) -> str:
    """The ratios of a row in all runs as a small plot; nothing for less than two."""
    name = f"{row['group']}: {label(row)}"
    lines = []
    for column in ("roscpp", "rospy"):
        known = [(place, run["rows"].get(name, {}).get("ratio", {}).get(column)) for place, run in enumerate(history)]
        points = [(place, ratio) for place, ratio in known if ratio and 0 < ratio < math.inf]
        if len(points) > 1:
            lines.append((column, points))
    if not lines:
        return ""
    logs = [math.log(ratio) for _, points in lines for _, ratio in points]
    low, span = min(logs), max(max(logs) - min(logs), 0.2)
    parts = ['<svg viewBox="0 0 120 24" width="120" height="24" role="img" aria-label="earlier runs">']
    for column, points in lines:
        drawn = " ".join(
            f"{4 + 112 * place / max(1, len(history) - 1):.1f},{20 - 16 * (math.log(ratio) - low) / span:.1f}"
            for place, ratio in points
        )
        words = ", ".join(f"{history[place]['about'].get('commit', '?')}: {ratio:.2f}" for place, ratio in points)
        parts.append(f'<polyline class="trend {column}" points="{drawn}"><title>{escape(words)}</title></polyline>')
    return "".join([*parts, "</svg>"])


def runs_table(history: list[dict[str, Any]]) -> str:
    """The runs that the small plots show, the newest first."""
    parts = ['<div class="wide"><table><tr><th>commit</th><th>date</th><th>Python</th><th>runs</th><th>load</th></tr>']
    for run in reversed(history):
        about = run["about"]
        cells = [about.get(key, "?") for key in ("commit", "date", "python")]
        cells += [f"{about.get('runs', '?')} x {about.get('seconds', '?')} s", about.get("load", "?")]
        parts += ["<tr>", *(f"<td>{escape(str(cell))}</td>" for cell in cells), "</tr>"]
    return "".join([*parts, "</table></div>"])
