"""The base class of all views."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.web.server.wire import Push, RequestError

if TYPE_CHECKING:
    from pyros1.web.robot import Robot


class View(ABC):
    """A source of data that a page displays.

    `poll` and `change` are never called at the same time, but `wake` may be called from any thread.

    Args:
        robot: the robot.
        args: the arguments sent by the page.
        wake: to be called from any thread when there may be new data.

    Raises:
        RequestError: the arguments are invalid.
        Error: the data is not available.
    """

    period = 1 / 30
    """Minimum number of seconds between two pushes."""
    polls_periodically = False
    """Whether to call `poll` after each period, even without `wake`."""

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        self.robot = robot
        self.wake = wake

    @abstractmethod
    def poll(self) -> Push | None:
        """Return the data to push; None if nothing is new. Called in a thread.

        Raises:
            Error: the data is not available; the page displays the message, and the view continues.
        """

    def change(self, args: Mapping[str, Any]) -> None:
        """Change the arguments.

        Raises:
            RequestError: the arguments are invalid.
        """
        raise RequestError("this view cannot be changed")

    def close(self) -> None:  # noqa: B027 - most views have nothing to close
        """Close the view."""


def string_arg(args: Mapping[str, Any], name: str, default: str | None = None) -> str:
    """Return a string argument.

    Raises:
        RequestError: the argument is missing or not a string.
    """
    value = args.get(name, default)
    if not isinstance(value, str):
        raise RequestError(f"{name} must be a string")
    return value


def number_arg(args: Mapping[str, Any], name: str, minimum: float, maximum: float, default: float) -> float:
    """Return a numeric argument that is within a range.

    Raises:
        RequestError: the argument is not a number, or out of range.
    """
    value = args.get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not minimum <= value <= maximum:
        raise RequestError(f"{name} must be a number from {minimum:g} to {maximum:g}")
    return value
