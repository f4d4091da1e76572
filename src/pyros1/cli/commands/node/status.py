"""``node status``: the processes of running launches."""

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

_SAMPLE = 0.5


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a table, or JSON, of all processes of all launches."""
    if args:
        raise UsageError("too many arguments")
    earlier = [] if options.once else _all(invocation)
    if earlier:
        time.sleep(_SAMPLE)
    now = _all(invocation)
    if options.json:
        print_json(json_form(now, earlier))
    elif not now:
        print("No launch is running", file=sys.stderr)
    else:
        print(*map(one_line, table(now, earlier)), sep="\n")


VERB = Verb(
    "status",
    "list the processes of running launches: pid, CPU, memory, restarts, uptime",
    Flag("-1", "--once", help="do not measure CPU usage, which takes half a second"),
    Flag("--json", help="print a JSON list of objects, one for each process", own=True),
    examples=[("", "processes of all running launches"), ("-1", "without CPU usage, which saves half a second")],
    stock="",
    run=run,
)


def _all(invocation: Invocation) -> list[Status]:
    found = []
    for launch, entries in running_launches(invocation.master):
        launch.close()
        found += entries
    return found


def table(now: list[Status], earlier: list[Status]) -> list[str]:
    """Return the lines of the status table.

    Args:
        now: the processes.
        earlier: the same at an earlier time; CPU usage is what was used since then.
    """
    earlier_entries = {(entry.label, entry.pid): entry for entry in earlier}
    rows = [("NODE", "STATE", "PID", "CPU", "MEMORY", "RESTARTS", "UPTIME", "MACHINE")]
    for entry in now:
        machine = entry.machine or "-"
        state = entry.state if entry.state != "died" else f"died ({entry.exit_code})"
        percent = _cpu(entry, earlier_entries.get((entry.label, entry.pid)))
        cpu = f"{percent:.1f} %" if percent is not None else "-"
        memory = f"{entry.memory / 2**20:.1f} MB" if entry.memory >= 0 else "-"
        uptime = _duration(entry.uptime) if entry.uptime >= 0 else "-"
        pid = str(entry.pid) if _has_process(entry) else "-"
        rows.append((entry.node, state, pid, cpu, memory, str(max(0, entry.starts - 1)), uptime, machine))
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    right = {2, 3, 4, 5, 6}
    return [
        "  ".join(
            text.rjust(width) if column in right else text.ljust(width)
            for column, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]


def json_form(now: list[Status], earlier: list[Status]) -> list[dict[str, Any]]:
    """Return the processes for JSON: cpu in percent, memory in bytes, uptime in seconds; None for what is unknown.

    Args:
        now: the processes.
        earlier: the same at an earlier time; CPU usage is what was used since then.
    """
    earlier_entries = {(entry.label, entry.pid): entry for entry in earlier}
    return [
        {
            "node": entry.node,
            "state": entry.state,
            "exit_code": entry.exit_code,
            "pid": entry.pid if _has_process(entry) else None,
            "cpu": _cpu(entry, earlier_entries.get((entry.label, entry.pid))),
            "memory": entry.memory if entry.memory >= 0 else None,
            "restarts": max(0, entry.starts - 1),
            "uptime": entry.uptime if entry.uptime >= 0 else None,
            "machine": entry.machine,
        }
        for entry in now
    ]


def _has_process(entry: Status) -> bool:
    return entry.uptime >= 0 or entry.state == "running"


def _cpu(entry: Status, earlier: Status | None) -> float | None:
    """Return the CPU usage in percent, None if unknown."""
    if earlier is None or min(entry.cpu, earlier.cpu) < 0 or entry.uptime <= earlier.uptime:
        return None
    return 100 * (entry.cpu - earlier.cpu) / (entry.uptime - earlier.uptime)


def _duration(seconds: float) -> str:
    minutes, remainder = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{remainder:02}"
