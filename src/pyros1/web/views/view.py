"""Base class of all views, and functions that check their arguments."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.web.server.wire import Push, RequestError

if TYPE_CHECKING:
    from pyros1.web.robot import Robot


class View(ABC):
    """Base class of views, which provide the data for a part of a page.

    `poll` and `change` are never called at the same time, but `wake` may be called from any thread.

    Args:
        robot: the robot that the page shows.
        args: the arguments sent by the page.
        wake: may be called from any thread; the view calls it when there may be new data.

    Raises:
        RequestError: the arguments are invalid.
        Error: the data is not available.
    """

    period = 1 / 30
    """Minimum number of seconds between two pushes."""
    polls_periodically = False
    """Whether `poll` is called after each period even if `wake` was not called."""

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        self.robot = robot
        self.wake = wake

    @abstractmethod
    def poll(self) -> Push | None:
        """Return the data to push; None if nothing is new. Called in a thread.

        Raises:
            Error: the data is not available. The page displays the error message, and `poll` will be called again.
        """

    def change(self, args: Mapping[str, Any]) -> None:
        """Apply changed arguments from the page.

        Raises:
            RequestError: the arguments are invalid.
        """
        raise RequestError("this view cannot be changed")

    def close(self) -> None:  # noqa: B027 - most views have nothing to close
        """Release what the view uses, such as subscriptions. Called once, when the page closes the view."""


def string_arg(args: Mapping[str, Any], name: str, default: str | None = None) -> str:
    """Return an argument that must be a string.

    Raises:
        RequestError: the argument is missing and has no default, or is not a string.
    """
    value = args.get(name, default)
    if not isinstance(value, str):
        raise RequestError(f"{name} must be a string")
    return value


def number_arg(args: Mapping[str, Any], name: str, minimum: float, maximum: float, default: float) -> float:
    """Return an argument that must be a number within a range.

    Raises:
        RequestError: the argument is not a number, or out of range.
    """
    value = args.get(name, default)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not minimum <= value <= maximum:
        raise RequestError(f"{name} must be a number from {minimum:g} to {maximum:g}")
    return value
