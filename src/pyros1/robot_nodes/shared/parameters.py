"""Reads a node's private parameters, and checks their types.

If a parameter has the wrong type, roscpp nodes silently use the default. These nodes also use it, but log an error.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import partial
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, TypeGuard, TypeVar

from pyros1.ground.terminal_text import one_line

if TYPE_CHECKING:
    from pyros1.node import Node

_Default = TypeVar("_Default")
_EXPONENT = re.compile(r"[-+]?[0-9.]{1,40}[eE][-+]?[0-9]{1,5}")


class PrivateParameters:
    """A node's private parameters at the time when it started.

    An invalid value is reported, and treated as not set.

    Args:
        values: the parameters, by name without ``~``.
        report: called with a one-line message about each invalid value.
        namespace: the node's name, for the reports.
    """

    def __init__(self, values: Mapping[str, Any], report: Callable[[str], object], namespace: str = "") -> None:
        self._values = values
        self._report = report
        self._namespace = namespace

    @classmethod
    def of(cls, node: Node) -> PrivateParameters:
        """Fetch a node's private parameters; invalid values will be logged as errors."""
        values = node.params.get("~", {})
        return cls(values if isinstance(values, Mapping) else {}, partial(node.log.error, "%s"), node.name)

    def value(self, name: str) -> Any:
        """Return a parameter's value, or None if it is not set.

        Args:
            name: the name, without ``~``. It may have several parts: ``axis_linear/x``.
        """
        value: Any = self._values
        for part in name.split("/"):
            if not isinstance(value, Mapping) or part not in value:
                return None
            value = value[part]
        return value

    def number(self, name: str, default: float, minimum: float = -inf, maximum: float = inf) -> float:
        """Return a finite number from `minimum` to `maximum`. As in roscpp, integers count as numbers."""
        value = self.value(name)
        if value is None:
            return default
        if is_number(value) and minimum <= value <= maximum:
            return float(value)
        return self.report_invalid(name, value, f"a number{_describe_range(minimum, maximum)}", default)

    def integer(self, name: str, default: int, minimum: float = -inf, maximum: float = inf) -> int:
        """Return an integer from `minimum` to `maximum`. As in roscpp, other numbers are rounded."""
        value = self.value(name)
        if value is None:
            return default
        if is_number(value) and minimum <= round(value) <= maximum:
            return round(value)
        return self.report_invalid(name, value, f"an integer{_describe_range(minimum, maximum)}", default)

    def flag(self, name: str, default: bool) -> bool:
        """Return a bool. As in roscpp, numbers do not count as bools."""
        value = self.value(name)
        if value is None or isinstance(value, bool):
            return default if value is None else value
        return self.report_invalid(name, value, "true or false", default)

    def text(self, name: str, default: str) -> str:
        """Return a string."""
        value = self.value(name)
        if value is None or isinstance(value, str):
            return default if value is None else value
        return self.report_invalid(name, value, "a string", default)

    def report_invalid(self, name: str, value: object, expected: str, default: _Default) -> _Default:
        """Report a parameter's invalid value, and return the default."""
        value_text = one_line(repr(value), 100)
        if isinstance(value, str) and _EXPONENT.fullmatch(value):
            value_text += ", which is text in YAML; write 1.0e-5 for 1e-5"
        self._report(f"the parameter {self._namespace}/{name} must be {expected}, not {value_text}: using {default!r}")
        return default


def is_number(value: object) -> TypeGuard[int | float]:
    """Return whether a parameter's value is a finite number; a bool is not."""
    if isinstance(value, int):
        return not isinstance(value, bool) and abs(value) < 2**63
    return isinstance(value, float) and isfinite(value)


def _describe_range(minimum: float, maximum: float) -> str:
    if minimum == -inf:
        return "" if maximum == inf else f" up to {maximum:g}"
    return f" from {minimum:g} to {maximum:g}" if maximum < inf else f" of at least {minimum:g}"
