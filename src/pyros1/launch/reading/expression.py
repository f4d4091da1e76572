"""``$(eval ...)``: a small, safe part of Python's expressions (X71, https://wiki.ros.org/roslaunch/XML).

The language is that of `pyros1.expressions`, with all its functions, and those of ``math`` without a prefix.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.errors import LaunchError
from pyros1.expressions import MAX_ITEMS, ExpressionError, Interpreter, bounded
from pyros1.expressions.functions import MATH, functions

_BUILTINS: dict[str, Any] = {**functions(MAX_ITEMS), "true": True, "false": False, **MATH}


def evaluate(text: str, variables: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]) -> str:
    """Evaluate the expression of ``$(eval text)``.

    Args:
        text: the expression.
        variables: the launch arguments by name, typed.
        functions: ``arg``, ``env``, ``find``, ...; they and the builtins win over variables of the same name.

    Returns:
        The result as a string.

    Raises:
        LaunchError: a syntax error, a construct or name that is not allowed, or the evaluation failed.
    """
    if "__" in text:
        raise LaunchError("$(eval ...) may not contain double-underscore expressions")
    try:
        result = str(_Eval(text).evaluate({**variables, **_BUILTINS, **functions}))
    except (ExpressionError, RecursionError) as error:
        raise LaunchError(f"cannot evaluate $(eval {text}): {error}") from error
    if not _is_text(result):
        raise LaunchError(
            f"cannot evaluate $(eval {text}): {result!r} has a character that no file or parameter can have"
        )
    return result


class _Eval(Interpreter):
    def name(self, name: str, names: Mapping[str, Any]) -> Any:
        if name == "math":
            raise ExpressionError("'math' can only be used as in math.sqrt(x)")
        return bounded(super().name(name, names))


def _is_text(value: str) -> bool:
    """Whether files and arguments of programs can have that name; what the environment brings can be, as always."""
    try:
        return b"\0" not in value.encode("utf-8", "surrogateescape")
    except UnicodeEncodeError:
        return False
