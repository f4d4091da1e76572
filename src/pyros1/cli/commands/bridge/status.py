"""``bridge status``: prints what the bridges of this master exchange with other sites."""

from __future__ import annotations

import json
import sys
from typing import Any

from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.ground.errors import Error
from pyros1.ground.terminal_text import one_line

_MAX_STATUS = 8 << 20
TIMEOUT = 5.0
"""Seconds for the answers of all bridges."""


def run(invocation: Invocation, options: Any, args: list[str]) -> int | None:
    """Print the status of each bridge."""
    if args:
        raise UsageError("too many arguments")
    from pyros1.bridge.local_graph import STATUS_SERVICE, find_bridges  # noqa: PLC0415
    from pyros1.bridge.status import status_lines  # noqa: PLC0415
    from pyros1.doctor.concurrent import run_concurrently  # noqa: PLC0415

    names = sorted(find_bridges(invocation.graph.state()))
    if not names:
        raise CommandError("no bridge is running on this master; start one with: pyros1 bridge --site NAME ...")
    code = 0
    statuses = []
    with invocation.open_node() as node:
        clients = {name: node.service(f"{name}/{STATUS_SERVICE}", "std_srvs/Trigger") for name in names}
        for name, response in run_concurrently(clients, TIMEOUT).items():
            try:
                if isinstance(response, Exception):
                    raise response
                statuses.append(_parse_status(response.message))
            except (Error, ValueError) as error:
                print(f"ERROR: {one_line(name)} did not return its status: {one_line(error)}", file=sys.stderr)
                code = 1
    if options.json:
        print_json(statuses)
        return code
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


def _parse_status(text: str) -> Any:
    if len(text) > _MAX_STATUS:
        raise ValueError("it is too long")
    try:
        return json.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


VERB = Verb(
    "status",
    "sites, what flows between them, what is dropped and why, round trip",
    JSON_FLAG,
    examples=[("", "show the bridges of this master")],
    stock="",
    run=run,
)
