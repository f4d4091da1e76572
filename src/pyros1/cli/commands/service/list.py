"""``service list``: prints the registered services (L76)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.failures import UsageError
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import JSON_FLAG, Argument, Flag, Verb
from pyros1.cli.shared.printing import print_json
from pyros1.graph import names_in_namespace


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the registered services."""
    if len(args) > 1:
        raise UsageError("you may only specify one input namespace")
    namespace = invocation.resolve(args[0]) if args else None
    services = invocation.graph.state().services
    names = sorted(names_in_namespace(services, namespace))
    if options.json:
        print_json([{"service": name, "nodes": services[name]} for name in names])
        return
    for name in names:
        print(f"{name} {','.join(map(str, services[name]))}" if options.nodes else name)


VERB = Verb(
    "list",
    "list active services",
    Flag("-n", "--nodes", help="print nodes that provide service(s)"),
    JSON_FLAG,
    Argument("/namespace", "namespace", optional=True),
    usage="[/namespace]",
    examples=[("", "list all services"), ("-n", "list all services with the nodes that provide them")],
    run=run,
)
