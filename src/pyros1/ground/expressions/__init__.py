"""A small, safe subset of Python's expressions, for places where ROS 1 lets users compute values.

`interpreter` implements the language, `operators` and `functions` its operations, `limits` the maximum sizes of values,
and `costs` estimates of the time of operations. For the reasons not to use a library, see "Own code, and why" in
``pyros1/README.md``.
"""

from __future__ import annotations

from pyros1.ground.expressions.interpreter import Interpreter
from pyros1.ground.expressions.limits import (
    MAX_BITS,
    MAX_ITEMS,
    MAX_TEXT,
    MAX_WORK,
    ExpressionError,
    LimitError,
    UnknownNameError,
    check_limit,
    check_value,
    size,
)

__all__ = [
    "MAX_BITS",
    "MAX_ITEMS",
    "MAX_TEXT",
    "MAX_WORK",
    "ExpressionError",
    "Interpreter",
    "LimitError",
    "UnknownNameError",
    "check_limit",
    "check_value",
    "size",
]
