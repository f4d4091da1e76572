"""Calls: single requests of a page. Each is a function in a file of this folder; it gets the robot and the arguments.

A function is found by its name, ``FILE.FUNCTION``: ``topics.publish``. Those in a file's ``CHANGES`` are refused by a
read-only server. Those in `LONG` may take long; they also get the page's `ServiceExchanges`.
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
"""Calls that may take as long as a service or a test."""


def run(robot: Robot, name: str, args: Mapping[str, Any], exchanges: ServiceExchanges | None = None) -> Any:
    """Run a call and return its result, for JSON.

    Args:
        robot: what the call is about.
        name: name of the call.
        args: its arguments.
        exchanges: the service calls of the page, which end with its connection.

    Raises:
        RequestError: the call does not exist, is not allowed, or has wrong arguments.
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
