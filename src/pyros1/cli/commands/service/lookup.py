"""``service type``, ``node``, ``uri`` and ``args``: one fact of a service (L77)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.service._provider import header, hint, load, not_available, one_service
from pyros1.cli.failures import did_you_mean, fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb


def _type(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a service's type."""
    name = one_service(invocation, args)
    found = header(invocation, invocation.graph, name)
    if found is None:
        fail(f"Unknown service [{name}]{hint(invocation.graph, name)}")
    print(found.get("type", ""))


def _node(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the node that provides a service."""
    name = one_service(invocation, args)
    services = invocation.graph.state().services
    nodes = services.get(name)
    if not nodes:
        fail(f"Unknown service: {name}{did_you_mean(name, services)}")
    print(nodes[0])


def _uri(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a service's address."""
    name = one_service(invocation, args)
    found = invocation.graph.service_uri(name)
    if found is None:
        fail(f"Unknown service: {name}{hint(invocation.graph, name)}")
    print(found)


def _args(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the names of a service's arguments."""
    name = one_service(invocation, args)
    found = header(invocation, invocation.graph, name)
    if found is None:
        raise not_available(invocation.graph, name)
    print(" ".join(load(found.get("type", ""))._request_class.__slots__))


VERBS = [
    Verb("type", "print service type", Argument("/service", "service"), examples=[("/flip", "its type")], run=_type),
    Verb(
        "node",
        "print name of node providing the service",
        Argument("/service", "service"),
        examples=[("/flip", "the node that provides it")],
        stock_about="",
        run=_node,
    ),
    Verb(
        "uri",
        "print service ROSRPC uri",
        Argument("/service", "service"),
        examples=[("/flip", "its address")],
        run=_uri,
    ),
    Verb(
        "args",
        "print service arguments",
        Argument("/service", "service"),
        examples=[("/flip", "the names of its arguments")],
        run=_args,
    ),
]
