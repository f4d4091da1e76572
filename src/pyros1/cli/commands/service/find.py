"""``service find``: prints the services of a type (L77)."""

from __future__ import annotations

import sys
from functools import partial
from typing import Any

from pyros1.cli.commands.service._provider import provider_header
from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.graph import PROBE_TIMEOUT
from pyros1.ground.errors import MasterError


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the services of a type. This queries the provider of every service."""
    if not args:
        raise UsageError("please specify a message type")
    if len(args) > 1:
        raise UsageError("you may only specify one message type")
    graph = invocation.graph
    from pyros1.doctor.concurrent import run_concurrently  # noqa: PLC0415 - not needed for help

    names = list(graph.state().services)
    results = run_concurrently(
        {name: partial(provider_header, invocation, graph, name) for name in names}, PROBE_TIMEOUT + 1.0
    )
    matching_services = []
    printed_reasons: set[str] = set()
    for name, result in results.items():
        if isinstance(result, dict):
            if result.get("type") == args[0]:
                matching_services.append(name)
        elif isinstance(result, MasterError):
            raise result
        elif result is not None:  # the provider did not respond
            problem, _, reason = str(result).partition("\n")  # services of the same node have the same reason
            print(
                f"WARNING: {problem}" + (f"\n{reason}" if reason and reason not in printed_reasons else ""),
                file=sys.stderr,
            )
            printed_reasons.add(reason)
    if options.json:
        print_json(matching_services)
    else:
        print(*matching_services, sep="\n")


VERB = Verb(
    "find",
    "find services by service type",
    JSON_FLAG,
    Argument("msg-type", "service_type"),
    usage="msg-type",
    examples=[("std_srvs/Trigger", "list the services of a type")],
    run=run,
)
