"""``node list`` (L70)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.graph import in_namespace


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the nodes that the master knows."""
    if len(args) > 1:
        raise UsageError("invalid args: you may only specify one namespace")
    namespace = invocation.resolve(args[0]) if args else None
    graph = invocation.graph
    names = sorted(in_namespace(graph.state().nodes(), namespace))
    if options.json:
        print_json([{"node": name, "uri": graph.node_uri(name)} for name in names])
        return
    if options.all:
        names = [f"{graph.node_uri(name) or 'unknown address'} \t{name}" for name in names]
    elif options.uris:
        names = [graph.node_uri(name) or f"unknown address {name}" for name in names]
    print(*names, sep="\n")


VERB = Verb(
    "list",
    "list active nodes",
    Flag("-u", dest="uris", help="list XML-RPC URIs"),
    Flag("-a", "--all", help="list all information"),
    Flag("--json", help="print a JSON list of objects: node, uri", own=True),
    Argument("/namespace", "namespace", optional=True),
    usage="",
    examples=[("", "all nodes"), ("-a", "with their addresses")],
    run=run,
)
