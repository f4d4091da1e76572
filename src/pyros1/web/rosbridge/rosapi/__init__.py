"""The services of rosapi for clients: lists of nodes, topics and services, their details, and parameters.

They run here, without a node or a registration. Each is a function in a module of this package, called with the robot
and the arguments, and returns the values of the response. `SERVICES` of a module lists them by name, with the names
of the fields of the request. See https://wiki.ros.org/rosapi.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from pyros1.web.robot import Robot
from pyros1.web.rosbridge.operations import BridgeError

PREFIX = "/rosapi/"
Handler = Callable[[Robot, Mapping[str, str]], dict[str, Any]]
Services = dict[str, tuple[tuple[str, ...], Handler]]
_MODULES = ("topics", "services", "nodes", "params", "details")


def _services() -> Services:
    services: Services = {}
    for name in _MODULES:
        services.update(import_module(f"{__name__}.{name}").SERVICES)
    return services


def provides(name: str) -> bool:
    """Return whether a service's full name is that of a rosapi service."""
    return name.startswith(PREFIX)


def run(robot: Robot, name: str, args: Any) -> dict[str, Any]:
    """Handle a call to a service.

    Args:
        robot: the robot.
        name: the service's full name.
        args: an object, or a list of values in order.

    Returns:
        The values of the response.

    Raises:
        BridgeError: the service does not exist, is not allowed, or has invalid arguments.
        Error: the request failed.
    """
    fields, handler = _services().get(name.removeprefix(PREFIX), ((), None))
    if handler is None:
        raise BridgeError(f"Service {name} does not exist")
    return handler(robot, _string_args(fields, args))


def _string_args(fields: tuple[str, ...], args: Any) -> dict[str, str]:
    """Return the arguments by name. As in rosbridge_suite, missing arguments are empty, a list may be shorter or
    longer, and anything but a list or an object counts as no arguments.

    Raises:
        BridgeError: an argument is not a string.
    """
    if isinstance(args, list):
        args = args[0] if len(args) == 1 and isinstance(args[0], dict) else dict(zip(fields, args, strict=False))
    string_args = {name: args.get(name, "") if isinstance(args, dict) else "" for name in fields}
    if not all(isinstance(value, str) for value in string_args.values()):
        raise BridgeError(f"the arguments must be strings: {', '.join(fields)}")
    return string_args
