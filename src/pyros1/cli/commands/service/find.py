"""``service find`` (L77)."""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

from pyros1.cli.commands.service._provider import header
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON, Argument, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.graph import PROBE_TIMEOUT
from pyros1.ground.errors import MasterError


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the services of a type. This asks the provider of every service."""
    if not args:
        raise UsageError("please specify a message type")
    if len(args) > 1:
        raise UsageError("you may only specify one message type")
    graph = invocation.graph
    from pyros1.doctor.concurrent import run_concurrently  # noqa: PLC0415 - not needed for help

    names = list(graph.state().services)
    answers = run_concurrently({name: partial(header, invocation, graph, name) for name in names}, PROBE_TIMEOUT + 1.0)
    matching = []
    printed: set[str] = set()
    for name, answer in answers.items():
        if isinstance(answer, dict):
            if answer.get("type") == args[0]:
                matching.append(name)
        elif isinstance(answer, MasterError):
            raise answer
        elif answer is not None:  # it did not answer the query for its type
            what, _, why = str(answer).partition("\n")  # print a reason only once for all services of a node
            print(f"WARNING: {what}" + (f"\n{why}" if why and why not in printed else ""), file=sys.stderr)
            printed.add(why)
    if options.json:
        print_json(matching)
    else:
        print(*matching, sep="\n")


VERB = Verb(
    "find",
    "find services by service type",
    JSON,
    Argument("msg-type", "service_type"),
    usage="msg-type",
    examples=[("std_srvs/Trigger", "services of that type")],
    run=run,
)
