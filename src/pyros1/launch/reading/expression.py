"""Evaluates ``$(eval ...)``: a small, safe subset of Python's expressions (X71, https://wiki.ros.org/roslaunch/XML).

`pyros1.ground.expressions` defines the language; its functions and those of ``math`` need no prefix.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground.errors import LaunchError
from pyros1.ground.expressions import MAX_ITEMS, ExpressionError, Interpreter, check_value
from pyros1.ground.expressions.functions import MATH_NAMES, builtin_functions

_BUILTINS: dict[str, Any] = builtin_functions(MAX_ITEMS)
_CONSTANTS: dict[str, Any] = {"true": True, "false": False, **MATH_NAMES}


def evaluate(text: str, variables: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]) -> str:
    """Evaluate the expression of ``$(eval text)``.

    Args:
        text: the expression to evaluate.
        variables: the launch arguments by name, as typed values. As in stock ROS, they take precedence over Python's
            builtins: ``map`` is an argument of that name, if there is one.
        functions: ``arg``, ``env``, ``find`` and so on; they take precedence over variables, as do the members of
            ``math``.

    Returns:
        The result as a string.

    Raises:
        LaunchError: the expression has a syntax error or contains something that is not allowed, or the evaluation
            failed.
    """
    if "__" in text:
        raise LaunchError("$(eval ...) may not contain double-underscore expressions")
    try:
        result = str(_Eval(text).evaluate({**_BUILTINS, **variables, **_CONSTANTS, **functions}))
    except (ExpressionError, RecursionError) as error:
        raise LaunchError(f"cannot evaluate $(eval {text}): {error}") from error
    if not _is_valid_argument(result):
        raise LaunchError(
            f"cannot evaluate $(eval {text}): {result!r} has a character that is not allowed in files and parameters"
        )
    return result


class _Eval(Interpreter):
    def name(self, name: str, names: Mapping[str, Any]) -> Any:
        if name == "math":
            raise ExpressionError("'math' can only be used as in math.sqrt(x)")
        return check_value(super().name(name, names))


def _is_valid_argument(value: str) -> bool:
    """Return whether a string can be passed to a process or name a file: it has no NUL, and UTF-8 can encode it."""
    try:
        return b"\0" not in value.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        return False
