"""``pyros1 node status``, ``stop``, ``start`` and ``restart``: the nodes of running launches."""

from __future__ import annotations

import sys
import time

from pyros1.cli.common import CommandError, Invocation
from pyros1.launch.control import Launch, Status, running_launches
from pyros1.shown import one_line

_SAMPLE = 0.5
_POLL = 0.05
_DEADLINE = 30.0


def status(invocation: Invocation) -> None:
    """``node status``: a table of all processes of all launches."""
    parser = invocation.parser("status [options]")
    parser.add_option("-1", "--once", action="store_true", help="do not measure the CPU, which takes half a second")
    options, args = parser.parse_args(invocation.args)
    if args:
        parser.error("too many arguments")
    before = [] if options.once else _all(invocation)
    if before:
        time.sleep(_SAMPLE)
    now = _all(invocation)
    if not now:
        print("No launch is running", file=sys.stderr)
    else:
        print(*map(one_line, table(now, before)), sep="\n")


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


def stop(invocation: Invocation) -> None:
    """``node stop NODE...``: end nodes of launches; they stay so, whatever ``respawn`` says."""
    _control(invocation, "stop", "stopped")


def start(invocation: Invocation) -> None:
    """``node start NODE...``: start nodes of launches that were stopped or have ended."""
    _control(invocation, "start", "started")


def restart(invocation: Invocation) -> None:
    """``node restart NODE...``: end nodes of launches, and start them again."""
    _control(invocation, "restart", "restarted")


def _control(invocation: Invocation, verb: str, done: str) -> None:
    parser = invocation.parser(f"{verb} node1 [node2...]")
    args = parser.parse_args(invocation.args)[1]
    if not args:
        parser.error("You must specify at least one node name")
    names = [invocation.resolve(arg) for arg in args]
    launches = running_launches(invocation.master)
    try:
        told = [(launch, entry) for launch, entries in launches for entry in entries if entry.node in names]
        for launch, entry in told:
            launch.tell(verb, entry.node)
        for launch, before in told:
            after = _wait(launch, before, verb)
            pid = f" with pid [{after.pid}]" if after.state == "running" else ""
            print(f"{before.node} {done}{pid}", flush=True)
    finally:
        for launch, _ in launches:
            launch.close()
    unknown = set(names) - {entry.node for _, entry in told}
    if unknown:
        raise CommandError("no launch has " + ", ".join(sorted(unknown)))


def _wait(launch: Launch, before: Status, verb: str) -> Status:
    """Wait until the launch has done what it was told."""
    deadline = time.monotonic() + _DEADLINE
    while time.monotonic() < deadline:
        after = next((entry for entry in launch.status() if entry.label == before.label), before)
        if verb == "stop" and after.state not in ("running", "stopping"):
            return after
        if verb == "start" and after.state == "running":
            return after
        if verb == "restart" and after.starts > before.starts:
            return after
        time.sleep(_POLL)
    raise CommandError(f"{before.node}: the launch was told to {verb} it, but that is not done after {_DEADLINE:g} s")
