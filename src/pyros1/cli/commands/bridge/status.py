"""``bridge status``: prints what the bridges of this master exchange with other sites."""

from __future__ import annotations

import sys
import threading
from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.terminal_text import one_line

_CLEAR_SCREEN = "\033[H\033[J"


def run(invocation: Invocation, options: Any, args: list[str]) -> int | None:
    """Print the status of each bridge, once or until interrupted."""
    if args:
        raise UsageError("too many arguments")
    if not options.watch:
        return _show(invocation, options.json, "")
    while True:
        try:
            _show(invocation, options.json, _CLEAR_SCREEN if sys.stdout.isatty() else "")
        except CommandError as error:
            print(f"ERROR: {error}", file=sys.stderr)
        sys.stdout.flush()
        pause(1.0)


def pause(seconds: float) -> None:
    """Wait before the next update."""
    threading.Event().wait(seconds)


def _show(invocation: Invocation, as_json: bool, before: str) -> int:
    """Print ``before``, then the status of each bridge; return the exit code."""
    from pyros1.bridge.status import status_lines  # noqa: PLC0415
    from pyros1.doctor.bridge_status import fetch_statuses  # noqa: PLC0415

    found = fetch_statuses(invocation.graph, invocation.graph.state())
    if not found:
        raise CommandError(
            "no bridge is running on this master; start one with: pyros1 bridge --site NAME ..., or pyros1 bridge ros2"
        )
    code = 0
    statuses = []
    for name, status in found.items():
        if isinstance(status, Exception):
            print(f"ERROR: {one_line(name)} did not return its status: {one_line(status)}", file=sys.stderr)
            code = 1
        else:
            statuses.append(status)
    if as_json:
        print_json(statuses)
        return code
    print(before, end="")
    for status in statuses:
        try:
            lines = [*status_lines(status)]
        except (KeyError, TypeError, AttributeError, ValueError):
            print(
                "ERROR: a bridge has sent a status that this version cannot read; update pyros1 at both ends",
                file=sys.stderr,
            )
            code = 1
            continue
        print(*lines, sep="\n")
    return code


VERB = Verb(
    "status",
    "sites, topics, rates, dropped messages with reasons, round trip",
    JSON_FLAG,
    Flag("--watch", help="update it each second, until Ctrl-C"),
    examples=[("", "show the bridges of this master"), ("--watch", "show what changes")],
    stock="",
    run=run,
)
