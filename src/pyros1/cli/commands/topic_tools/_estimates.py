"""Estimates the result sizes and costs of calls of numpy functions from the arguments."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from itertools import chain
from typing import Any

from pyros1.cli.commands.topic_tools._sizes import broadcast_count, item_count, require_size, shape_of
from pyros1.ground.expressions import ExpressionError

_EMPTY_ARRAY_ITEMS = 50
"""Number of array items that need as much memory as an empty array."""
_MAX_DIGITS = 400
"""Maximum number of digits to which numbers can be rounded."""
_ROW_COST = 300
"""Cost per row of a function that numpy applies to each row in Python."""

# Sizes of results ----------------------------------------------------------------------------------------------------


def broadcast_size(*args: Any, **keywords: Any) -> float:
    """Return the maximum number of items in the result of an element-wise function."""
    return broadcast_count([shape_of(value) for value in (*args, *keywords.values())])


def squared_size(*args: Any, **keywords: Any) -> float:
    """Return the squared number of items in the largest argument."""
    return max(map(item_count, (*args, *keywords.values())), default=0) ** 2


def _concatenated_size(*args: Any, **_: Any) -> float:
    parts = chain(*(arg if type(arg) in (list, tuple) else [arg] for arg in args))
    return 2 * sum(max(1, item_count(part)) for part in parts)


def _dot_size(a: Any, b: Any, *_: Any, **__: Any) -> float:
    left, right = shape_of(a), shape_of(b)
    return (
        math.prod(left[:-1]) * math.prod((*right[:-2], *right[-1:]))
        if left and right
        else item_count(a) * item_count(b)
    )


def _outer_size(a: Any, b: Any, *_: Any, **__: Any) -> float:
    return item_count(a) * item_count(b)


def _inner_size(a: Any, b: Any) -> float:
    left, right = shape_of(a), shape_of(b)
    return math.prod(left[:-1]) * math.prod(right[:-1]) if left and right else item_count(a) * item_count(b)


def _convolution_size(*args: Any, **_: Any) -> float:
    return sum(map(item_count, args))


def _histogram_size(a: Any, bins: Any = 10, *_: Any, **__: Any) -> float:
    if isinstance(bins, str):
        raise ExpressionError("bins must be a number or a list here")
    return max(item_count(a), float(bins) if shape_of(bins) == () else item_count(bins))


def _split_size(ary: Any, indices_or_sections: Any, *_: Any, **__: Any) -> float:
    is_number = shape_of(indices_or_sections) == ()
    return item_count(ary) + _EMPTY_ARRAY_ITEMS * (
        float(indices_or_sections) if is_number else item_count(indices_or_sections)
    )


def _inserted_size(arr: Any, obj: Any, values: Any, axis: int | None = None) -> float:
    inserted_count = max(item_count(obj), item_count(values))
    return item_count(arr) + (inserted_count if axis is None else inserted_count * item_count(arr))


def _quantile_size(a: Any, q: Any, *_: Any, **__: Any) -> float:
    return item_count(a) * item_count(q)


def _shape_size(shape: Any, *_: Any, **__: Any) -> float:
    lengths = shape if isinstance(shape, (list, tuple)) or shape_of(shape) else [shape]
    return math.prod(abs(operator.index(length)) for length in lengths)


def _like_size(a: Any, *args: Any, shape: Any = None, **_: Any) -> float:
    if len(args) >= _MAX_LIKE_ARGUMENTS:
        raise ExpressionError("the shape must be named here: shape=...")
    return item_count(a) if shape is None else _shape_size(shape)


_MAX_LIKE_ARGUMENTS = 4
"""Number of arguments after the array in ``zeros_like`` and similar functions; one of them may be the shape."""


def _arange_size(start: Any = 0, stop: Any = None, step: Any = 1, *_: Any, **__: Any) -> float:
    first, last = (0, start) if stop is None else (start, stop)
    return max(0.0, float((last - first) / (1 if step is None else step)))


def _eye_size(N: Any, M: Any = None, *_: Any, **__: Any) -> float:
    return float(N) * float(N if M is None else M)


def _diagonal_size(v: Any, k: int = 0) -> float:
    return float(item_count(v) + abs(k)) ** 2 if len(shape_of(v)) < 2 else item_count(v)


def _linspace_size(start: Any, stop: Any, num: Any = 50, *_: Any, **__: Any) -> float:
    return float(num) * broadcast_size(start, stop)


def _random_size(*args: Any, size: Any = None, **keywords: Any) -> float:
    distribution_args, size_args = args[:2], args[2:]
    size = size if size is not None else size_args[0] if size_args else None
    return broadcast_size(*distribution_args, **keywords) if size is None else _shape_size(size)


def _rand_size(*dimensions: Any) -> float:
    return _shape_size(dimensions)


def _tile_size(A: Any, reps: Any) -> float:
    return max(1, item_count(A)) * _shape_size(reps)


def _repeat_size(a: Any, repeats: Any, axis: int | None = None) -> float:
    return item_count(a) * float(repeats if shape_of(repeats) == () else max(repeats, default=0))


def _indices_size(*args: Any, **keywords: Any) -> float:
    return broadcast_size(*args, **keywords) * max(
        1, *(len(shape_of(value)) for value in (1, *args, *keywords.values()))
    )


def _where_size(condition: Any, *args: Any) -> float:
    return broadcast_size(condition, *args) if args else _indices_size(condition)


RESULT_SIZE_FUNCTIONS: Mapping[str, Callable[..., float]] = {
    "append": _concatenated_size,
    "arange": _arange_size,
    "argwhere": _indices_size,
    "array_split": _split_size,
    "column_stack": _concatenated_size,
    "convolve": _convolution_size,
    "correlate": _convolution_size,
    "concatenate": _concatenated_size,
    "diag": _diagonal_size,
    "dot": _dot_size,
    "dstack": _concatenated_size,
    "eye": _eye_size,
    "full": _shape_size,
    "full_like": _like_size,
    "gradient": _indices_size,
    "histogram": _histogram_size,
    "hstack": _concatenated_size,
    "identity": lambda n, *_, **__: _eye_size(n),
    "inner": _inner_size,
    "insert": _inserted_size,
    "linspace": _linspace_size,
    "lstsq": _concatenated_size,
    "nanpercentile": _quantile_size,
    "nonzero": _indices_size,
    "ones": _shape_size,
    "ones_like": _like_size,
    "outer": _outer_size,
    "percentile": _quantile_size,
    "quantile": _quantile_size,
    "repeat": _repeat_size,
    "split": _split_size,
    "tile": _tile_size,
    "vstack": _concatenated_size,
    "where": _where_size,
    "zeros": _shape_size,
    "zeros_like": _like_size,
}
"""Estimators of the number of items in a result, for functions whose result may exceed `broadcast_size`."""
RANDOM_RESULT_SIZE_FUNCTIONS: Mapping[str, Callable[..., float]] = {
    "normal": _random_size,
    "uniform": _random_size,
    "randint": _random_size,
    "rand": _rand_size,
    "randn": _rand_size,
}
"""The same as `RESULT_SIZE_FUNCTIONS`, for functions in ``numpy.random``."""


# Costs ---------------------------------------------------------------------------------------------------------------


def no_cost(*_: Any, **__: Any) -> float:
    """Return 0, for functions without a cost beyond that of their arguments and result, which is counted separately."""
    return 0


def _matrix_cost(*args: Any, **keywords: Any) -> float:
    shapes = [shape_of(value) for value in (*args, *keywords.values())]
    return broadcast_count(shapes) * max((min(shape[-2:]) for shape in shapes if len(shape) > 1), default=1)


def _least_squares_cost(a: Any, b: Any, *_: Any, **__: Any) -> float:
    return (item_count(a) + item_count(b)) * min(shape_of(a))


def _dot_cost(a: Any, b: Any, *_: Any, **__: Any) -> float:
    return _dot_size(a, b) * (shape_of(a) or (1,))[-1] / 16


def product_cost(a: Any, b: Any) -> float:
    """Return the cost of a matrix product."""
    return item_count(a) * (shape_of(b) or (1,))[-1] * max(1, item_count(b) // max(1, math.prod(shape_of(b)[-2:]))) / 16


def _inner_cost(a: Any, b: Any) -> float:
    return item_count(a) * item_count(b) / (shape_of(b) or (1,))[-1] / 16 if item_count(b) else 0


def _convolution_cost(a: Any, v: Any, *_: Any, **__: Any) -> float:
    return item_count(a) * item_count(v) / 16


def _fit_cost(x: Any, y: Any, deg: Any, *_: Any, **__: Any) -> float:
    require_size(item_count(x) * float(deg + 1))
    return (item_count(x) + item_count(y)) * float(deg + 1) ** 2


def _polynomial_cost(p: Any, x: Any) -> float:
    return item_count(p) * (20 + item_count(x))


def _difference_cost(a: Any, n: int = 1, *_: Any, **__: Any) -> float:
    return float(n) * (20 + item_count(a))


def _rows_cost(a: Any, *args: Any, **keywords: Any) -> float:
    return _ROW_COST * item_count(a) if args or keywords else 0


def _quantile_rows_cost(a: Any, _q: Any, *args: Any, **keywords: Any) -> float:
    return _rows_cost(a, *args, **keywords)


def _round_cost(a: Any, decimals: int = 0, *_: Any, **__: Any) -> float:
    if abs(decimals) > _MAX_DIGITS:  # numpy multiplies by ten once per digit
        raise ExpressionError("cannot round to that many digits")
    return item_count(a)


CALL_COSTS: Mapping[str, Callable[..., float]] = {
    **dict.fromkeys(("det", "eigvals", "eigvalsh", "inv", "matrix_rank", "norm", "pinv", "solve"), _matrix_cost),
    **dict.fromkeys(("around", "round"), _round_cost),
    **dict.fromkeys(("convolve", "correlate"), _convolution_cost),
    "diff": _difference_cost,
    "dot": _dot_cost,
    "inner": _inner_cost,
    "lstsq": _least_squares_cost,
    "matmul": product_cost,
    "nanmedian": _rows_cost,
    "nanpercentile": _quantile_rows_cost,
    "polyfit": _fit_cost,
    "polyval": _polynomial_cost,
}
"""Estimators of the cost of a call, for functions that do more than visit each item a few times."""
