"""Log levels, and calls of the two services that get and set the levels of a node's loggers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.graph import NODE_TIMEOUT
from pyros1.ground.errors import ServiceError, ServiceUnavailableError, WaitTimeoutError
from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.node import Node

LEVELS = ("debug", "info", "warn", "error", "fatal")
"""Names of the levels. The number of a level is 1 shifted left by its index in this tuple."""


def get_loggers(invocation: Invocation, node: Node, node_name: str) -> dict[str, str]:
    """Return the levels of a node's loggers, by the logger's name."""
    response = call_logger_service(invocation, node, node_name, "get_loggers", {})
    return {logger.name: logger.level for logger in response.loggers}


def unknown_logger_error(invocation: Invocation, node_name: str, logger: str, loggers: dict[str, str]) -> CommandError:
    """Return the error to raise if a node has no logger of a given name."""
    message = f"node {node_name} does not contain logger {one_line(logger)}{did_you_mean(logger, loggers)}"
    return CommandError(f"{invocation.program}: error: {message}", 2, plain=True)


def call_logger_service(
    invocation: Invocation, node: Node, node_name: str, service_name: str, request: dict[str, str]
) -> Any:
    """Call one of a node's two logging services.

    Args:
        invocation: the command's invocation.
        node: the command's node.
        node_name: the name of the node to call.
        service_name: ``get_loggers`` or ``set_logger_level``.
        request: the fields of the request.

    Returns:
        The response.

    Raises:
        CommandError: the node does not exist, does not respond in time, or refuses the request.
    """
    service = f"{node_name}/{service_name}"
    service_type = "roscpp/GetLoggers" if service_name == "get_loggers" else "roscpp/SetLoggerLevel"
    try:
        client = node.service(service, service_type)
        return client.call(client.type._request_class(**request), NODE_TIMEOUT)
    except WaitTimeoutError:
        message = f"node '{node_name}' did not answer within {NODE_TIMEOUT:g} s"
    except ServiceUnavailableError:
        hint = did_you_mean(node_name, invocation.graph.state().nodes())
        message = (
            f"node '{node_name}' doesn't exist or doesn't support query: Service [{service}] is not available.{hint}"
        )
    except ServiceError as error:
        message = f"node '{node_name}' logger request failed: {error}"
    raise CommandError(f"{invocation.program}: error: {message}", 1, plain=True)
