"""Calls: single requests from a page, such as ``topics.publish``. Each call is a function in a module of this package.

The function takes the robot and the call's arguments, which its docstring lists after "Args". A module's ``CALLS``
contains its functions by the second part of the call's name. A read-only server refuses those in the module's
``CHANGES``. Calls in `LONG_CALLS` may take a long time; their functions also take the page's `ServiceCalls`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pyros1.web.server.wire import RequestError
from pyros1.web.service_calls import ServiceCalls

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_MODULES = frozenset(
    (
        "actions",
        "bags",
        "doctor",
        "forms",
        "guide",
        "launches",
        "nodes",
        "page",
        "params",
        "reconfigure",
        "scene",
        "services",
        "topics",
    )
)
LONG_CALLS = frozenset({"services.call", "guide.check"})
"""Calls that may take a long time, as they wait for a service or a test."""


def run(robot: Robot, name: str, args: Mapping[str, Any], service_calls: ServiceCalls | None = None) -> Any:
    """Run a call from a page, and return its result, which can be written as JSON.

    Args:
        robot: the robot that the call concerns.
        name: name of the call.
        args: the call's arguments.
        service_calls: the page's service calls, which are cancelled when its connection ends.

    Raises:
        RequestError: the call does not exist, is not allowed, or has invalid arguments.
        Error: the call failed.
    """
    robot.check_running()
    module_name, _, function_name = name.partition(".")
    if module_name not in _MODULES:
        raise RequestError(f"unknown call {name[:100]!r}")
    module = import_module(f"pyros1.web.calls.{module_name}")
    function: Callable[..., Any] | None = module.CALLS.get(function_name)
    if function is None:
        raise RequestError(f"unknown call {name[:100]!r}")
    if robot.access.read_only and function_name in module.CHANGES:
        raise RequestError("this server is read-only (--read-only)")
    return function(robot, args, service_calls or ServiceCalls()) if name in LONG_CALLS else function(robot, args)
