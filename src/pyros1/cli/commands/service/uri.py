"""``service uri`` (L77)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.service._provider import hint, one_service
from pyros1.cli.failures import fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a service's address."""
    name = one_service(invocation, args)
    found = invocation.graph.service_uri(name)
    if found is None:
        fail(f"Unknown service: {name}{hint(invocation.graph, name)}")
    print(found)


VERB = Verb(
    "uri", "print service ROSRPC uri", Argument("/service", "service"), examples=[("/flip", "its address")], run=run
)
