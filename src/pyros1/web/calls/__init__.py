"""Calls: single requests from a page. Each is a function in a module of this package that takes the robot and the
arguments.

A call is named ``MODULE.FUNCTION``, such as ``topics.publish``. A read-only server refuses the functions in a
module's ``CHANGES``. Those in `LONG_CALLS` may take long; they also take the page's `ServiceExchanges`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pyros1.web.server.wire import RequestError
from pyros1.web.service_exchanges import ServiceExchanges

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
"""Calls that may take as long as a service or a test."""


def run(robot: Robot, name: str, args: Mapping[str, Any], exchanges: ServiceExchanges | None = None) -> Any:
    """Run a call and return its result, as a value for JSON.

    Args:
        robot: the robot that the call concerns.
        name: name of the call.
        args: the call's arguments.
        exchanges: the service calls of the page, which end with its connection.

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
    return function(robot, args, exchanges or ServiceExchanges()) if name in LONG_CALLS else function(robot, args)
