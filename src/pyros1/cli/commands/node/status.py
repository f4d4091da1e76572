"""``node status``: the processes of running launches."""

from __future__ import annotations

import sys
import time
from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Flag, Verb
from pyros1.launch.running.control import Status, running_launches
from pyros1.shown import one_line

_SAMPLE = 0.5


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a table of all processes of all launches."""
    if args:
        raise UsageError("too many arguments")
    before = [] if options.once else _all(invocation)
    if before:
        time.sleep(_SAMPLE)
    now = _all(invocation)
    if not now:
        print("No launch is running", file=sys.stderr)
    else:
        print(*map(one_line, table(now, before)), sep="\n")


VERB = Verb(
    "status",
    "list the processes of running launches: pid, CPU, memory, restarts, uptime",
    Flag("-1", "--once", help="do not measure the CPU, which takes half a second"),
    examples=[("", "processes of all running launches"), ("-1", "at once, without their CPU")],
    stock="",
    run=run,
)


def _all(invocation: Invocation) -> list[Status]:
    found = []
    for launch, entries in running_launches(invocation.master):
        launch.close()
        found += entries
    return found


def table(now: list[Status], before: list[Status]) -> list[str]:
    """Return the lines of the status table.

    Args:
        now: processes.
        before: the same some time ago; what they have used meanwhile is their CPU.
    """
    former = {(entry.label, entry.pid): entry for entry in before}
    rows = [("NODE", "STATE", "PID", "CPU", "MEMORY", "RESTARTS", "UPTIME", "MACHINE")]
    for entry in now:
        machine = entry.machine or "-"
        state = entry.state if entry.state != "died" else f"died ({entry.exit_code})"
        cpu = _cpu(entry, former.get((entry.label, entry.pid)))
        memory = f"{entry.memory / 2**20:.1f} MB" if entry.memory >= 0 else "-"
        uptime = _duration(entry.uptime) if entry.uptime >= 0 else "-"
        pid = str(entry.pid) if entry.uptime >= 0 or entry.state == "running" else "-"
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


def _cpu(entry: Status, before: Status | None) -> str:
    if before is None or min(entry.cpu, before.cpu) < 0 or entry.uptime <= before.uptime:
        return "-"
    return f"{100 * (entry.cpu - before.cpu) / (entry.uptime - before.uptime):.1f} %"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(int(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02}:{rest:02}"
