"""Functions that an expression creates with ``lambda``."""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from typing import Any


class Lambda:
    """A function created by an expression, for arguments such as the ``key`` of ``sorted``.

    Args:
        evaluate: evaluates a syntax node with the given values of names, and counts the work.
        node: the syntax node of the ``lambda``, which has been checked.
        names: the names in the enclosing scope.
    """

    def __init__(
        self, evaluate: Callable[[ast.expr, Mapping[str, Any]], Any], node: ast.Lambda, names: Mapping[str, Any]
    ) -> None:
        self._evaluate = evaluate
        self._node = node
        self._names = names

    def __call__(self, *values: Any) -> Any:
        """Evaluate the body with the given arguments, and return its value.

        Raises:
            TypeError: the number of arguments is wrong.
        """
        arguments = [*self._node.args.posonlyargs, *self._node.args.args]
        if len(values) != len(arguments):
            raise TypeError(f"the lambda takes {len(arguments)} arguments, not {len(values)}")
        arguments_by_name = {argument.arg: value for argument, value in zip(arguments, values, strict=True)}
        return self._evaluate(self._node.body, {**self._names, **arguments_by_name})

    def __repr__(self) -> str:
        return "<lambda>"


def is_plain(arguments: ast.arguments) -> bool:
    """Return whether all arguments are plain: without defaults, ``*args``, ``**kwargs`` and keyword-only arguments."""
    return not any((arguments.vararg, arguments.kwarg, *arguments.kwonlyargs, *arguments.defaults))
