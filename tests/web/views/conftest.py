"""Views on a robot of the test."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.web.robot import Robot
from pyros1.web.views import view_class
from pyros1.web.views.view import View

PATIENCE = 20.0


class Watched:
    """A view, and what it shows."""

    def __init__(self, robot: Robot, name: str, args: dict[str, Any]) -> None:
        self._woken = threading.Event()
        self.view: View = view_class(name)(robot, args, self._woken.set)

    def until(self, fits: Callable[[Any], bool]) -> Any:
        """Return what the view pushes as soon as that fits."""
        deadline = time.monotonic() + PATIENCE
        seen = None
        while time.monotonic() < deadline:
            self._woken.clear()
            push = self.view.poll()
            if push is not None:
                seen = push.data
                if fits(seen):
                    return seen
            self._woken.wait(0.02 if self.view.polls_periodically else deadline - time.monotonic())
        raise AssertionError(f"not seen; the last was {seen!r:.2000}")


@pytest.fixture
def watch(robot: Robot) -> Iterator[Callable[..., Watched]]:
    """Return a function that opens a view by its name, with its arguments."""
    opened: list[Watched] = []

    def open_view(name: str, of: Robot = robot, **args: Any) -> Watched:
        opened.append(Watched(of, name, args))
        return opened[-1]

    yield open_view
    for watched in opened:
        watched.view.close()
