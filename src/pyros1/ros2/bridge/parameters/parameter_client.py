"""Reads and sets the parameters of ROS 2 nodes. Each method waits for the node.

Each response is checked: its size must be within limits, and it must match the request.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from pyros1.ground.errors import Error, ServiceRefusal
from pyros1.ros2.bridge.parameters.messages import (
    DESCRIBE,
    GET,
    LIST,
    SET,
    Descriptor,
    ParameterMessages,
    Value,
)
from pyros1.ros2.bridge.parameters.nodes import ParameterNode
from pyros1.ros2.zenoh.names import DataKey

CALL_TIME = 4.0
"""Seconds to wait for a node's response."""
MAX_PARAMETERS = 1000
"""Maximum number of parameters of a node."""
_Answer = TypeVar("_Answer")


class ParameterClient:
    """Calls the parameter services of nodes.

    Args:
        call: calls a ROS 2 service, given its key, the encoded request and a number of seconds.
        call_time: seconds to wait for a node's response.

    All methods raise ServiceRefusal, which names the node, if it does not respond in time or its response is invalid.
    """

    def __init__(self, call: Callable[[DataKey, bytes, float], bytes], call_time: float = CALL_TIME) -> None:
        self.messages = ParameterMessages()
        self._call = call
        self._call_time = call_time

    def names(self, node: ParameterNode) -> list[str]:
        """Return the names of a node's parameters."""
        names = self._ask(node, LIST, self.messages.list_request(), self.messages.names)
        if len(names) > MAX_PARAMETERS:
            raise ServiceRefusal(
                f"node {node.name} of ROS 2 has {len(names)} parameters; at most {MAX_PARAMETERS} can be used"
            )
        return names

    def values(self, node: ParameterNode, names: Sequence[str]) -> dict[str, Value]:
        """Return the values of the parameters that have one."""
        request = self.messages.names_request(GET, names)
        values = self._ask(node, GET, request, self.messages.values) if names else []
        self._check_number(node, names, values)
        return {name: value for name, value in zip(names, values, strict=True) if value is not None}

    def descriptors(self, node: ParameterNode, names: Sequence[str]) -> list[Descriptor]:
        """Return the node's descriptors of its parameters, in the order of the names."""
        request = self.messages.names_request(DESCRIBE, names)
        descriptors = self._ask(node, DESCRIBE, request, self.messages.descriptors) if names else []
        self._check_number(node, names, descriptors)
        return [each._replace(name=name) for name, each in zip(names, descriptors, strict=True)]

    def set(self, node: ParameterNode, values: Mapping[str, bool | int | float | str]) -> dict[str, str]:
        """Set parameters; return why the node refused some of them, by name."""
        results = self._ask(node, SET, self.messages.set_parameters_request(values), self.messages.results)
        self._check_number(node, [*values], results)
        return {name: reason for name, reason in zip(values, results, strict=True) if reason is not None}

    def _ask(self, node: ParameterNode, service: str, request: bytes, decode: Callable[[bytes], _Answer]) -> _Answer:
        try:
            return decode(self._call(node.key(service), request, self._call_time))
        except Error as error:
            text = str(error.args[0]) if isinstance(error, ServiceRefusal) else str(error)
            raise ServiceRefusal(f"node {node.name} of ROS 2, {service}: {text}") from None

    def _check_number(self, node: ParameterNode, names: Sequence[str], answers: Sequence[object]) -> None:
        if len(answers) != len(names):
            raise ServiceRefusal(
                f"node {node.name} of ROS 2 responded about {len(answers)} parameters, not {len(names)}; some may "
                "have gone in the meantime"
            )
