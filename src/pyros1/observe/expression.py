"""Expressions on messages for options such as ``--filter``, in a safe subset of Python.

The language is defined in `pyros1.ground.expressions`.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

from pyros1.ground.expressions import ExpressionError, Interpreter, UnknownNameError
from pyros1.ground.expressions.functions import MATH_NAMES, builtin_functions, extra_functions
from pyros1.ground.timing import TVal
from pyros1.msgs import Message
from pyros1.observe.expression_modules import Module

__all__ = ["FUNCTIONS", "MAX_ITEMS", "TIME_METHODS", "Expression", "ExpressionError"]

MAX_ITEMS = 1_000_000
"""Maximum number of items or characters in a value, since the string representation of a message may be long."""
FUNCTIONS: dict[str, Callable[..., Any]] = {
    **builtin_functions(MAX_ITEMS),
    **extra_functions(MAX_ITEMS),
    **{name: MATH_NAMES[name] for name in ("sqrt", "sin", "cos", "atan2", "hypot", "isnan", "isinf")},
}
"""Functions that every expression can call, in addition to hasattr, getattr and type."""
TIME_METHODS = frozenset({"secs", "nsecs", "to_sec", "to_nsec", "to_time", "is_zero"})
"""Members of times and durations that expressions can use."""
_CLASS_ATTRIBUTES = frozenset({"_type", "_md5sum", "_full_text", "_slot_types", "_has_header", "__slots__", "__name__"})
"""Attributes with the type information of a message class."""
_MESSAGE_ATTRIBUTES = _CLASS_ATTRIBUTES - {"__name__"} | {"_connection_header"}
_REFLECTION_FUNCTIONS = frozenset({"getattr", "hasattr", "type"})


class Expression:
    """An expression on messages, which is checked when the object is created.

    Args:
        text: the expression, such as ``m.data > 3 and any('x' in name for name in m.names)``.
        extra_names: additional functions and modules that the expression can use, by name.

    Raises:
        ExpressionError: the expression is malformed or uses something that is not allowed.
    """

    def __init__(self, text: str, extra_names: Mapping[str, Any] = MappingProxyType({})) -> None:
        self.text = text
        try:
            self._language = _FilterLanguage(text, extra_names)
        except ExpressionError as error:
            raise ExpressionError(f"[{text}]: {error}") from None

    def __call__(self, names: Mapping[str, Any]) -> Any:
        """Evaluate the expression.

        Args:
            names: the values of the names in the expression.

        Raises:
            ExpressionError: the evaluation failed, for example because a field does not exist or types do not match.
        """
        try:
            return self._language.evaluate(names)
        except ExpressionError as error:
            raise type(error)(f"[{self.text}]: {error}") from None


class MessageLanguage(Interpreter):
    """The common part of expressions on messages in this module and in topic_tools. See `Interpreter`."""

    max_items = MAX_ITEMS
    private_attributes = _CLASS_ATTRIBUTES | _MESSAGE_ATTRIBUTES

    def name(self, name: str, names: Mapping[str, Any]) -> Any:
        """Return the value of a name. See `Interpreter`."""
        if name in names:
            return names[name]
        if name in _REFLECTION_FUNCTIONS:
            return {"hasattr": self._hasattr, "getattr": self._getattr, "type": _type_of}[name]
        if name in FUNCTIONS:
            return FUNCTIONS[name]
        raise UnknownNameError(f"unknown name {name!r}; known names: {self.known_names(names)}")

    def known_names(self, names: Mapping[str, Any]) -> str:
        """Return the names that can be used, separated by commas, for error messages."""
        return ", ".join(sorted(names))

    def attribute(self, owner: Any, name: str) -> Any:
        """Return a field of a message or an allowed member of times, strings and other values. See `Interpreter`."""
        if isinstance(owner, Message):
            is_allowed = name in owner.__slots__ or name.isupper() or name in _MESSAGE_ATTRIBUTES
        elif isinstance(owner, type):
            is_class_attribute = issubclass(owner, Message) and (name.isupper() or name in _CLASS_ATTRIBUTES)
            is_allowed = is_class_attribute or name == "__name__"
        elif isinstance(owner, Module):
            return owner.get(name)
        elif isinstance(owner, _TypeName):
            is_allowed = name == "__name__"
        else:
            is_allowed = isinstance(owner, TVal) and name in TIME_METHODS
        if is_allowed:
            return getattr(owner, name)
        return super().attribute(owner, name)

    def _hasattr(self, owner: Any, name: str) -> bool:
        """Implement hasattr() for the attributes that expressions can access."""
        missing_marker = object()
        return self._getattr(owner, name, missing_marker) is not missing_marker

    def _getattr(self, owner: Any, name: str, *default: Any) -> Any:
        """Implement getattr() for the attributes that expressions can access."""
        is_hidden = isinstance(name, str) and name.startswith("_") and name not in self.private_attributes
        if not isinstance(name, str) or is_hidden or len(default) > 1:
            raise ExpressionError(f"{name!r} is not accessible")
        try:
            return self.attribute(owner, name)
        except (ExpressionError, AttributeError):
            if default:
                return default[0]
            raise


class _TypeName:
    """The result of type() for values whose classes expressions must not call."""

    def __init__(self, name: str) -> None:
        self.__name__ = name

    def __repr__(self) -> str:
        return f"<class {self.__name__!r}>"


def _type_of(value: Any) -> Any:
    """Implement type()."""
    value_type = type(value)
    return (
        value_type if isinstance(value, Message) or value_type in FUNCTIONS.values() else _TypeName(value_type.__name__)
    )


class _FilterLanguage(MessageLanguage):
    def __init__(self, text: str, extra_names: Mapping[str, Any]) -> None:
        self._extra_names = extra_names
        super().__init__(text)

    def check(self, node: ast.AST) -> None:
        super().check(node)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not self._is_function(node.func.id):
            functions = [name for name, value in self._extra_names.items() if not isinstance(value, Module)]
            known = ", ".join(sorted({*FUNCTIONS, *_REFLECTION_FUNCTIONS, *functions}))
            raise ExpressionError(f"unknown function {node.func.id}; known functions: {known}")

    def name(self, name: str, names: Mapping[str, Any]) -> Any:
        if name not in names and name in self._extra_names:
            return self._extra_names[name]
        return math.pi if name == "pi" and name not in names else super().name(name, names)

    def _is_function(self, name: str) -> bool:
        return is_function(name) or name in self._extra_names


def is_function(name: str) -> bool:
    """Return whether every expression can call a function of this name."""
    return name in FUNCTIONS or name in _REFLECTION_FUNCTIONS
