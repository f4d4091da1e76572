"""``service node`` (L77)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.service._provider import one_service
from pyros1.cli.failures import did_you_mean, fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the node that provides a service."""
    name = one_service(invocation, args)
    services = invocation.graph.state().services
    nodes = services.get(name)
    if not nodes:
        fail(f"Unknown service: {name}{did_you_mean(name, services)}")
    print(nodes[0])


VERB = Verb(
    "node",
    "print name of node providing the service",
    Argument("/service", "service"),
    examples=[("/flip", "the node that provides it")],
    stock_about="",
    run=run,
)
