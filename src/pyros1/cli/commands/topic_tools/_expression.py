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

from pyros1.cli.commands.topic_tools._arrays import ARRAY, check_array, member, numpy_module
from pyros1.ground.errors import Error, UnknownTypeError
from pyros1.ground.expressions import ExpressionError
from pyros1.ground.expressions.functions import MATH
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
    from pyros1.tf import transformations  # noqa: PLC0415 - few expressions turn anything

    members = {name: getattr(transformations, name) for name in transformations.__all__ if name != "random_vector"}
    return Module("tf", {"transformations": Module("tf.transformations", members)})


class MessageExpression(MessageLanguage):
    """A checked expression on a message ``m``; see `Interpreter` for arguments and errors."""

    def evaluate(self, names: Mapping[str, Any]) -> Any:
        """Return the expression's value, with numpy's numbers as Python's; see `Interpreter`."""
        result = super().evaluate(names)
        return type(result)(map(_plain, result)) if type(result) in (list, tuple) else _plain(result)

    def _bounded(self, value: Any) -> Any:
        if type(value).__module__ == "numpy":
            check_array(value, self.max_items)
        return super()._bounded(value)

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
