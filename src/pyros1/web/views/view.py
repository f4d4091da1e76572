"""What all views have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.web.server.wire import Push, RequestError

if TYPE_CHECKING:
    from pyros1.web.robot import Robot


class View(ABC):
    """Something that a page shows.

    `poll` and `change` are never called at the same time, but `wake` may be called from any thread.

    Args:
        robot: where the facts come from.
        args: what to show.
        wake: to be called when there may be something new, from any thread.

    Raises:
        RequestError: the arguments are wrong.
        Error: the robot cannot give it.
    """

    period = 1 / 30
    """Least seconds between two pushes."""
    polled = False
    """Whether to ask `poll` after each period, also if nobody called `wake`."""

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        self.robot = robot
        self.wake = wake

    @abstractmethod
    def poll(self) -> Push | None:
        """Return what to show now; None if nothing is new. Called in a thread.

        Raises:
            Error: as the constructor; the page shows the text, and the view goes on.
        """

    def change(self, args: Mapping[str, Any]) -> None:
        """Show something else.

        Raises:
            RequestError: the arguments are wrong.
        """
        raise RequestError("this view cannot be changed")

    def close(self) -> None:  # noqa: B027 - most have nothing to end
        """Show nothing any more."""


def text(args: Mapping[str, Any], name: str, default: str | None = None) -> str:
    """Return an argument that is a text.

    Raises:
        RequestError: it is not given, or not a text.
    """
    value = args.get(name, default)
    if not isinstance(value, str):
        raise RequestError(f"{name} is a text")
    return value


def number(args: Mapping[str, Any], name: str, minimum: float, maximum: float, default: float) -> float:
    """Return an argument that is a number.

    Raises:
        RequestError: it is not a number, or not within the bounds.
    """
    value = args.get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not minimum <= value <= maximum:
        raise RequestError(f"{name} is a number from {minimum:g} to {maximum:g}")
    return value
