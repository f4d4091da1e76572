"""``service args`` (L77)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.service._provider import header, load, not_available, one_service
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the names of a service's arguments."""
    name = one_service(invocation, args)
    found = header(invocation, invocation.graph, name)
    if found is None:
        raise not_available(invocation.graph, name)
    print(" ".join(load(found.get("type", ""))._request_class.__slots__))


VERB = Verb(
    "args",
    "print service arguments",
    Argument("/service", "service"),
    examples=[("/flip", "the names of its arguments")],
    run=run,
)
