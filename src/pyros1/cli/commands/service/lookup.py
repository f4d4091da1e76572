"""``service type``, ``node``, ``uri`` and ``args``: print one property of a service (L77)."""

from __future__ import annotations

from typing import Any

from pyros1.cli.commands.service._provider import (
    load_type,
    provider_header,
    service_name,
    similar_service_hint,
    unavailable_error,
)
from pyros1.cli.failures import did_you_mean, fail
from pyros1.cli.invocation import Invocation
from pyros1.cli.records import Argument, Verb


def _print_type(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a service's type."""
    name = service_name(invocation, args)
    header = provider_header(invocation, invocation.graph, name)
    if header is None:
        fail(f"Unknown service [{name}]{similar_service_hint(invocation.graph, name)}")
    print(header.get("type", ""))


def _print_node(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the node that provides a service."""
    name = service_name(invocation, args)
    services = invocation.graph.state().services
    nodes = services.get(name)
    if not nodes:
        fail(f"Unknown service: {name}{did_you_mean(name, services)}")
    print(nodes[0])


def _print_uri(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print a service's address."""
    name = service_name(invocation, args)
    uri = invocation.graph.service_uri(name)
    if uri is None:
        fail(f"Unknown service: {name}{similar_service_hint(invocation.graph, name)}")
    print(uri)


def _print_args(invocation: Invocation, options: Any, args: list[str]) -> None:
    """Print the names of a service's arguments."""
    name = service_name(invocation, args)
    header = provider_header(invocation, invocation.graph, name)
    if header is None:
        raise unavailable_error(invocation.graph, name)
    print(" ".join(load_type(header.get("type", ""))._request_class.__slots__))


VERBS = [
    Verb(
        "type",
        "print service type",
        Argument("/service", "service"),
        examples=[("/flip", "print the type of a service")],
        run=_print_type,
    ),
    Verb(
        "node",
        "print name of node providing the service",
        Argument("/service", "service"),
        examples=[("/flip", "print the node that provides a service")],
        stock_about="",
        run=_print_node,
    ),
    Verb(
        "uri",
        "print service ROSRPC uri",
        Argument("/service", "service"),
        examples=[("/flip", "print the address of a service")],
        run=_print_uri,
    ),
    Verb(
        "args",
        "print service arguments",
        Argument("/service", "service"),
        examples=[("/flip", "print the names of a service's arguments")],
        run=_print_args,
    ),
]
