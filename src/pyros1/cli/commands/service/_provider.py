"""Shared code of the verbs about one service: its name, and the answer of its provider."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pyros1.cli.failures import CommandError, UsageError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.graph import Graph, probe_service
from pyros1.ground.errors import DefinitionError, ServiceUnavailableError, UnknownTypeError

if TYPE_CHECKING:
    from pyros1.msgs import Service

ERROR = 2
"""Exit code of errors. It differs from most tools'."""


def one_service(invocation: Invocation, args: list[str]) -> str:
    """Return the full name of the service that the arguments name."""
    if not args:
        raise UsageError("service must be specified")
    if len(args) > 1:
        raise UsageError("you may only specify one input service")
    return invocation.resolve(args[0])


def hint(graph: Graph, name: str) -> str:
    """Return a hint at the service that was probably meant."""
    return did_you_mean(name, graph.state().services)


def header(invocation: Invocation, graph: Graph, name: str) -> dict[str, str] | None:
    """Return the connection header of the service's provider, None if no node provides the service."""
    uri = graph.service_uri(name)
    if uri is None:
        return None
    try:
        return probe_service(name, uri, invocation.caller_id)
    except ServiceUnavailableError as error:
        text = f"Unable to communicate with service [{name}], address [{uri}]"
        if isinstance(error.__cause__, TimeoutError):
            who = ", ".join(graph.state().services.get(name, ["its node"]))
            text += f"\n{who} accepts connections but did not answer within 5 s: is it suspended or hanging?"
        raise CommandError(text, ERROR) from None


def not_available(graph: Graph, name: str) -> CommandError:
    """Return the error for a service that no node provides."""
    return CommandError(f"Service [{name}] is not available.{hint(graph, name)}", ERROR)


def load(type_name: str) -> type[Service]:
    """Return the class of a service's type."""
    from pyros1.msgs import load_service  # noqa: PLC0415 - not all verbs need it

    try:
        return load_service(type_name)
    except (UnknownTypeError, DefinitionError) as error:
        raise CommandError(f"Unable to load type [{type_name}]: {error}", ERROR) from None
