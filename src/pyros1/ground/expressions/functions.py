"""Functions for expressions: builtins, methods of plain values and math, each with a limit on its result.

A function that can create a large result from small arguments computes the result's size first. No function gives
access to anything but its arguments.
"""

from __future__ import annotations

import ast
import contextlib
import functools
import math
import operator
import re
import string
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from pyros1.ground.expressions.limits import ExpressionError, check_limit, check_value, size
from pyros1.ground.expressions.operators import check_result

_MAX_ROUNDING_DIGITS = 400
_ENCODINGS = ("ascii", "latin-1", "utf-8", "utf8", "utf-16")

MATH_NAMES: Mapping[str, Any] = {
    name: getattr(math, name)
    for name in dir(math)  # sorted
    # The excluded functions can take very long with short arguments.
    if not name.startswith("_") and name not in ("factorial", "comb", "perm", "prod")
}
"""The available functions and constants of the module math."""

_STR_METHODS = frozenset(
    (
        *("capitalize", "casefold", "count", "endswith", "find", "index", "isalnum", "isalpha", "isascii", "isdecimal"),
        *("isdigit", "isidentifier", "islower", "isnumeric", "isspace", "istitle", "isupper", "lower", "lstrip"),
        *("partition", "removeprefix", "removesuffix", "rfind", "rindex", "rpartition", "rsplit", "rstrip", "split"),
        *("splitlines", "startswith", "strip", "swapcase", "title", "upper"),
    )
)
_BYTES_METHODS = frozenset(
    (
        *("count", "endswith", "find", "hex", "index", "isdigit", "lower", "rfind", "rstrip", "split"),
        *("startswith", "strip", "upper"),
    )
)
_LIST_METHODS = frozenset(("count", "index"))
_METHODS: Mapping[type, frozenset[str]] = {
    str: _STR_METHODS,
    bytes: _BYTES_METHODS,
    list: _LIST_METHODS,
    tuple: _LIST_METHODS,
    float: frozenset(("as_integer_ratio", "hex", "is_integer")),
    int: frozenset(("as_integer_ratio", "bit_length")),
    dict: frozenset(("get", "items", "keys", "values")),
    set: frozenset(("difference", "intersection", "isdisjoint", "issubset", "issuperset", "union")),
}


def find_method(owner: Any, name: str, limit: int) -> Callable[..., Any] | None:
    """Return a method of a string, list or other plain value, or None if expressions may not call it.

    Args:
        owner: the value.
        name: name of the method, which must not begin with ``_``.
        limit: maximum size of its result.
    """
    if type(owner) is int and name == "is_integer":
        return lambda: True  # int.is_integer is new in Python 3.12
    if name in _SIZE_CHECKED_METHODS.get(type(owner), ()):
        return functools.partial(_SIZE_CHECKED_METHODS[type(owner)][name], limit, owner)
    if name in _METHODS.get(type(owner), ()):
        return getattr(owner, name)  # type: ignore[no-any-return]  # one of the methods listed above
    return None


def method_owner(function: Callable[..., Any]) -> Any:
    """Return the value to which a method is bound if the method visits the items of the value, or None."""
    if isinstance(function, functools.partial):
        return None if len(function.args) < 2 else function.args[1]
    owner = getattr(function, "__self__", None)
    return owner if type(owner) in _METHODS else None


def function_name(function: Callable[..., Any]) -> str:
    """Return a function's name in expressions, even if it is a wrapper that checks the size first."""
    return str(getattr(getattr(function, "func", function), "__name__", "")).lstrip("_")


def calls_first_argument(function: Callable[..., Any]) -> bool:
    """Return whether a function calls its first argument, like ``map``."""
    return getattr(function, "func", function) in (_map, _filter)


def calls_key(function: Callable[..., Any]) -> bool:
    """Return whether a function calls its keyword argument ``key``."""
    return function in (max, min, sorted)


def _join(limit: int, separator: str, items: Iterable[str]) -> str:
    parts = list(items)
    check_limit(len(separator) * len(parts) + sum(map(len, parts)), limit)
    return separator.join(parts)


def _replace(limit: int, text: str, old: str, new: str, count: int = -1) -> str:
    check_limit(text.count(old) * len(new), limit)
    return text.replace(old, new, count)


def _format(limit: int, template: str, *arguments: Any, **keywords: Any) -> str:
    """Return a string formatted as by str.format(). Fields can only be numbers or names, so attributes are not
    accessible.
    """
    parts: list[str] = []
    next_number = total_length = 0
    for literal, field_name, spec, conversion in string.Formatter().parse(template):
        parts.append(literal)
        total_length += len(literal)
        if field_name is None:
            continue
        if "{" in (spec or ""):
            raise ExpressionError("nested fields are not allowed here")
        if not field_name:
            field_name, next_number = str(next_number), next_number + 1  # noqa: PLW2901 - automatic numbering
        if field_name.isdecimal():
            value = arguments[int(field_name)]
        elif field_name.isidentifier():
            value = keywords[field_name]
        else:
            raise ExpressionError(f"{{{field_name}}} is not allowed here: only numbers and names are")
        parts.append(format_field(value, conversion, spec or "", limit))
        total_length += len(parts[-1])
        check_limit(total_length, limit)
    return "".join(parts)


