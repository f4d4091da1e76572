"""Describes launched processes for a page, and reads the last lines of their log files."""

from __future__ import annotations

import signal
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pyros1.launch.running.control import Report, Status

MAX_PROCESSES = 500
"""Maximum number of processes per launch that are sent to a page."""
_MAX_TAIL_BYTES = 32_000
_MAX_TAIL_LINES = 200
_LOG_SUFFIXES = (".log", "-stdout.log", "-stderr.log")
_EXIT_CODE_MEANINGS = {
    126: "the program cannot be executed",
    127: "a command was not found",
    255: "a connection was lost, or the program returned this code",
}

CpuSample = tuple[float, float]
"""A point in time, and the CPU time used until then, both in seconds."""


def describe(report: Report, now: float, earlier_samples: Mapping[tuple[str, int], CpuSample]) -> dict[str, Any]:
    """Return a launch's description for a page.

    Args:
        report: the launch's own report.
        now: monotonic time in seconds.
        earlier_samples: earlier CPU times, by label and process id; see `cpu_times`.

    Returns:
        ``{"title", "pid", "uptime", "expected", "refusal", "count", "processes": [{"label", "node", "state", "pid",
        "starts", "uptime", "cpu" (a percentage), "memory", "machine", "exit", "required", "respawn", "log"}]}``, with
        null for unknown values.
    """
    processes = report.processes
    if len(processes) > MAX_PROCESSES:  # those that are not running need attention, so they are kept
        processes = sorted(processes, key=lambda entry: entry.state == "running")[:MAX_PROCESSES]
    return {
        "title": report.title,
        "pid": report.pid,
        "uptime": _none_if_unknown(report.uptime),
        "expected": report.expected,
        "refusal": report.refusal,
        "count": len(report.processes),
        "processes": [_describe(entry, now, earlier_samples) for entry in processes],
    }


def _describe(entry: Status, now: float, earlier_samples: Mapping[tuple[str, int], CpuSample]) -> dict[str, Any]:
    is_running = entry.state in ("running", "stopping")
    return {
        "label": entry.label,
        "node": entry.node,
        "state": entry.state,
        "pid": entry.pid if is_running and entry.pid > 0 else None,
        "starts": entry.starts,
        "uptime": _none_if_unknown(entry.uptime),
        "cpu": _cpu_percentage(entry, now, earlier_samples.get((entry.label, entry.pid))),
        "memory": _none_if_unknown(entry.memory),
        "machine": entry.machine,
        "exit": "" if is_running or entry.exit_code is None else describe_exit(entry.exit_code),
        "required": entry.required,
        "respawn": entry.respawn,
        "log": bool(entry.log),
    }


def cpu_times(report: Report, now: float) -> dict[tuple[str, int], CpuSample]:
    """Return the CPU times of a launch's processes, by label and process id."""
    return {(entry.label, entry.pid): (now, entry.cpu) for entry in report.processes if entry.cpu >= 0}


def _cpu_percentage(entry: Status, now: float, earlier_sample: CpuSample | None) -> float | None:
    if earlier_sample is None or entry.cpu < 0 or now <= earlier_sample[0]:
        return None
    return max(0.0, round(100 * (entry.cpu - earlier_sample[1]) / (now - earlier_sample[0]), 1))


def _none_if_unknown(value: float) -> float | None:
    return value if 0 <= value < float("inf") else None


def describe_exit(code: int) -> str:
    """Return an exit code's description for a page.

    Args:
        code: the exit code; the negative number of the signal if one killed the process.
    """
    if code < 0:
        try:
            return f"ended by {signal.Signals(-code).name}"
        except ValueError:
            return f"ended by signal {-code}"
    if code == 0:
        return "exit code 0"
    reason = _EXIT_CODE_MEANINGS.get(code)
    return f"exit code {code}: {reason}" if reason else f"exit code {code}"


def log_files(base: str, folder: Path) -> list[Path]:
    """Return a process's existing log files.

    The path is sent by the launch, and any program that can reach the master can claim to be a launch, so only files
    inside the folder of log files are returned.

    Args:
        base: the files' path without suffixes such as ``.log``.
        folder: the folder of log files in this environment.
    """
    log_folder = folder.resolve()
    paths = [Path(base + suffix).resolve() for suffix in _LOG_SUFFIXES]
    return [path for path in paths if path.is_relative_to(log_folder) and path.is_file()]


def last_lines(path: Path) -> str:
    """Return the last lines of a text file.

    Raises:
        OSError: the file cannot be read.
    """
    with path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(max(0, size - _MAX_TAIL_BYTES))
        data = file.read(_MAX_TAIL_BYTES)
    text = data.decode(errors="replace")
    if size > len(data):
        text = text.partition("\n")[2] or text
    return "\n".join(text.splitlines()[-_MAX_TAIL_LINES:])
