"""Actions: goals that take time, with feedback, results and cancelling (https://wiki.ros.org/actionlib).

::

    import pyros1
    from pyros1 import actions
    from pyros1.msgs.actionlib_tutorials.msg import FibonacciAction, FibonacciGoal

    with pyros1.Node("asker") as node, actions.Client(node, "fibonacci", FibonacciAction) as client:
        goal = client.send(FibonacciGoal(order=5))
        for feedback in goal.feedback(timeout=10):
            print(feedback.sequence)
        print(goal.result(timeout=10).sequence)

Clients and servers are compatible with those of stock actionlib, in Python and C++. `SimpleServer` is the usual server;
`AsyncClient` and `AsyncServer` are for asyncio programs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pyros1.actions.asyncio_client import AsyncClient, AsyncGoal
    from pyros1.actions.asyncio_server import AsyncServer
    from pyros1.actions.client import Client
    from pyros1.actions.client_goal import ClientGoal
    from pyros1.actions.errors import ActionError, GoalError
    from pyros1.actions.server import Server
    from pyros1.actions.server_goal import ServerGoal
    from pyros1.actions.simple_server import SimpleServer
    from pyros1.actions.states import Stage, Status

__all__ = [
    "ActionError",
    "AsyncClient",
    "AsyncGoal",
    "AsyncServer",
    "Client",
    "ClientGoal",
    "GoalError",
    "Server",
    "ServerGoal",
    "SimpleServer",
    "Stage",
    "Status",
]

_EXPORTS = {
    "ActionError": "pyros1.actions.errors",
    "AsyncClient": "pyros1.actions.asyncio_client",
    "AsyncGoal": "pyros1.actions.asyncio_client",
    "AsyncServer": "pyros1.actions.asyncio_server",
    "Client": "pyros1.actions.client",
    "ClientGoal": "pyros1.actions.client_goal",
    "GoalError": "pyros1.actions.errors",
    "Server": "pyros1.actions.server",
    "ServerGoal": "pyros1.actions.server_goal",
    "SimpleServer": "pyros1.actions.simple_server",
    "Stage": "pyros1.actions.states",
    "Status": "pyros1.actions.states",
}


def __getattr__(name: str) -> Any:
    """Load and return a public name when it is first used."""
    from pyros1.ground.lazy import load  # noqa: PLC0415 - most imports never get here

    return load(__name__, _EXPORTS, name)


def __dir__() -> list[str]:
    """Return all public names, loaded or not, for completion."""
    from pyros1.ground.lazy import public_names  # noqa: PLC0415 - most imports never get here

    return public_names(globals(), __all__)
