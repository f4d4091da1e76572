"""The figures as a table, and as JSON."""

from __future__ import annotations

import datetime
import os
import platform
import statistics
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from conditions import QUIET
from harness import STOCK_PYTHON
from model import COLUMNS, OURS, ROSCPP, ROSPY, Results, ResultsByCondition, Row


def number(value: float) -> str:
    """A figure with as many digits as it is worth."""
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def cell(row: Row, results: Results, column: str) -> str:
    """The median, the range when there are several runs, and how many runs failed."""
    if column not in row.steps:
        return "-"
    values = row.values(results, column)
    if not values:
        return "failed"
    text = number(statistics.median(values))
    if len(values) > 1:
        text += f" ({number(min(values))}..{number(max(values))})"
    failures = row.failures(results, column)
    return f"{text}, {failures} failed" if failures else text


def table(rows: list[Row], measured: ResultsByCondition) -> str:
    """The table as Markdown, columns aligned; below it, the rows in which we are better only on a quiet machine."""
    heads = ["work", "unit"]
    for condition in measured:
        where = "" if condition == QUIET else f"{condition}: "
        heads += [*(f"{where}{column}" for column in COLUMNS), f"{where}vs roscpp", f"{where}vs rospy", f"{where}met"]
    lines = [[*heads, "goal"]]
    for row in rows:
        cells = [f"{row.group}: {row.name}", row.unit]
        for condition, results in measured.items():
            ratios = [row.ratio(results, column) for column in (ROSCPP, ROSPY)]
            cells += [cell(row, results, column) for column in COLUMNS]
            cells += ["-" if ratio is None else f"{ratio:.2f}" for ratio in ratios]
            cells.append(", ".join("yes" if row.met(results, goal) else "NO" for goal in row.goals_under(condition)))
        lines.append([*cells, ", ".join(goal.text(row.unit) for goal in row.goals)])
    return "\n".join([markdown(lines), *(f"better than {text}" for text in losses(rows, measured))])


def losses(rows: list[Row], measured: ResultsByCondition) -> list[str]:
    """What we lose under other conditions, a line per row, condition and library."""
    return [
        f"{column} on a quiet machine, worse under {condition!r}: {row.group}: {row.name}"
        for row in rows
        for condition in measured
        for column in row.lost(measured, condition)
    ]


def markdown(lines: Sequence[Sequence[str]]) -> str:
    """Cells as a table of Markdown, columns aligned; the first line has the heads."""
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    padded = [
        "| " + " | ".join(text.ljust(width) for text, width in zip(line, widths, strict=True)) + " |" for line in lines
    ]
    padded.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(padded)


def report(rows: list[Row], measured: ResultsByCondition, runs: int, seconds: float) -> dict[str, Any]:
    """Everything for a JSON file: where it was measured, every figure, ratios and goals under each condition."""
    reports = [row_report(row, results, condition) for row in rows for condition, results in measured.items()]
    return {"about": about(runs, seconds), "rows": reports, "losses": losses(rows, measured)}


def row_report(row: Row, results: Results, condition: str = QUIET) -> dict[str, Any]:
    """One row under one condition. A ratio is how many times better we are; a ratio or median is null if unknown."""
    measured = [column for column in COLUMNS if column in row.steps]
    ratios = {column: row.ratio(results, column) for column in measured if column != OURS}
    return {
        "group": row.group,
        "name": row.name,
        "condition": condition,
        "unit": row.unit,
        "better": "less" if row.less else "more",
        "figures": {column: row.values(results, column) for column in measured},
        "failed": {column: row.failures(results, column) for column in measured},
        "median": {column: row.median(results, column) for column in measured},
        "ratio": {column: None if ratio in (None, float("inf")) else ratio for column, ratio in ratios.items()},
        "ratios": {column: row.ratios(results, column) for column in measured if column != OURS},
        "goals": [
            {"goal": goal.text(row.unit), "met": row.met(results, goal), "than": goal.than, "bound": goal.bound}
            for goal in row.goals_under(condition)
        ],
    }


def about(runs: int, seconds: float) -> dict[str, Any]:
    """The machine and the circumstances."""
    versions = subprocess.run([STOCK_PYTHON, "-V"], capture_output=True, text=True, check=True)
    return {
        "commit": commit(),
        "date": datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds"),
        "python": versions.stdout.split()[1],
        "system": platform.platform(),
        "machine": platform.machine(),
        "cpu": cpu_model(),
        "cores": os.cpu_count(),
        "load": os.getloadavg()[2],
        "runs": runs,
        "seconds": seconds,
    }


def commit() -> str:
    """The commit that is measured, with a + if files were changed since; "?" outside a repository, or without git."""
    here = Path(__file__).parent
    try:
        told = subprocess.run(
            ["git", "describe", "--always", "--dirty=+", "--exclude=*"],
            cwd=here,
            capture_output=True,
            text=True,
            check=False,
        )
    except FileNotFoundError:  # there is no git
        return "?"
    return told.stdout.strip() or "?"


def cpu_model() -> str:
    """The processor as Linux names it."""
    for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        key, _, value = line.partition(":")
        if key.strip() == "model name":
            return value.strip()
    return platform.processor()
