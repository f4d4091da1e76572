"""Calls: what a page asks for once. Each is a function in a file of this folder: takes the robot and the arguments.

A function is found by its name, ``FILE.FUNCTION``: ``topics.publish``. Those in a file's ``CHANGES`` are refused by a
server that is read-only. Those in `LONG` may take long: they get the page's `ServiceExchanges`, too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Any

from pyros1.web.server.wire import RequestError
from pyros1.web.service_exchanges import ServiceExchanges

if TYPE_CHECKING:
    from pyros1.web.robot import Robot

_FILES = frozenset(
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
LONG = frozenset({"services.call", "guide.check"})
"""Calls that may take as long as a service, or a test."""


def run(robot: Robot, name: str, args: Mapping[str, Any], exchanges: ServiceExchanges | None = None) -> Any:
    """Run a call and return its result, for JSON.

    Args:
        robot: what the call is about.
        name: of the call.
        args: its arguments.
        exchanges: with which calls of services end.

    Raises:
        RequestError: there is no such call, it is not allowed, or its arguments are wrong.
        Error: it failed.
    """
    robot.check_running()
    file, _, word = name.partition(".")
    if file not in _FILES:
        raise RequestError(f"there is no call {name[:100]!r}")
    module = import_module(f"pyros1.web.calls.{file}")
    function: Callable[..., Any] | None = module.CALLS.get(word)
    if function is None:
        raise RequestError(f"there is no call {name[:100]!r}")
    if robot.access.read_only and word in module.CHANGES:
        raise RequestError("this server is read-only (--read-only)")
    return function(robot, args, exchanges or ServiceExchanges()) if name in LONG else function(robot, args)
