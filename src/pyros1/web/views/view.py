"""The base of all views."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

from pyros1.web.server.wire import Push, RequestError

if TYPE_CHECKING:
    from pyros1.web.robot import Robot


class View(ABC):
    """Something that a page displays.

    `poll` and `change` are never called at the same time, but `wake` may be called from any thread.

    Args:
        robot: the source of the data.
        args: what to display.
        wake: to be called, from any thread, when there may be something new.

    Raises:
        RequestError: the arguments are wrong.
        Error: the robot cannot provide it.
    """

    period = 1 / 30
    """Minimum seconds between two pushes."""
    polled = False
    """Whether to call `poll` after each period, even without `wake`."""

    def __init__(self, robot: Robot, args: Mapping[str, Any], wake: Callable[[], object]) -> None:
        self.robot = robot
        self.wake = wake

    @abstractmethod
    def poll(self) -> Push | None:
        """Return what to push; None if nothing is new. Called in a thread.

        Raises:
            Error: as in the constructor; the page displays the text, and the view continues.
        """

    def change(self, args: Mapping[str, Any]) -> None:
        """Change the arguments.

        Raises:
            RequestError: the arguments are wrong.
        """
        raise RequestError("this view cannot be changed")

    def close(self) -> None:  # noqa: B027 - most have nothing to close
        """Close the view."""


def text(args: Mapping[str, Any], name: str, default: str | None = None) -> str:
    """Return an argument that is a text.

    Raises:
        RequestError: it is missing, or not a text.
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
