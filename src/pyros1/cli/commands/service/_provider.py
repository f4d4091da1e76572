"""Shared code of the verbs of ``service``: the service given as argument, and queries to the node that provides it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.graph import Graph, probe_service
from pyros1.ground.errors import DefinitionError, ServiceUnavailableError, UnknownTypeError

if TYPE_CHECKING:
    from pyros1.msgs import Service

ERROR_CODE = 2
"""The exit code for errors, which is 1 for most other tools."""


def service_name(invocation: Invocation, args: list[str]) -> str:
    """Return the full name of the service given as the single argument.

    Raises:
        UsageError: there is no argument or more than one.
    """
    if not args:
        raise UsageError("service must be specified")
    if len(args) > 1:
        raise UsageError("you may only specify one input service")
    return invocation.resolve(args[0])


def similar_service_hint(graph: Graph, name: str) -> str:
    """Return a hint with the name of a similar service; empty if there is none."""
    return did_you_mean(name, graph.state().services)


def provider_header(invocation: Invocation, graph: Graph, name: str) -> dict[str, str] | None:
    """Return the connection header of the service's provider; None if no node provides the service.

    Raises:
        CommandError: the provider does not respond.
    """
    uri = graph.service_uri(name)
    if uri is None:
        return None
    try:
        return probe_service(name, uri, invocation.caller_id)
    except ServiceUnavailableError as error:
        message = f"Unable to communicate with service [{name}], address [{uri}]"
        if isinstance(error.__cause__, TimeoutError):
            providers = ", ".join(graph.state().services.get(name, ["its node"]))
            message += f"\n{providers} accepts connections but did not answer within 5 s: is it suspended or hanging?"
        raise CommandError(message, ERROR_CODE) from None


def unavailable_error(graph: Graph, name: str) -> CommandError:
    """Return the error for a service that no node provides."""
    return CommandError(f"Service [{name}] is not available.{similar_service_hint(graph, name)}", ERROR_CODE)


def load_type(type_name: str) -> type[Service]:
    """Return the Python class for a service type.

    Raises:
        CommandError: the type is unknown or has no valid definition.
    """
    from pyros1.msgs import load_service  # noqa: PLC0415 - not all verbs need it

    try:
        return load_service(type_name)
    except (UnknownTypeError, DefinitionError) as error:
        raise CommandError(f"Unable to load type [{type_name}]: {error}", ERROR_CODE) from None
