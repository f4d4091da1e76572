"""Reads and changes the configurations of other nodes, and reports failures."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from pyros1.cli.failures import CommandError, did_you_mean
from pyros1.cli.invocation import Invocation
from pyros1.ground.errors import ServiceError, WaitTimeoutError

if TYPE_CHECKING:
    from pyros1.node import Node

_T = TypeVar("_T")
_SERVICE = "/set_parameters"
_WAIT_NOTICE_DELAY = 1.0
"""Seconds after which the command prints what it is waiting for."""


def configurable_nodes(invocation: Invocation) -> list[str]:
    """Return the nodes that can be configured: those that provide the service ``set_parameters``."""
    services = invocation.graph.state().services
    return sorted(name.removesuffix(_SERVICE) for name in services if name.endswith(_SERVICE))


def change_with_new_node(invocation: Invocation, node_name: str, values: dict[str, Any], timeout: float | None) -> int:
    """Create a node, and use it to set another node's parameters. Return the exit code. See `set_parameters`."""
    code = 0
    with invocation.open_node() as node:
        code = set_parameters(invocation, node, node_name, values, timeout)
    return code


def set_parameters(
    invocation: Invocation, node: Node, node_name: str, values: dict[str, Any], timeout: float | None
) -> int:
    """Set parameters of a node, and report failures.

    Args:
        invocation: the command's invocation.
        node: the command's node.
        node_name: the name of the node to configure, as the user wrote it.
        values: see `ReconfigureServer.change`.
        timeout: the timeout in seconds, see `ReconfigureServer`.

    Returns:
        The exit code.
    """
    from pyros1.reconfigure.values import ParameterError  # noqa: PLC0415

    try:
        ReconfigureServer(invocation, node, node_name, timeout).change(values)
    except ParameterError as error:
        return report_failure(invocation, f"error updating parameters: {error}", error.hint)
    except WaitTimeoutError as error:
        return report_failure(invocation, f"couldn't set parameters at node {node_name}", str(error))
    return 0


def report_failure(invocation: Invocation, reason: str, hint: str = "") -> int:
    """Print why a command failed, on the stream that the stock tool uses. Return the exit code.

    Args:
        invocation: the command's invocation.
        reason: the reason.
        hint: a hint, which the stock tool does not print; it is written to stderr.
    """
    print(reason, flush=True)
    if hint:
        print(f"{invocation.program}: {hint.strip(' ()')}", file=sys.stderr)
    return failure_code(invocation)


def failure_code(invocation: Invocation) -> int:
    """Return the exit code for a failure: 1 for ``pyros1``, but 0 under the stock tool's name, as in stock ROS."""
    return 0 if invocation.as_stock else 1


class ReconfigureServer:
    """A node's dynamic_reconfigure server, through which the node is configured.

    Args:
        invocation: the command's invocation.
        node: the command's node.
        name: the name of the node to configure, as the user wrote it.
        timeout: the time to wait for each response in seconds; None or 0 to wait without limit and print a notice.

    Raises:
        WaitTimeoutError: the node does not provide its service in time.
    """

    def __init__(self, invocation: Invocation, node: Node, name: str, timeout: float | None) -> None:
        self.name = invocation.resolve(name)
        self._node = node
        self._timeout = timeout or None
        service = self.name + _SERVICE
        nodes = configurable_nodes(invocation)
        hint = "" if self.name in nodes else did_you_mean(self.name, nodes)
        self._wait_for(lambda seconds: node.wait_for_service(service, seconds), f"service {service}", hint)

    def _wait_for(self, wait_function: Callable[[float | None], _T], description: str, hint: str = "") -> _T:
        if self._timeout is not None:
            try:
                return wait_function(self._timeout)
            except WaitTimeoutError as error:
                raise WaitTimeoutError(f"{error}{hint}") from None
        try:
            return wait_function(_WAIT_NOTICE_DELAY)
        except WaitTimeoutError:
            print(f"Waiting for {description}...{hint}", file=sys.stderr, flush=True)
            return wait_function(None)

    def _receive_latched_message(self, topic: str, type_name: str, description: str) -> Any:
        """Return the latched message on a topic of the node to configure."""
        full_name = f"{self.name}/{topic}"
        return self._wait_for(lambda seconds: self._node.wait_for_message(full_name, type_name, seconds), description)

    def _receive_description(self) -> Any:
        return self._receive_latched_message(
            "parameter_descriptions", "dynamic_reconfigure/ConfigDescription", "description"
        )

    def _receive_config(self) -> Any:
        return self._receive_latched_message("parameter_updates", "dynamic_reconfigure/Config", "configuration")

    def configuration(self) -> dict[str, Any] | None:
        """Return the values of all parameters and groups; None if the node does not publish them in time."""
        from pyros1.reconfigure.encoding import decode_configuration  # noqa: PLC0415

        try:
            description = self._receive_description()
            values: dict[str, Any] = decode_configuration(self._receive_config(), description)
            return values
        except WaitTimeoutError:
            return None

    def change(self, values: dict[str, Any]) -> None:
        """Set parameters.

        Args:
            values: the new values by parameter. The value for ``groups`` is a mapping from group to state.

        Raises:
            ParameterError: a parameter does not exist or cannot have the given value.
            WaitTimeoutError: the node does not describe its parameters in time.
            CommandError: the node rejected the change.
        """
        from pyros1.msgs import load_service  # noqa: PLC0415
        from pyros1.msgs.fill import fill_message  # noqa: PLC0415
        from pyros1.reconfigure.values import encode_changes  # noqa: PLC0415

        fields = encode_changes(
            values, self._receive_description(), self._receive_config() if "groups" in values else None
        )
        service_class = load_service("dynamic_reconfigure/Reconfigure")
        message = service_class._request_class()
        fill_message(message, {"config": fields})
        try:
            self._node.service(self.name + _SERVICE, service_class).call(message, self._timeout)
        except ServiceError as error:
            raise CommandError(f"the node [{self.name}] did not change its configuration: {error}") from None
