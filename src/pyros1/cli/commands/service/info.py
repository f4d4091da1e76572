"""``service info``: prints the node, address, type and arguments of a service (L76)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.service._provider import load_type, provider_header, similar_service_hint
from pyros1.cli.failures import CommandError, UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Verb
from pyros1.cli.shared.printing import print_json


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a service's node, address, type and arguments."""
    if not args:
        raise UsageError("you must specify a service name")
    if len(args) > 1:
        raise UsageError("you may only specify one service")
    name = invocation.resolve(args[0])
    graph = invocation.graph
    nodes = graph.state().services.get(name)
    if not nodes:
        raise CommandError(f"unknown service{similar_service_hint(graph, name)}", 1)
    if not options.json:  # print what is known before the query, in case the provider does not respond
        print(f"Node: {nodes[0]}")
        print(f"URI: {graph.service_uri(name)}")
    type_name = (provider_header(invocation, graph, name) or {}).get("type", "")
    if options.json:
        arguments = list(load_type(type_name)._request_class.__slots__)
        print_json(
            {"service": name, "node": nodes[0], "uri": graph.service_uri(name), "type": type_name, "args": arguments}
        )
        return
    print(f"Type: {type_name}")
    print(f"Args: {' '.join(load_type(type_name)._request_class.__slots__)}")


VERB = Verb(
    "info",
    "print information about service",
    JSON_FLAG,
    Argument("/service", "service"),
    usage="/service",
    examples=[("/flip", "print a service's node, address, type and arguments")],
    run=run,
)
