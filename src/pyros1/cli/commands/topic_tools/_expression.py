"""What expressions of transform and relay_field may use: the language of filters, and a few modules.

A module is a list of allowed members. Nothing else can be reached, and nothing is imported by a name that a user gives.
"""

from __future__ import annotations

import ast
import random
import time
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any

from pyros1.cli.commands.topic_tools._arrays import ARRAY, Checked, member, numpy_module
from pyros1.cli.commands.topic_tools._estimates import product_work, squared
from pyros1.cli.commands.topic_tools._sizes import (
    check_array,
    has_array,
    is_numpy,
    require_index,
    require_together,
    text_work,
)
from pyros1.ground.errors import Error, UnknownTypeError
from pyros1.ground.expressions import ExpressionError
from pyros1.ground.expressions.functions import MATH, name_of, owner_of
from pyros1.ground.expressions.lambdas import Lambda
from pyros1.ground.timing import Time
from pyros1.msgs import load_message
from pyros1.observe.expression import FUNCTIONS, MessageLanguage
from pyros1.observe.modules import Module, times

_RANDOM = ("choice", "gauss", "normalvariate", "randint", "random", "uniform")


class _MessageModule(Module):
    def __init__(self, package: str) -> None:
        super().__init__(package, {})

    def get(self, name: str) -> Any:
        try:
            return self if name == "msg" else load_message(f"{self.name}/{name}")
        except UnknownTypeError as error:
            raise ExpressionError(str(error)) from None


_TEXTS = frozenset({"format", "repr", "str"})
_APART = _TEXTS | {
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
"""Functions that do not combine the items of their arguments with each other."""


class ModuleError(Error):
    """A requested module is not available."""


def load_modules(names: Iterable[str], now: Callable[[], Time]) -> dict[str, Any]:
    """Return modules by name, always including math and numpy.

    Args:
        names: requested modules: rospy and genpy (times), tf (transformations), time, random, or a package of messages.
        now: the function for rospy.Time.now.

    Raises:
        ModuleError: a module is not available.
    """
    modules: dict[str, Any] = {"math": Module("math", MATH), "numpy": numpy_module()}
    for name in {name.partition(".")[0] for name in names} - modules.keys():
        if name in ("rospy", "genpy"):
            modules[name] = times(now, name)
        elif name == "time":
            modules[name] = Module("time", {"time": time.time})
        elif name == "random":
            modules[name] = Module("random", {each: getattr(random, each) for each in _RANDOM})
        elif name == "tf":
            modules[name] = _tf()
        else:
            modules[name] = _messages(name)
    return modules


def _messages(package: str) -> Module:
    try:
        import_module(f"pyros1.msgs.{package}.msg")
    except (ImportError, ValueError):
        raise ModuleError(
            f"expressions cannot import {package!r}: they can import math, numpy, random, time, rospy, genpy, tf "
            "(its transformations), and packages of messages"
        ) from None
    return _MessageModule(package)


def _tf() -> Module:
    from pyros1.tf import transformations  # noqa: PLC0415 - rarely needed

    members = {
        name: Checked(getattr(transformations, name), name, count=squared)
        for name in transformations.__all__
        if name != "random_vector"
    }
    return Module("tf", {"transformations": Module("tf.transformations", members)})


class MessageExpression(MessageLanguage):
    """A checked expression on a message ``m``; see `Interpreter` for arguments and errors."""

    def evaluate(self, names: Mapping[str, Any]) -> Any:
        """Return the expression's value, with numpy's numbers as Python's; see `Interpreter`."""
        result = super().evaluate(names)
        return type(result)(map(_plain, result)) if type(result) in (list, tuple) else _plain(result)

    def _checked(self, value: Any) -> Any:
        if is_numpy(value):
            check_array(value)
        return super()._checked(value)

    def combine(self, *values: Any) -> None:
        """Check values that an operator combines, for arrays; see `Interpreter`."""
        require_together(*values)

    def multiply(self, left: Any, right: Any) -> None:
        """Count the work of a product of matrices; see `Interpreter`."""
        self._charge(int(product_work(left, right)))

    def write(self, *values: Any) -> None:
        """Count the work of writing values as text; see `Interpreter`."""
        self._charge(text_work(*values))

    def choose(self, owner: Any, key: Any) -> None:
        """Check an array's index; see `Interpreter`."""
        if is_numpy(owner):
            require_index(owner, key)

    def _called(self, function: Callable[..., Any], *arguments: Any, **keywords: Any) -> Any:
        if isinstance(function, Checked):
            self._charge(function.work(*arguments, **keywords))
        elif name_of(function) in _TEXTS:
            self.write(*arguments, *keywords.values())
        elif not isinstance(function, Lambda | type) and name_of(function) not in _APART:
            self.combine(owner_of(function), *arguments, *keywords.values())
        return super()._called(function, *arguments, **keywords)

    def _key(self, function: Callable[..., Any]) -> Callable[[Any], Any]:
        key = super()._key(function)

        def checked(item: Any) -> Any:
            value = key(item)
            if has_array(value):
                raise ExpressionError("items cannot be sorted by arrays")
            return value

        return checked

    def known(self, names: Mapping[str, Any]) -> str:
        """Return the known names, for an error's text."""
        return ", ".join(sorted([*names, *FUNCTIONS]))

    def attribute(self, owner: Any, name: str) -> Any:
        """Return a field, a method, or a member of an array or module; see `Interpreter`."""
        if type(owner).__module__ == "numpy" and name in ARRAY:
            return member(owner, name)
        return super().attribute(owner, name)


def _plain(value: Any) -> Any:
    return value.item() if type(value).__module__ == "numpy" and value.ndim == 0 else value


def names_used(text: str) -> set[str]:
    """Return the names in an expression, without those that its comprehensions and lambdas define.

    Raises:
        SyntaxError, ValueError: it is not a Python expression.
    """
    nodes = list(ast.walk(ast.parse(text.strip(), mode="eval")))
    found = [node for node in nodes if isinstance(node, ast.Name)]
    defined = {node.id for node in found if isinstance(node.ctx, ast.Store)}
    return {node.id for node in found} - defined - {node.arg for node in nodes if isinstance(node, ast.arg)}
