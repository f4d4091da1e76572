"""Lets other nodes change parameters of this node while it is running."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import Error, SettingError
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.dynamic_reconfigure.msg import Config as ConfigMessage
from pyros1.msgs.dynamic_reconfigure.msg import ConfigDescription
from pyros1.msgs.dynamic_reconfigure.srv import Reconfigure
from pyros1.reconfigure.config import Config
from pyros1.reconfigure.encoding import (
    Make,
    decode,
    encode,
    encode_description,
    groups_of,
    initial_config,
    parameters_of,
)
from pyros1.reconfigure.values import FIELD_NAMES, TYPE_CONVERTERS

if TYPE_CHECKING:
    from pyros1.node import Node


class CallbackError(Error):
    """A callback did not return a configuration."""


class Server:
    """Lets tools and other nodes change parameters; see https://wiki.ros.org/dynamic_reconfigure.

    Initial values come from the parameter server if set there, otherwise from the defaults. Changes are also written to
    the parameter server.

    Args:
        node: the node that offers the parameters.
        description: a `Parameters` object, or a module generated from a ``.cfg`` file.
        callback: called initially and for each change as ``callback(config, level)``, with the new values in a
            `Config` and the level bits of all changed parameters (initially -1, which has all bits set). The callback
            returns the configuration, which it may modify. ``groups`` contains the tree of groups with their states.
        namespace: the namespace of the parameters, topics and service. It is below the node's private namespace unless
            it begins with ``/``.
        make: called like ``dict`` to create the configuration's dictionaries.
        remap: whether to remap the namespace, in addition to its topics, service and parameters.

    Attributes:
        config: the current configuration.
        namespace: the namespace of the parameters, topics and service, with a trailing ``/``.
        message: the description as a message.
        descriptions, updates: the publishers of the description and of new configurations.
        service: the service for changes.

    Raises:
        CallbackError: the callback did not return a configuration.
        NodeError: the node already has a server in this namespace.
        SettingError: a value on the parameter server does not fit its parameter's type.
    """

    def __init__(
        self,
        node: Node,
        description: Any,
        callback: Callable[[Any, int], Any],
        namespace: str = "",
        make: Make = Config,
        remap: bool = True,
    ) -> None:
        full_namespace = namespace if namespace.startswith(("~", "/")) else f"~{namespace}"
        if remap:
            full_namespace = node.resolve(full_namespace)
        self.namespace = full_namespace if full_namespace.endswith(("~", "/")) else f"{full_namespace}/"
        self.description = description
        self.callback = callback
        self._node = node
        self._types = {
            parameter["name"]: parameter["type"] for parameter in parameters_of(description.config_description)
        }
        self._lock = threading.RLock()  # reentrant, since a callback may request a change
        self._written_values: dict[str, Any] = {}
        values = make({name: self._initial_value(name, default) for name, default in self._defaults()})
        self.config = initial_config(self._clamp(values), description.config_description, make)
        self.message = encode_description(
            description.config_description, description.max, description.min, dict(description.defaults)
        )
        self.descriptions = node.advertise(f"{self.namespace}parameter_descriptions", ConfigDescription, latch=True)
        self.updates = node.advertise(f"{self.namespace}parameter_updates", ConfigMessage, latch=True)
        self.descriptions.publish(self.message)
        self.service: Any = None
        try:
            with self._lock:
                self._apply(self.config, -1)
            self.service = node.advertise_service(f"{self.namespace}set_parameters", Reconfigure, self._on_request)
        except BaseException:
            self.close()
            raise

    def _initial_value(self, name: str, default: Any) -> Any:
        """Return a parameter's value on the parameter server, or its default if it is not set.

        Raises:
            SettingError: the value does not fit the parameter's type.
        """
        value, type_name = self._node.params.get(self.namespace + name, default), self._types[name]
        try:
            TYPE_CONVERTERS[type_name](value)
        except (ValueError, TypeError, OverflowError) as error:
            full_name = self._node.resolve(self.namespace + name)
            text = f"the parameter {full_name} must be a value of type {type_name}, not {one_line(repr(value), 100)}"
            raise SettingError(text) from error
        return value

    def _defaults(self) -> list[tuple[str, Any]]:
        """Return all parameters with their defaults, in the order of the fields of a configuration message."""
        type_order = list(FIELD_NAMES)
        return sorted(self.description.defaults.items(), key=lambda item: type_order.index(self._types[item[0]]))

    def update(self, changes: Mapping[str, Any]) -> Any:
        """Change parameters from within the node. Return the new configuration.

        Args:
            changes: values by parameter, which are clamped to the limits.

        Raises:
            CallbackError: the callback did not return a configuration; nothing is changed.
            ValueError, TypeError: a value does not fit its parameter's type.
        """
        with self._lock:
            config = self.config.copy()
            config.update({name: changes[name] for name in changes if name in self._types or name == "groups"})
            for name in changes.keys() - config.keys():
                self._node.log.warn("reconfigure: there is no parameter %s", name, throttle=60)
            self._clamp(config)
            level = 0
            for name, bits in self.description.level.items():
                if config[name] != self.config[name]:
                    level |= bits
            return self._apply(config, level)

    def _clamp(self, config: Any) -> Any:
        """Convert all values to their parameters' types, clamp numbers to the limits, and return the configuration."""
        for name, type_name in self._types.items():
            value, minimum, maximum = (
                TYPE_CONVERTERS[type_name](config[name]),
                self.description.min[name],
                self.description.max[name],
            )
            if type_name in ("int", "double"):
                value = minimum if value < minimum else maximum if value > maximum else value
            config[name] = value
        return config

    def _apply(self, config: Any, level: int) -> Any:
        """Call the callback; store, publish and return the configuration that the callback returns."""
        config = self.callback(config, level)
        if config is None:
            text = "Reconfigure callback should return a possibly updated configuration."
            self._node.log.error(text)
            raise CallbackError(text)
        for name in self._types:
            if self._written_values.get(name, self) != config[name]:
                self._node.params[self.namespace + name] = self._written_values[name] = config[name]
        self.config = config
        self.updates.publish(encode(config, self._types))
        return config

    def _on_request(self, request: Any) -> Any:
        """Change parameters for a service call; return the new configuration as a message."""
        with self._lock:
            changes = decode(request.config, dict)
            states = {group.id: group.state for group in request.config.groups}
            config: Any = None
            if states and "groups" in self.config:
                previous_states = {group["id"]: group["state"] for group in groups_of(self.config["groups"])}
                self._set_states(states)
                try:
                    config = self.update(changes)
                except BaseException:
                    self._set_states(previous_states)
                    raise
            else:
                config = self.update(changes)
            return encode(config, self._types)

    def _set_states(self, states: Mapping[int, bool]) -> None:
        for group in groups_of(self.config["groups"]):
            group["state"] = states.get(group["id"], group["state"])

    def close(self) -> None:
        """Stop offering the parameters."""
        if self.service is not None:
            self.service.shutdown()
        self.updates.unregister()
        self.descriptions.unregister()
