"""``$(eval ...)``: a small, safe part of Python's expressions (X71, https://wiki.ros.org/roslaunch/XML).

What is said in `pyros1.expressions`, plus the functions of ``math``, a few builtins and methods of plain values.
"""

from __future__ import annotations

import ast
import functools
import math
import re
import string
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pyros1.errors import LaunchError
from pyros1.expressions import MAX_ITEMS, ExpressionError, Interpreter, bounded, require, size

# Those left out take very long for arguments that are soon written.
_MATH = {
    name: getattr(math, name)
    for name in dir(math)
    if not name.startswith("_") and name not in ("factorial", "comb", "perm", "prod")
}


def _map(function: Callable[..., Any], *iterables: Iterable[Any]) -> list[Any]:
    """map(), but at once: what it makes has to keep the bounds, too."""
    results: list[Any] = []
    total = 0
    for arguments in zip(*iterables):  # noqa: B905 - as map() does it, up to the shortest
        results.append(bounded(function(*arguments)))
        total += 1 + size(results[-1])
        require(total)
    return results


def _join(separator: str, items: Iterable[str]) -> str:
    parts = list(items)
    require(len(separator) * len(parts))
    return separator.join(parts)


def _replace(text: str, old: str, new: str, count: int = -1) -> str:
    require(text.count(old) * len(new))
    return text.replace(old, new, count)


def _formatted(value: Any, conversion: str | None, spec: str) -> str:
    """One field of a format text; widths are measured before anything gets as wide."""
    for number in re.findall(r"\d+", spec):
        require(int(number) if len(number) < 10 else MAX_ITEMS + 1)
    if conversion in ("r", "a"):
        value = repr(value) if conversion == "r" else ascii(value)
    elif conversion == "s":
        value = str(value)
    return format(value, spec)


def _format(template: str, *arguments: Any, **keywords: Any) -> str:
    """str.format(), but a field is a number or a name: nothing inside of values can be reached."""
    parts: list[str] = []
    automatic = 0
    for literal, field, spec, conversion in string.Formatter().parse(template):
        parts.append(literal)
        if field is None:
            continue
        if "{" in (spec or ""):
            raise ExpressionError("fields inside of fields are not possible here")
        if not field:
            field, automatic = str(automatic), automatic + 1  # noqa: PLW2901 - numbers itself
        if field.isdecimal():
            value = arguments[int(field)]
        elif field.isidentifier():
            value = keywords[field]
        else:
            raise ExpressionError(f"{{{field}}} is not possible here: only numbers and names are")
        parts.append(_formatted(value, conversion, spec or ""))
        require(sum(map(len, parts)))
    return "".join(parts)


def _range(*arguments: int) -> list[int]:
    numbers = range(*arguments)
    require(len(numbers))
    return list(numbers)


def _zip(*iterables: Iterable[Any]) -> list[Any]:
    return list(zip(*iterables))  # noqa: B905 - as zip() does it, up to the shortest


def _filter(function: Callable[[Any], Any] | None, items: Iterable[Any]) -> list[Any]:
    return [item for item in items if (item if function is None else function(item))]


def _format_value(value: Any, spec: str = "") -> str:
    return _formatted(value, None, spec)


def _padder(method: Callable[..., str]) -> Callable[..., str]:
    def pad(text: str, width: int, *fill: str) -> str:
        require(width)
        return method(text, width, *fill)

    return pad


_BUILTINS: dict[str, Any] = {
    "map": _map,
    "range": _range,
    "zip": _zip,
    "filter": _filter,
    "format": _format_value,
    "enumerate": lambda items, start=0: list(enumerate(items, start)),
    "reversed": lambda items: list(reversed(items)),
    **{kind.__name__: kind for kind in (bool, dict, float, int, list, set, str, tuple)},
    **{function.__name__: function for function in (abs, all, any, len, max, min, round, sorted, sum)},
    **{function.__name__: function for function in (bin, chr, divmod, hex, isinstance, oct, ord, repr)},
    "true": True,
    "false": False,
    **_MATH,
}
# Methods of plain values that launch files use; none of them gives access to anything but its own value.
_STR_METHODS = frozenset(
    (
        *("capitalize", "count", "endswith", "find", "index", "isalnum", "isalpha", "isdigit", "islower", "isspace"),
        *("isupper", "lower", "lstrip", "partition", "rfind", "rindex", "rpartition", "rsplit", "rstrip", "split"),
        *("splitlines", "startswith", "strip", "swapcase", "title", "upper"),
    )
)
_LIST_METHODS = frozenset(("count", "index"))
_DICT_METHODS = frozenset(("get", "keys", "values", "items"))
_METHODS: dict[type, frozenset[str]] = {
    str: _STR_METHODS,
    list: _LIST_METHODS,
    tuple: _LIST_METHODS,
    dict: _DICT_METHODS,
}
# Those that make much out of little.
_MEASURED: dict[str, Callable[..., str]] = {
    "join": _join,
    "replace": _replace,
    "format": _format,
    **{name: _padder(getattr(str, name)) for name in ("center", "ljust", "rjust", "zfill")},
}


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
        return str(_Eval(text).evaluate({**variables, **_BUILTINS, **functions}))
    except (ExpressionError, RecursionError) as error:
        raise LaunchError(f"cannot evaluate $(eval {text}): {error}") from error


class _Eval(Interpreter):
    nodes = Interpreter.nodes | {
        *(ast.Attribute, ast.Call, ast.Dict, ast.Set, ast.JoinedStr, ast.FormattedValue),
        *(ast.ListComp, ast.GeneratorExp, ast.SetComp, ast.DictComp),
    }
    formatting = True

    def value(self, node: ast.expr, names: Mapping[str, Any]) -> Any:
        if isinstance(node, ast.JoinedStr):
            return bounded("".join(self.value(part, names) for part in node.values))
        if isinstance(node, ast.FormattedValue):
            spec = self.value(node.format_spec, names) if node.format_spec else ""
            conversion = chr(node.conversion) if node.conversion > 0 else None
            return _formatted(self.value(node.value, names), conversion, spec)
        return super().value(node, names)

    def name(self, name: str, names: Mapping[str, Any]) -> Any:
        if name == "math":
            raise ExpressionError("'math' can only be used as in math.sqrt(x)")
        return bounded(super().name(name, names))

    def attribute(self, owner: Any, name: str) -> Any:
        if type(owner) is str and name in _MEASURED:
            return functools.partial(_MEASURED[name], owner)
        if name in _METHODS.get(type(owner), ()):
            return getattr(owner, name)
        return super().attribute(owner, name)

    def _attribute(self, node: ast.Attribute, names: Mapping[str, Any]) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in _MATH:
            return _MATH[node.attr]
        return super()._attribute(node, names)
