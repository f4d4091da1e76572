"""The services of rosapi, for clients: what exists, its details, and parameters.

They are answered here, without a node or a registration. Each is a function in a file of this folder: it gets the robot
and its arguments, and returns the values of the response. `SERVICES` of a file has them by name, with the fields of the
request.
See https://wiki.ros.org/rosapi.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from pyros1.web.robot import Robot
from pyros1.web.rosbridge.operations import BridgeError

PREFIX = "/rosapi/"
Answer = Callable[[Robot, Mapping[str, str]], dict[str, Any]]
Services = dict[str, tuple[tuple[str, ...], Answer]]
_FILES = ("topics", "services", "nodes", "params", "details")


def _services() -> Services:
    found: Services = {}
    for name in _FILES:
        found.update(import_module(f"{__name__}.{name}").SERVICES)
    return found


def has(name: str) -> bool:
    """Return whether a service, by its full name, is one of rosapi."""
    return name.startswith(PREFIX)


def run(robot: Robot, name: str, args: Any) -> dict[str, Any]:
    """Answer a call.

    Args:
        robot: the robot.
        name: the service's full name.
        args: an object, or a list of values in order.

    Returns:
        The values of the response.

    Raises:
        BridgeError: the service does not exist, is not allowed, or has wrong arguments.
        Error: the robot cannot answer.
    """
    fields, answer = _services().get(name.removeprefix(PREFIX), ((), None))
    if answer is None:
        raise BridgeError(f"Service {name} does not exist")
    return answer(robot, _texts(fields, args))


def _texts(fields: tuple[str, ...], args: Any) -> dict[str, str]:
    """Return the arguments by name. As in rosbridge_suite, those that are left out are empty, a list may be shorter or
    longer, and anything but a list or an object counts as no arguments.

    Raises:
        BridgeError: one is not a string.
    """
    if isinstance(args, list):
        args = args[0] if len(args) == 1 and isinstance(args[0], dict) else dict(zip(fields, args, strict=False))
    found = {name: args.get(name, "") if isinstance(args, dict) else "" for name in fields}
    if not all(isinstance(value, str) for value in found.values()):
        raise BridgeError(f"the arguments are strings: {', '.join(fields)}")
    return found
