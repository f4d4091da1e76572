"""The rosapi services for clients: lists of nodes, topics and services, their details, and parameters.

See https://wiki.ros.org/rosapi. The services are not registered with the master: only this server's clients can call
them. `pyros1.web.rosapi_node` provides them for all nodes.

Each service is a function in a module of this package; it is called with the robot and the arguments, and returns the
response's values. A module's `SERVICES` maps each service's name to the names of its request's fields, and its
function.
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


def service_names() -> list[str]:
    """Return the names of all services, without ``/rosapi/``."""
    return [*_services()]


def is_rosapi_name(name: str) -> bool:
    """Return whether a service's full name is in rosapi's namespace; rosapi may not provide such a service."""
    return name.startswith(PREFIX)


def run(robot: Robot, name: str, args: Any) -> dict[str, Any]:
    """Handle a client's call to a rosapi service.

    Args:
        robot: the robot that the call is about.
        name: the service's full name.
        args: an object, or a list with the values of the request's fields in order.

    Returns:
        The response's values.

    Raises:
        BridgeError: the service does not exist, is not allowed, or has invalid arguments.
        Error: the request failed.
    """
    fields, handler = _services().get(name.removeprefix(PREFIX), ((), None))
    if handler is None:
        raise BridgeError(f"Service {name} does not exist")
    return handler(robot, _string_args(fields, args))


def _string_args(fields: tuple[str, ...], args: Any) -> dict[str, str]:
    """Return the arguments by name. As in rosbridge_suite, missing arguments are empty, a list may have fewer or more
    values than there are fields, and anything but a list or an object counts as no arguments.

    Raises:
        BridgeError: an argument is not a string.
    """
    if isinstance(args, list):
        args = args[0] if len(args) == 1 and isinstance(args[0], dict) else dict(zip(fields, args, strict=False))
    string_args = {name: args.get(name, "") if isinstance(args, dict) else "" for name in fields}
    if not all(isinstance(value, str) for value in string_args.values()):
        raise BridgeError(f"the arguments must be strings: {', '.join(fields)}")
    return string_args
