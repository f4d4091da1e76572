"""A client that reads and changes the parameters of another node."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import NodeShutdownError, WaitTimeoutError
from pyros1.msgs.dynamic_reconfigure.msg import Config as ConfigMessage
from pyros1.msgs.dynamic_reconfigure.msg import ConfigDescription
from pyros1.msgs.dynamic_reconfigure.srv import Reconfigure
from pyros1.msgs.fill import fill_message
from pyros1.net.signal_safe import POLL_INTERVAL, Condition
from pyros1.reconfigure.config import Config
from pyros1.reconfigure.encoding import Make, decode, decode_description, parameters_of, with_groups
from pyros1.reconfigure.values import encode_changes

if TYPE_CHECKING:
    from pyros1.node import Node


class Client:
    """Accesses the parameters of another node; see https://wiki.ros.org/dynamic_reconfigure.

    Args:
        node: this node.
        name: the other node's name, or the namespace of its parameters.
        timeout: the time in seconds to wait for the other node; None for no limit.
        on_config: called with each new configuration.
        on_description: called with the list of parameters; see `description`.
        make: called like ``dict`` to create the dictionaries of configurations and descriptions.
        remap: whether to remap ``name``, in addition to its topics and service.

    Raises:
        WaitTimeoutError: the other node does not respond in time.
        NodeShutdownError: this node is shutting down.
    """

    def __init__(
        self,
        node: Node,
        name: str,
        timeout: float | None = None,
        on_config: Callable[[Any], object] | None = None,
        on_description: Callable[[Any], object] | None = None,
        make: Make = Config,
        remap: bool = True,
    ) -> None:
        self.name = node.resolve(name, remap=remap)
        self.on_config, self.on_description = on_config, on_description
        self._node, self._make = node, make
        self._condition = Condition()
        self._config: Any = None
        self._description: Any = None  # the dynamic_reconfigure/ConfigDescription
        # A configuration gets its groups from the description, and the two topics arrive in either order.
        self._lock = threading.Lock()
        self._config_is_pending = False  # whether on_config waits for the description
        self._group_tree: Any = None
        node.wait_for_service(f"{self.name}/set_parameters", timeout)
        self._service = node.service(f"{self.name}/set_parameters", Reconfigure)
        self._subscribers: list[Any] = [
            node.subscribe(f"{self.name}/parameter_descriptions", ConfigDescription, self._on_description_message),
            node.subscribe(f"{self.name}/parameter_updates", ConfigMessage, self._on_update_message),
        ]

    def config(self, timeout: float | None = None) -> Any:
        """Return the configuration last published by the other node: a `Config`, with its groups.

        Args:
            timeout: the time in seconds to wait for the first configuration, and for the description that names the
                parameters of each group; None for no limit.

        Raises:
            WaitTimeoutError: no configuration or no description arrived in time.
            NodeShutdownError: this node is shutting down.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        self._wait_for(lambda: self._config is not None, "the configuration", deadline)
        self._wait_for(lambda: self._description is not None, "the description of the parameters", deadline)
        return self._decode_config(self._config)

    def groups(self, timeout: float | None = None) -> Any:
        """Return the tree of groups, whose ``parameters`` are lists of dictionaries. See `config` for the errors."""
        deadline = None if timeout is None else time.monotonic() + timeout
        self._wait_for(lambda: self._description is not None, "the description of the parameters", deadline)
        return self._group_tree

    def description(self, timeout: float | None = None) -> list[dict[str, Any]]:
        """Return all parameters as dictionaries (see `pyros1.reconfigure.encoding`). See `config` for the errors."""
        tree = self.groups(timeout)
        return parameters_of(tree) if tree is not None else []

    def update(self, changes: Mapping[str, Any], timeout: float | None = None) -> Any:
        """Change parameters. Return the other node's new configuration.

        Args:
            changes: values by parameter. A value can also be a string or the name of a choice. The key ``groups``
                contains states by group.
            timeout: the time in seconds to wait for the description, and again for the response; None for no limit.

        Raises:
            ParameterError: a parameter does not exist, or cannot have the value.
            ServiceError: the other node refuses the change, or is no longer running.
            WaitTimeoutError, NodeShutdownError: see `config`.
        """
        self.groups(timeout)
        states = self._config if self._config is not None else ConfigMessage()
        message = Reconfigure._request_class()
        fill_message(message, {"config": encode_changes(changes, self._description, states)})
        return self._decode_config(self._service.call(message, timeout).config)

    def close(self) -> None:
        """Stop receiving configurations and descriptions."""
        for subscriber in self._subscribers:
            subscriber.unregister()

    def _decode_config(self, message: Any) -> Any:
        values = decode(message, self._make)
        names_by_group_id = {
            group.id: [parameter.name for parameter in group.parameters] for group in self._description.groups
        }
        return with_groups(values, message.groups, names_by_group_id, self._make)

    def _on_description_message(self, message: Any) -> None:
        with self._lock:
            self._group_tree = decode_description(message, self._make)
            self._description = message
            config_was_pending, self._config_is_pending = self._config_is_pending, False
        self._condition.notify_all()
        if self.on_description is not None:
            self.on_description(self.description())
        if config_was_pending:
            self._call_on_config(self._config)

    def _on_update_message(self, message: Any) -> None:
        with self._lock:
            self._config = message
            self._config_is_pending = self._description is None
            is_complete = not self._config_is_pending
        self._condition.notify_all()
        if is_complete:
            self._call_on_config(message)

    def _call_on_config(self, message: Any) -> None:
        if self.on_config is not None:
            self.on_config(self._decode_config(message))

    def _wait_for(self, has_arrived: Callable[[], bool], description: str, deadline: float | None) -> None:
        remaining = POLL_INTERVAL if deadline is None else deadline - time.monotonic()
        while not self._condition.wait_for(has_arrived, min(remaining, POLL_INTERVAL)):
            if not self._node.ok():
                raise NodeShutdownError(f"{self._node.name} is shutting down")
            if deadline is not None and (remaining := deadline - time.monotonic()) <= 0:
                raise WaitTimeoutError(f"timeout exceeded while waiting for {description} of {self.name}")
