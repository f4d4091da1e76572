"""``service type`` (L77)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.service._provider import header, hint, one_service
from pyros1.cli.failures import fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb


def run(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a service's type."""
    name = one_service(invocation, args)
    found = header(invocation, invocation.graph, name)
    if found is None:
        fail(f"Unknown service [{name}]{hint(invocation.graph, name)}")
    print(found.get("type", ""))


VERB = Verb("type", "print service type", Argument("/service", "service"), examples=[("/flip", "its type")], run=run)
