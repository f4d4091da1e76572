"""What expressions of transform and relay_field may use: the language of filters, and a few modules.

A module is a list of allowed members. Nothing else can be reached, and nothing is imported by a name that a user gives.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any

from pyros1.ground.errors import Error, UnknownTypeError
from pyros1.ground.expressions import ExpressionError
from pyros1.ground.expressions.functions import MATH
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import Message, load_message
from pyros1.observe.expression import FUNCTIONS, MessageLanguage

_NUMPY = """
abs absolute all amax amin any arccos arccosh arcsin arcsinh arctan arctan2 arctanh argmax argmin argsort around
array asarray average bool_ cbrt ceil clip concatenate cos cosh count_nonzero cross cumsum deg2rad degrees diff
divide dot e equal exp fabs float32 float64 floor fmod greater greater_equal hypot inf int16 int32 int64 int8
isfinite isinf isnan less less_equal log log10 log2 logical_and logical_not logical_or max maximum mean median
min minimum mod multiply nan nanmax nanmean nanmin negative newaxis not_equal pi power prod rad2deg radians
remainder rint round sign sin sinc sinh sort sqrt square std subtract sum tan tanh trunc uint16 uint32 uint64
uint8 unique var vstack where
"""
_LINALG = ["norm", "det", "inv"]
_ARRAY = """
T all any argmax argmin astype clip dot flatten max mean min ndim prod round shape size std sum tolist var
"""


class Module:
    """A named set of values, which may be callable (as ``rospy.Time`` is)."""

    def __init__(self, name: str, members: Mapping[str, Any], call: Callable[..., Any] | None = None) -> None:
        self.name = name
        self._members = members
        self._call = call

    def get(self, name: str) -> Any:
        """Return a member.

        Raises:
            ExpressionError: no member has that name.
        """
        if name not in self._members:
            there = ", ".join(sorted(self._members))
            raise ExpressionError(
                f"expressions cannot use {self.name}.{name}; they can use these members of {self.name}: {there}"
            )
        return self._members[name]

    def __call__(self, *args: Any) -> Any:
        """Call it.

        Raises:
            TypeError: it cannot be called.
        """
        if self._call is None:
            raise TypeError(f"{self.name} is a module")
        return self._call(*args)


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
        names: requested modules: rospy (times), tf (transformations), or a package of messages.
        now: the function for rospy.Time.now.

    Raises:
        ModuleError: a module is not available.
    """
    modules: dict[str, Any] = {"math": Module("math", MATH), "numpy": _numpy()}
    for name in {name.partition(".")[0] for name in names} - modules.keys():
        if name == "rospy":
            modules[name] = _rospy(now)
        elif name == "tf":
            modules[name] = _tf()
        else:
            modules[name] = _messages(name)
    return modules


def _numpy() -> Module:
    numpy: Any = import_module("numpy")
    members = {name: getattr(numpy, name) for name in _NUMPY.split() if hasattr(numpy, name)}
    linalg = Module("numpy.linalg", {name: getattr(numpy.linalg, name) for name in _LINALG})
    return Module("numpy", {**members, "linalg": linalg})


def _rospy(now: Callable[[], Time]) -> Module:
    time = Module("rospy.Time", {"now": now, "from_sec": Time.from_sec}, Time)
    duration = Module("rospy.Duration", {"from_sec": Duration.from_sec}, Duration)
    members = {"Time": time, "Duration": duration, "get_rostime": now, "get_time": lambda: now().to_sec()}
    return Module("rospy", members)


def _messages(package: str) -> Module:
    try:
        import_module(f"pyros1.msgs.{package}.msg")
    except (ImportError, ValueError):
        raise ModuleError(
            f"expressions cannot import {package!r}: they can import math, numpy, rospy, tf (its transformations), "
            "and packages of messages"
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

    def known(self, names: Mapping[str, Any]) -> str:
        """Return the known names, for an error's text."""
        return ", ".join(sorted([*names, *FUNCTIONS]))

    def attribute(self, owner: Any, name: str) -> Any:
        """Return a field, a method, or a member of a module; see `Interpreter`."""
        if isinstance(owner, Module):
            return owner.get(name)
        if isinstance(owner, type) and issubclass(owner, Message):
            allowed = name.isupper()
        else:
            allowed = type(owner).__module__ == "numpy" and name in _ARRAY.split()
        return getattr(owner, name) if allowed else super().attribute(owner, name)


def _plain(value: Any) -> Any:
    return value.item() if type(value).__module__ == "numpy" and value.ndim == 0 else value


def names_used(text: str) -> set[str]:
    """Return the names in an expression, without those that its comprehensions define.

    Raises:
        SyntaxError, ValueError: it is not a Python expression.
    """
    found = [node for node in ast.walk(ast.parse(text.strip(), mode="eval")) if isinstance(node, ast.Name)]
    return {node.id for node in found} - {node.id for node in found if isinstance(node.ctx, ast.Store)}
