"""A small, safe part of Python's expressions, for the texts in which ROS 1 lets a user calculate.

`interpreter` has the language, `operators` and `functions` what may be done in it, `limits` how large its values may
get, `costs` how long what is done takes. Why no library does all this: "Own code, and why" in ``pyros1/README.md``.
"""

from __future__ import annotations

from pyros1.expressions.interpreter import Interpreter
from pyros1.expressions.limits import (
    MAX_BITS,
    MAX_ITEMS,
    MAX_TEXT,
    MAX_WORK,
    ExpressionError,
    bounded,
    require,
    size,
)

__all__ = [
    "MAX_BITS",
    "MAX_ITEMS",
    "MAX_TEXT",
    "MAX_WORK",
    "ExpressionError",
    "Interpreter",
    "bounded",
    "require",
    "size",
]
