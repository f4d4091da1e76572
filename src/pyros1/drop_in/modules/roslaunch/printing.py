"""The print functions of roslaunch; stock has these functions in roslaunch.core."""

from __future__ import annotations

import contextlib
import sys
from collections.abc import Callable
from typing import Any

_handlers: list[Callable[[str], object]] = []
_error_handlers: list[Callable[[str], object]] = []
_child_mode: list[Any] = [False]


def add_printlog_handler(h: Callable[[str], object]) -> None:
    """Also pass each message printed with `printlog` to a function."""
    _handlers.append(h)


def add_printerrlog_handler(h: Callable[[str], object]) -> None:
    """Also pass each message printed with `printerrlog` to a function."""
    _error_handlers.append(h)


def clear_printlog_handlers() -> None:
    """Remove all functions added with `add_printlog_handler`."""
    _handlers.clear()


def clear_printerrlog_handlers() -> None:
    """Remove all functions added with `add_printerrlog_handler`."""
    _error_handlers.clear()


def _call_handlers(handlers: list[Callable[[str], object]], msg: str) -> None:
    for handler in handlers:
        with contextlib.suppress(Exception):  # a failing handler must not prevent printing
            handler(msg)


def printlog(msg: str) -> None:
    """Pass a line to the handlers, ignoring their exceptions, and print it."""
    _call_handlers(_handlers, msg)
    print(msg)


def printlog_bold(msg: str) -> None:
    """Print a line in bold; see `printlog`."""
    _call_handlers(_handlers, msg)
    print(f"\033[1m{msg}\033[0m")


def printerrlog(msg: str) -> None:
    """Print a line to stderr, in red; see `printlog`."""
    _call_handlers(_error_handlers, msg)
    print(f"\033[31m{msg}\033[0m", file=sys.stderr)


def set_child_mode(child_mode: bool) -> None:
    """Set whether this process was started by a launcher on another machine."""
    _child_mode[0] = child_mode


def is_child_mode() -> bool:
    """Return whether this process was started by a launcher on another machine."""
    return _child_mode[0]
