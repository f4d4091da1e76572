"""What roslaunch prints; stock has these functions in roslaunch.core."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable
from typing import Any

_printers: list[Callable[[str], object]] = [print]
_error_printers: list[Callable[[str], object]] = [lambda text: print(text, file=sys.stderr)]
_child = [False]


def add_printlog_handler(h: Callable[[str], object]) -> None:
    """Call a function with each text of `printlog`."""
    _printers.append(h)


def add_printerrlog_handler(h: Callable[[str], object]) -> None:
    """Call a function with each text of `printerrlog`."""
    _error_printers.append(h)


def clear_printlog_handlers() -> None:
    """Call nothing with the texts of `printlog`."""
    _printers.clear()


def clear_printerrlog_handlers() -> None:
    """Call nothing with the texts of `printerrlog`."""
    _error_printers.clear()


def printlog(msg: str) -> None:
    """Print a line."""
    for printer in _printers:
        printer(msg)


def printlog_bold(msg: str) -> None:
    """Print a line in bold."""
    printlog(f"\033[1m{msg}\033[0m" if sys.stdout.isatty() else msg)


def printerrlog(msg: str) -> None:
    """Print a line to stderr, in red."""
    for printer in _error_printers:
        printer(f"\033[31m{msg}\033[0m")


def set_child_mode(child_mode: bool) -> None:
    """Set whether this process was started by a launcher elsewhere."""
    _child[0] = child_mode


def is_child_mode() -> bool:
    """Return whether this process was started by a launcher elsewhere."""
    return _child[0]


def rle_wrapper(fn: Callable[..., Any]) -> Callable[..., Any]:
    """Make a function print errors of its body, and return None then."""

    @functools.wraps(fn)
    def call(*args: Any, **kwargs: Any) -> Any:
        try:
            return fn(*args, **kwargs)
        except Exception as error:  # noqa: BLE001 - that is what it is for
            printerrlog(str(error))
            return None

    return call
