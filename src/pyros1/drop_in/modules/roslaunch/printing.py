"""What roslaunch prints; stock has these functions in roslaunch.core."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable
from typing import Any

_handlers: list[Callable[[str], object]] = []
_error_handlers: list[Callable[[str], object]] = []
_child: list[Any] = [False]


def add_printlog_handler(h: Callable[[str], object]) -> None:
    """Call a function with each text of `printlog`, too."""
    _handlers.append(h)


def add_printerrlog_handler(h: Callable[[str], object]) -> None:
    """Call a function with each text of `printerrlog`, too."""
    _error_handlers.append(h)


def clear_printlog_handlers() -> None:
    """Call no function with the texts of `printlog` any more."""
    _handlers.clear()


def clear_printerrlog_handlers() -> None:
    """Call no function with the texts of `printerrlog` any more."""
    _error_handlers.clear()


def _tell(handlers: list[Callable[[str], object]], msg: str) -> None:
    for handler in handlers:
        with contextlib.suppress(Exception):  # what is printed matters more
            handler(msg)


def printlog(msg: str) -> None:
    """Print a line, after the handlers got it, whose errors do not count."""
    _tell(_handlers, msg)
    print(msg)


def printlog_bold(msg: str) -> None:
    """Print a line in bold; see `printlog`."""
    _tell(_handlers, msg)
    print(f"\033[1m{msg}\033[0m")


def printerrlog(msg: str) -> None:
    """Print a line to stderr, in red; see `printlog`."""
    _tell(_error_handlers, msg)
    print(f"\033[31m{msg}\033[0m", file=sys.stderr)


def set_child_mode(child_mode: bool) -> None:
    """Set whether this process was started by a launcher elsewhere."""
    _child[0] = child_mode


def is_child_mode() -> bool:
    """Return whether this process was started by a launcher elsewhere."""
    return _child[0]