def format_field(value: Any, conversion: str | None, spec: str, limit: int) -> str:
    """Format one field of a format string or an f-string.

    Args:
        value: the value to format.
        conversion: ``r``, ``s``, ``a`` or None.
        spec: the format specification after the colon.
        limit: maximum width.
    """
    for number in re.findall(r"\d+", spec):
        check_limit(int(number) if len(number) < 10 else limit + 1, limit)
    if conversion in ("r", "a"):
        value = repr(value) if conversion == "r" else ascii(value)
    elif conversion == "s":
        value = str(value)
    return format(value, spec)


def _checked_encoding(encoding: str) -> str:
    if str(encoding).lower().replace("_", "-") not in _ENCODINGS:
        # Other encodings can be very slow.
        raise ExpressionError(f"the encoding must be one of {', '.join(_ENCODINGS)}")
    return encoding


def _encode(limit: int, text: str, encoding: str = "utf-8", errors: str = "strict") -> bytes:
    return text.encode(_checked_encoding(encoding), errors)


def _decode(limit: int, data: bytes, encoding: str = "utf-8", errors: str = "strict") -> str:
    return data.decode(_checked_encoding(encoding), errors)


def _limit_padding(pad: Callable[..., str]) -> Callable[..., str]:
    def pad_limited(limit: int, text: str, width: int, *fill: str) -> str:
        check_limit(width, limit)
        return pad(text, width, *fill)

    return pad_limited


_SIZE_CHECKED_METHODS: Mapping[type, Mapping[str, Callable[..., Any]]] = {
    str: {
        "join": _join,
        "replace": _replace,
        "format": _format,
        "encode": _encode,
        **{name: _limit_padding(getattr(str, name)) for name in ("center", "ljust", "rjust", "zfill")},
    },
    bytes: {"decode": _decode},
}
"""Methods that can create large results from small arguments, or can be very slow."""


def _map(limit: int, function: Callable[..., Any], *iterables: Iterable[Any]) -> list[Any]:
    """Return the result of map() as a list, so that the limits apply to the result as well."""
    results: list[Any] = []
    total = 0
    for arguments in zip(*iterables):  # noqa: B905 - like map(), up to the shortest
        results.append(check_value(function(*arguments), limit))
        total += 1 + size(results[-1], limit)
        check_limit(total, limit)
    return results


def _filter(function: Callable[[Any], Any] | None, items: Iterable[Any]) -> list[Any]:
    return [item for item in items if (item if function is None else function(item))]


def _enumerate(items: Iterable[Any], start: int = 0) -> list[Any]:
    return list(enumerate(items, start))


def _reversed(items: Any) -> list[Any]:
    return list(reversed(items))


def _range(limit: int, *arguments: int) -> list[int]:
    numbers = range(*arguments)
    check_limit(len(numbers), limit)
    return list(numbers)


def _zip(*iterables: Iterable[Any]) -> list[Any]:
    return list(zip(*iterables))  # noqa: B905 - like zip(), up to the shortest


def _round(number: Any, ndigits: int | None = None) -> Any:
    """Round like round(), but limit the digits, since round() would compute any power of ten for an integer."""
    if ndigits is not None and abs(ndigits) > _MAX_ROUNDING_DIGITS:
        raise ValueError("cannot round to that many digits")
    return round(number, ndigits)


def _sum(numbers: Iterable[Any], start: float = 0) -> Any:
    """Return the sum of numbers. Other values are rejected, since adding lists copies the sum so far at each step."""
    if not isinstance(start, int | float):
        raise TypeError("sum() accepts only numbers")
    return sum(numbers, start)


def _format_value(limit: int, value: Any, spec: str = "") -> str:
    return format_field(value, None, spec, limit)


def _pow(limit: int, base: Any, exponent: Any) -> Any:
    check_result(ast.Pow(), base, exponent, limit)
    return base**exponent


def _next(items: Iterable[Any], *default: Any) -> Any:
    """Return the first item, or the default if there is none: in expressions, iterators are lists."""
    for item in items:
        return item
    if not default:
        raise ValueError("next() of an empty sequence")
    return default[0]


def _bytes(limit: int, value: Any = b"") -> bytes:
    with contextlib.suppress(TypeError):
        check_limit(operator.index(value), limit)
    return bytes(value)


def _bytearray(limit: int, value: Any = b"") -> bytearray:
    return bytearray(_bytes(limit, value))


def extra_functions(limit: int) -> dict[str, Any]:
    """Return, by name, the builtins that expressions on messages can call in addition to `builtin_functions`."""
    limited: dict[str, Callable[..., Any]] = {"bytearray": _bytearray, "bytes": _bytes, "pow": _pow}
    return {"next": _next, **{name: functools.partial(function, limit) for name, function in limited.items()}}


def builtin_functions(limit: int) -> dict[str, Any]:
    """Return the builtins that expressions can call, by name.

    Args:
        limit: maximum size of a result.
    """
    limited: dict[str, Callable[..., Any]] = {"map": _map, "range": _range, "format": _format_value}
    return {
        **{name: functools.partial(function, limit) for name, function in limited.items()},
        **{builtin_type.__name__: builtin_type for builtin_type in (bool, dict, float, int, list, set, str, tuple)},
        **{function.__name__: function for function in (abs, all, any, len, max, min, sorted)},
        **{function.__name__: function for function in (bin, chr, divmod, hex, isinstance, oct, ord, repr)},
        "enumerate": _enumerate,
        "filter": _filter,
        "reversed": _reversed,
        "round": _round,
        "sum": _sum,
        "zip": _zip,
    }
