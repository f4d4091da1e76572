"""What expressions of transform and relay_field may use of numpy: no files, no code, and no result without a limit."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Mapping
from importlib import import_module
from itertools import zip_longest
from typing import Any

from pyros1.ground.expressions import ExpressionError, require
from pyros1.observe.expression import MAX_ITEMS
from pyros1.observe.modules import Module

_NUMPY = """
abs absolute add all allclose amax amin angle any append arccos arccosh arcsin arcsinh arctan arctan2 arctanh argmax
argmin argsort argwhere around array array_equal asarray atleast_1d atleast_2d average bool_ cbrt ceil clip
column_stack concatenate copysign cos cosh count_nonzero cross cumprod cumsum deg2rad degrees diag diagonal diff
divide dot dstack e equal exp expm1 fabs flip float32 float64 floor floor_divide fmax fmin fmod frombuffer full_like
gradient greater greater_equal hstack hypot imag inf int16 int32 int64 int8 interp isclose isfinite isinf isnan less
less_equal log log10 log1p log2 logical_and logical_not logical_or logical_xor max maximum mean median min minimum mod
multiply nan nan_to_num nanargmax nanargmin nanmax nanmean nanmedian nanmin nanpercentile nanstd nansum nanvar
negative newaxis nonzero not_equal ones_like percentile pi polyfit polyval power prod ptp quantile rad2deg
radians ravel real reciprocal remainder reshape rint roll rot90 round searchsorted sign sin sinc sinh size sort sqrt
square squeeze stack std subtract sum swapaxes tan tanh trace transpose trapz trunc uint16 uint32 uint64 uint8 unique
unwrap var vstack where zeros_like
"""
_LINALG = ["det", "eigvals", "eigvalsh", "inv", "lstsq", "matrix_rank", "norm", "pinv", "solve"]
_ARRAY = """
T all any argmax argmin argsort astype clip conj copy cumprod cumsum diagonal dot dtype flatten imag item max mean min
ndim nonzero prod ptp ravel real reshape round searchsorted shape size squeeze std sum swapaxes tolist trace transpose
var
"""
ARRAY = frozenset(_ARRAY.split())
"""Members of arrays."""


def numpy_module() -> Module:
    """Return numpy, as far as expressions may use it."""
    numpy: Any = import_module("numpy")
    members = {name: getattr(numpy, name) for name in (*_NUMPY.split(), *_MADE) if hasattr(numpy, name)}
    for name, value in members.items():
        if callable(value) and not isinstance(value, type):
            members[name] = _Checked(value, _MADE.get(name, _broadcast))
    linalg = Module("numpy.linalg", {name: _Checked(getattr(numpy.linalg, name), _broadcast) for name in _LINALG})
    of_random = {name: _Checked(getattr(numpy.random, name), count) for name, count in _RANDOM.items()}
    return Module("numpy", {**members, "linalg": linalg, "random": Module("numpy.random", of_random)})


def member(array: Any, name: str) -> Any:
    """Return a member of an array, one of `ARRAY`."""
    value = getattr(array, name)
    if not callable(value):
        return value
    return _Checked(value, functools.partial(_dot if name == "dot" else _broadcast, array))


def check_array(value: Any, limit: int) -> None:
    """Check a result of numpy.

    Raises:
        ExpressionError: it has too many items, or has Python's objects in it, whose size nobody knows.
    """
    require(int(getattr(value, "size", 0)), limit)
    if getattr(getattr(value, "dtype", None), "hasobject", False):
        raise ExpressionError("arrays can only have numbers, truth values and texts here")


class _Checked:
    """A function whose result is measured before it is made.

    Args:
        function: the function.
        count: returns the number of items of the result, from the same arguments.
    """

    def __init__(self, function: Callable[..., Any], count: Callable[..., float]) -> None:
        self._function = function
        self._count = count

    def __call__(self, *args: Any, **keywords: Any) -> Any:
        """Call the function.

        Raises:
            ExpressionError: the result would be too large.
        """
        size = self._count(*args, **keywords)
        require(int(size) if size <= MAX_ITEMS else MAX_ITEMS + 1, MAX_ITEMS)
        return self._function(*args, **keywords)


def _broadcast(*args: Any, **keywords: Any) -> float:
    """Return the size of what arrays make together, item by item."""
    shapes = [_shape(value) for value in (*args, *keywords.values())]
    lengths = zip_longest(*(reversed(shape) for shape in shapes), fillvalue=1)
    return math.prod(map(max, lengths)) if shapes else 0


def _dot(left: Any, right: Any) -> float:
    return math.prod(_shape(left)[:-1]) * math.prod((*_shape(right)[:-2], *_shape(right)[-1:]))


def _shape(value: Any) -> tuple[int, ...]:
    if isinstance(value, (list, tuple)):
        return (len(value), *(_shape(value[0]) if value else ()))
    shape = getattr(value, "shape", None)
    return shape if isinstance(shape, tuple) else ()


def _of_shape(shape: Any, *_: Any, **__: Any) -> float:
    return math.prod(abs(int(each)) for each in (shape if isinstance(shape, (list, tuple)) else [shape]))


def _arange(start: float, stop: float | None = None, step: float = 1, *_: Any, **__: Any) -> float:
    first, last = (0, start) if stop is None else (start, stop)
    return max(0.0, (last - first) / step)


def _square(rows: int, columns: int | None = None, *_: Any, **__: Any) -> float:
    return float(rows) * (rows if columns is None else columns)


def _linspace(start: Any, stop: Any, num: int = 50, *_: Any, **__: Any) -> float:
    return num


def _of_size(first: Any = 0, second: Any = 1, size: Any = None) -> float:
    return max(_items(first), _items(second)) if size is None else _of_shape(size)


def _of_lengths(*lengths: int) -> float:
    return _of_shape(lengths)


def _outer(left: Any, right: Any) -> float:
    return float(_items(left)) * _items(right)


def _tile(array: Any, times: Any) -> float:
    return _items(array) * _of_shape(times)


def _repeat(array: Any, times: int, axis: int | None = None) -> float:
    return _items(array) * float(times)


def _items(value: Any) -> int:
    size = getattr(value, "size", None)
    return int(size) if size is not None else len(value) if isinstance(value, (list, tuple)) else 1


_MADE: Mapping[str, Callable[..., float]] = {
    "arange": _arange,
    "dot": _dot,
    "eye": _square,
    "full": _of_shape,
    "identity": _square,
    "linspace": _linspace,
    "ones": _of_shape,
    "outer": _outer,
    "repeat": _repeat,
    "tile": _tile,
    "zeros": _of_shape,
}
"""Functions that make large arrays from small arguments: how many items those have."""
_RANDOM: Mapping[str, Callable[..., float]] = {
    "normal": _of_size,
    "uniform": _of_size,
    "randint": _of_size,
    "rand": _of_lengths,
    "randn": _of_lengths,
}
"""As `_MADE`, of ``numpy.random``."""
