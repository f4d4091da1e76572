"""The expressions of transform and relay_field, which can use the language of filters and a few modules.

In expressions, a module is a set of allowed members, and nothing else can be accessed. A name from a user never causes
the import of a Python module outside of ``pyros1.msgs``.
"""

from __future__ import annotations

import ast
import random
import time
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any

from pyros1.cli.commands.topic_tools._arrays import ARRAY_MEMBERS, CheckedFunction, array_member, numpy_module
from pyros1.cli.commands.topic_tools._estimates import product_cost, squared_size
from pyros1.cli.commands.topic_tools._sizes import (
    check_array,
    has_array,
    is_numpy,
    require_broadcast,
    require_index,
    string_cost,
)
from pyros1.ground.errors import Error, UnknownTypeError
from pyros1.ground.expressions import ExpressionError
from pyros1.ground.expressions.functions import MATH_NAMES, function_name, method_owner
from pyros1.ground.expressions.lambdas import Lambda
from pyros1.ground.timing import Time
from pyros1.msgs import load_message
from pyros1.observe.expression import FUNCTIONS, MessageLanguage
from pyros1.observe.expression_modules import Module, time_module

_RANDOM_NAMES = ("choice", "gauss", "normalvariate", "randint", "random", "uniform")


class _MessageModule(Module):
    def __init__(self, package: str) -> None:
        super().__init__(package, {})

    def get(self, name: str) -> Any:
        try:
            return self if name == "msg" else load_message(f"{self.name}/{name}")
        except UnknownTypeError as error:
            raise ExpressionError(str(error)) from None


_STRING_FUNCTIONS = frozenset({"format", "repr", "str"})
_NON_COMBINING_FUNCTIONS = _STRING_FUNCTIONS | {
    *(
        "any",
        "all",
        "bool",
        "bytearray",
        "bytes",
        "dict",
        "enumerate",
        "filter",
        "float",
        "get",
        "getattr",
        "has",
        "int",
    ),
    *(
        "isinstance",
        "items",
        "keys",
        "kind_of",
        "len",
        "list",
        "map",
        "reversed",
        "set",
        "tuple",
        "type",
        "values",
        "zip",
    ),
}
"""Functions that do not combine items of one argument with items of another."""


class ModuleError(Error):
    """A requested module is not available."""


def load_modules(module_names: Iterable[str], now: Callable[[], Time]) -> dict[str, Any]:
    """Return the modules that expressions can use by name: math, numpy and the requested ones.

    Args:
        module_names: the requested modules: rospy and genpy (times), tf (transformations), time, random, or message
            packages.
        now: returns the current time, for rospy.Time.now.

    Raises:
        ModuleError: a module is not available.
    """
    modules: dict[str, Any] = {"math": Module("math", MATH_NAMES), "numpy": numpy_module()}
    for name in {name.partition(".")[0] for name in module_names} - modules.keys():
        if name in ("rospy", "genpy"):
            modules[name] = time_module(now, name)
        elif name == "time":
            modules[name] = Module("time", {"time": time.time})
        elif name == "random":
            modules[name] = Module(
                "random", {member_name: getattr(random, member_name) for member_name in _RANDOM_NAMES}
            )
        elif name == "tf":
            modules[name] = _tf_module()
        else:
            modules[name] = _message_module(name)
    return modules


def _message_module(package: str) -> Module:
    try:
        import_module(f"pyros1.msgs.{package}.msg")
    except (ImportError, ValueError):
        raise ModuleError(
            f"expressions cannot import {package!r}: they can import math, numpy, random, time, rospy, genpy, tf "
            "(its transformations), and message packages"
        ) from None
    return _MessageModule(package)


def _tf_module() -> Module:
    from pyros1.tf import transformations  # noqa: PLC0415 - rarely needed

    members = {
        name: CheckedFunction(getattr(transformations, name), name, size_function=squared_size)
        for name in transformations.__all__
        if name != "random_vector"
    }
    return Module("tf", {"transformations": Module("tf.transformations", members)})


class MessageExpression(MessageLanguage):
    """An expression about a message ``m``, with limits on arrays. See `Interpreter` for arguments and errors."""

    def evaluate(self, names: Mapping[str, Any]) -> Any:
        """Return the expression's value, with numpy numbers converted to Python numbers. See `Interpreter`."""
        result = super().evaluate(names)
        return (
            type(result)(map(_without_numpy_scalar, result))
            if type(result) in (list, tuple)
            else _without_numpy_scalar(result)
        )

    def _checked(self, value: Any) -> Any:
        if is_numpy(value):
            check_array(value)
        return super()._checked(value)

    def check_operands(self, *values: Any) -> None:
        """Check the size of the result of an operator on arrays. See `Interpreter`."""
        require_broadcast(*values)

    def check_matrices(self, left: Any, right: Any) -> None:
        """Add the cost of a matrix product. See `Interpreter`."""
        self._charge(int(product_cost(left, right)))

    def check_formatting(self, *values: Any) -> None:
        """Add the cost of converting values to strings. See `Interpreter`."""
        self._charge(string_cost(*values))

    def check_index(self, owner: Any, key: Any) -> None:
        """Check an array's index. See `Interpreter`."""
        if is_numpy(owner):
            require_index(owner, key)

    def _call_function(self, function: Callable[..., Any], *arguments: Any, **keywords: Any) -> Any:
        if isinstance(function, CheckedFunction):
            self._charge(function.cost(*arguments, **keywords))
        elif function_name(function) in _STRING_FUNCTIONS:
            self.check_formatting(*arguments, *keywords.values())
        elif not isinstance(function, Lambda | type) and function_name(function) not in _NON_COMBINING_FUNCTIONS:
            self.check_operands(method_owner(function), *arguments, *keywords.values())
        return super()._call_function(function, *arguments, **keywords)

    def _limited_key(self, function: Callable[..., Any]) -> Callable[[Any], Any]:
        key = super()._limited_key(function)

        def checked_key(item: Any) -> Any:
            value = key(item)
            if has_array(value):
                raise ExpressionError("items cannot be sorted by arrays")
            return value

        return checked_key

    def known_names(self, names: Mapping[str, Any]) -> str:
        """Return the known names for an error message."""
        return ", ".join(sorted([*names, *FUNCTIONS]))

    def attribute(self, owner: Any, name: str) -> Any:
        """Return a field, a method, or a member of an array or module. See `Interpreter`."""
        if type(owner).__module__ == "numpy" and name in ARRAY_MEMBERS:
            return array_member(owner, name)
        return super().attribute(owner, name)


def _without_numpy_scalar(value: Any) -> Any:
    return value.item() if type(value).__module__ == "numpy" and value.ndim == 0 else value


def names_used(text: str) -> set[str]:
    """Return the names that an expression uses, except names defined by its comprehensions and lambdas.

    Raises:
        SyntaxError, ValueError: the string is not a Python expression.
    """
    syntax_nodes = list(ast.walk(ast.parse(text.strip(), mode="eval")))
    name_nodes = [node for node in syntax_nodes if isinstance(node, ast.Name)]
    defined_names = {node.id for node in name_nodes if isinstance(node.ctx, ast.Store)}
    return (
        {node.id for node in name_nodes}
        - defined_names
        - {node.arg for node in syntax_nodes if isinstance(node, ast.arg)}
    )
