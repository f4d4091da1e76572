"""``node status``: prints the state and resource usage of the processes of running launches."""

from __future__ import annotations

import sys
import time
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.terminal_text import one_line
from pyros1.launch.running.control import Status, running_launches

_CPU_SAMPLE_PERIOD = 0.5


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print all processes of all launches as a table or JSON."""
    if args:
        raise UsageError("too many arguments")
    previous = [] if options.once else _query_processes(invocation)
    if previous:
        time.sleep(_CPU_SAMPLE_PERIOD)
    current = _query_processes(invocation)
    if options.json:
        print_json(as_json(current, previous))
    elif not current:
        print("No launch is running", file=sys.stderr)
    else:
        print(*map(one_line, format_table(current, previous)), sep="\n")


VERB = Verb(
    "status",
    "list the processes of running launches: pid, CPU, memory, restarts, uptime",
    Flag("-1", "--once", help="do not measure CPU usage, which takes half a second"),
    Flag("--json", help="print a JSON list of objects, one for each process", pyros1_only=True),
    examples=[
        ("", "list the processes of all running launches"),
        ("-1", "leave out CPU usage, which saves half a second"),
    ],
    stock="",
    run=run,
)


def _query_processes(invocation: Invocation) -> list[Status]:
    processes = []
    for launch, entries in running_launches(invocation.master):
        launch.close()
        processes += entries
    return processes


def format_table(current: list[Status], previous: list[Status]) -> list[str]:
    """Return the lines of the status table.

    Args:
        current: the current processes.
        previous: the processes at an earlier time. CPU usage is measured from that time until now.
    """
    previous_entries = {(entry.label, entry.pid): entry for entry in previous}
    rows = [("NODE", "STATE", "PID", "CPU", "MEMORY", "RESTARTS", "UPTIME", "MACHINE")]
    for entry in current:
        machine = entry.machine or "-"
        state_text = entry.state if entry.state != "died" else f"died ({entry.exit_code})"
        cpu_percent = _cpu_percent(entry, previous_entries.get((entry.label, entry.pid)))
        cpu_text = f"{cpu_percent:.1f} %" if cpu_percent is not None else "-"
        memory_text = f"{entry.memory / 2**20:.1f} MB" if entry.memory >= 0 else "-"
        uptime_text = _format_duration(entry.uptime) if entry.uptime >= 0 else "-"
        pid_text = str(entry.pid) if _has_process(entry) else "-"
        rows.append(
            (
                entry.node,
                state_text,
                pid_text,
                cpu_text,
                memory_text,
                str(max(0, entry.starts - 1)),
                uptime_text,
                machine,
            )
        )
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    right_aligned = {2, 3, 4, 5, 6}
    return [
        "  ".join(
            text.rjust(width) if column in right_aligned else text.ljust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def as_json(current: list[Status], previous: list[Status]) -> list[dict[str, Any]]:
    """Return the processes as JSON objects: CPU in percent, memory in bytes, uptime in seconds.

    Values that are unknown are None.

    Args:
        current: the current processes.
        previous: the processes at an earlier time. CPU usage is measured from that time until now.
    """
    previous_entries = {(entry.label, entry.pid): entry for entry in previous}
    return [
        {
            "node": entry.node,
            "state": entry.state,
            "exit_code": entry.exit_code,
            "pid": entry.pid if _has_process(entry) else None,
            "cpu": _cpu_percent(entry, previous_entries.get((entry.label, entry.pid))),
            "memory": entry.memory if entry.memory >= 0 else None,
            "restarts": max(0, entry.starts - 1),
            "uptime": entry.uptime if entry.uptime >= 0 else None,
            "machine": entry.machine,
        }
        for entry in current
    ]


def _has_process(entry: Status) -> bool:
    return entry.uptime >= 0 or entry.state == "running"


def _cpu_percent(entry: Status, previous: Status | None) -> float | None:
    """Return the CPU usage since the previous status in percent; None if it is unknown."""
    if previous is None or min(entry.cpu, previous.cpu) < 0 or entry.uptime <= previous.uptime:
        return None
    return 100 * (entry.cpu - previous.cpu) / (entry.uptime - previous.uptime)


def _format_duration(seconds: float) -> str:
    minutes, remainder = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{remainder:02}"
