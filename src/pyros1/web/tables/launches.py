"""What launches run, for a page, and the last lines of log files."""

from __future__ import annotations

import signal
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pyros1.launch.running.control import Report, Status

MOST_PROCESSES = 500
"""Most processes of a launch that a page gets."""
_LONGEST_TAIL = 32_000
_MOST_LINES = 200
_ENDINGS = (".log", "-stdout.log", "-stderr.log")
_EXITS = {
    126: "the program cannot be executed",
    127: "a command was not found",
    255: "a connection was lost, or the program says so",
}

Used = tuple[float, float]
"""A time and the CPU time used until then, both in seconds."""


def describe(report: Report, now: float, before: Mapping[tuple[str, int], Used]) -> dict[str, Any]:
    """Return a launch for a page.

    Args:
        report: the launch.
        now: seconds of a clock that does not jump.
        before: what processes had used at an earlier time, by label and process id; see `used`.

    Returns:
        ``{"title", "pid", "uptime", "expected", "refusal", "count", "processes": [{"label", "node", "state", "pid",
        "starts", "uptime", "cpu" (a percentage), "memory", "machine", "exit", "required", "respawn", "log"}]}``, with
        null for what is unknown.
    """
    shown = report.processes
    if len(shown) > MOST_PROCESSES:  # those that need a look are not left out
        shown = sorted(shown, key=lambda entry: entry.state == "running")[:MOST_PROCESSES]
    return {
        "title": report.title,
        "pid": report.pid,
        "uptime": _known(report.uptime),
        "expected": report.expected,
        "refusal": report.refusal,
        "count": len(report.processes),
        "processes": [_describe(entry, now, before) for entry in shown],
    }


def _describe(entry: Status, now: float, before: Mapping[tuple[str, int], Used]) -> dict[str, Any]:
    runs = entry.state in ("running", "stopping")
    return {
        "label": entry.label,
        "node": entry.node,
        "state": entry.state,
        "pid": entry.pid if runs and entry.pid > 0 else None,
        "starts": entry.starts,
        "uptime": _known(entry.uptime),
        "cpu": _percentage(entry, now, before.get((entry.label, entry.pid))),
        "memory": _known(entry.memory),
        "machine": entry.machine,
        "exit": "" if runs or entry.exit_code is None else ending(entry.exit_code),
        "required": entry.required,
        "respawn": entry.respawn,
        "log": bool(entry.log),
    }


def used(report: Report, now: float) -> dict[tuple[str, int], Used]:
    """Return what the processes of a launch have used until now, by label and process id."""
    return {(entry.label, entry.pid): (now, entry.cpu) for entry in report.processes if entry.cpu >= 0}


def _percentage(entry: Status, now: float, before: Used | None) -> float | None:
    if before is None or entry.cpu < 0 or now <= before[0]:
        return None
    return max(0.0, round(100 * (entry.cpu - before[1]) / (now - before[0]), 1))


def _known(value: float) -> float | None:
    return value if 0 <= value < float("inf") else None


def ending(code: int) -> str:
    """Return an exit code in words.

    Args:
        code: negative for a signal.
    """
    if code < 0:
        try:
            return f"ended by {signal.Signals(-code).name}"
        except ValueError:
            return f"ended by signal {-code}"
    if code == 0:
        return "exit code 0"
    why = _EXITS.get(code)
    return f"exit code {code}: {why}" if why else f"exit code {code}"


def log_files(base: str, folder: Path) -> list[Path]:
    """Return the log files of a process that are there.

    A launch says where they are, and whoever reaches the master can claim to be a launch, so only files in one folder
    count.

    Args:
        base: their path without ``.log``.
        folder: the folder of log files of this environment.
    """
    inside = folder.resolve()
    paths = [Path(base + ending).resolve() for ending in _ENDINGS]
    return [path for path in paths if path.is_relative_to(inside) and path.is_file()]


def tail(path: Path) -> str:
    """Return the last lines of a text file.

    Raises:
        OSError: it cannot be read.
    """
    with path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - _LONGEST_TAIL))
        data = file.read(_LONGEST_TAIL)
    text = data.decode(errors="replace")
    if size > len(data):
        text = text.partition("\n")[2] or text
    return "\n".join(text.splitlines()[-_MOST_LINES:])
