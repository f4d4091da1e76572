"""The functions of numpy in expressions: the sizes of their results and their work, estimated from their arguments."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from itertools import chain
from typing import Any

from pyros1.cli.commands.topic_tools._sizes import items, require_size, shape_of, together
from pyros1.ground.expressions import ExpressionError

_ARRAY = 50
"""Number of items that take as much memory as an empty array."""
_DIGITS = 400
_ROW_WORK = 300
"""Work of a function that numpy applies to each row in Python."""

# Items of results ----------------------------------------------------------------------------------------------------


def broadcast(*args: Any, **keywords: Any) -> float:
    """Return the maximum number of items in the result of most functions, which work item by item."""
    return together([shape_of(value) for value in (*args, *keywords.values())])


def squared(*args: Any, **keywords: Any) -> float:
    """Return the square of the number of items of the largest argument."""
    return max(map(items, (*args, *keywords.values())), default=0) ** 2


def _total(*args: Any, **_: Any) -> float:
    parts = chain(*(arg if type(arg) in (list, tuple) else [arg] for arg in args))
    return 2 * sum(max(1, items(part)) for part in parts)


def _dot(a: Any, b: Any, *_: Any, **__: Any) -> float:
    left, right = shape_of(a), shape_of(b)
    return math.prod(left[:-1]) * math.prod((*right[:-2], *right[-1:])) if left and right else items(a) * items(b)


def _outer(a: Any, b: Any, *_: Any, **__: Any) -> float:
    return items(a) * items(b)


def _inner(a: Any, b: Any) -> float:
    left, right = shape_of(a), shape_of(b)
    return math.prod(left[:-1]) * math.prod(right[:-1]) if left and right else items(a) * items(b)


def _sum_of_items(*args: Any, **_: Any) -> float:
    return sum(map(items, args))


def _histogram(a: Any, bins: Any = 10, *_: Any, **__: Any) -> float:
    if isinstance(bins, str):
        raise ExpressionError("bins must be a number or a list here")
    return max(items(a), float(bins) if shape_of(bins) == () else items(bins))


def _sections(ary: Any, indices_or_sections: Any, *_: Any, **__: Any) -> float:
    single = shape_of(indices_or_sections) == ()
    return items(ary) + _ARRAY * (float(indices_or_sections) if single else items(indices_or_sections))


def _inserted(arr: Any, obj: Any, values: Any, axis: int | None = None) -> float:
    more = max(items(obj), items(values))
    return items(arr) + (more if axis is None else more * items(arr))


def _quantiles(a: Any, q: Any, *_: Any, **__: Any) -> float:
    return items(a) * items(q)


def _of_shape(shape: Any, *_: Any, **__: Any) -> float:
    lengths = shape if isinstance(shape, (list, tuple)) or shape_of(shape) else [shape]
    return math.prod(abs(operator.index(each)) for each in lengths)


def _like(a: Any, *args: Any, shape: Any = None, **_: Any) -> float:
    if len(args) >= _LIKE_ARGUMENTS:
        raise ExpressionError("the shape must be named here: shape=...")
    return items(a) if shape is None else _of_shape(shape)


_LIKE_ARGUMENTS = 4
"""Number of arguments after the array in ``zeros_like`` and similar functions, of which one may be the shape."""


def _arange(start: Any = 0, stop: Any = None, step: Any = 1, *_: Any, **__: Any) -> float:
    first, last = (0, start) if stop is None else (start, stop)
    return max(0.0, float((last - first) / (1 if step is None else step)))


def _square(N: Any, M: Any = None, *_: Any, **__: Any) -> float:
    return float(N) * float(N if M is None else M)


def _diagonal(v: Any, k: int = 0) -> float:
    return float(items(v) + abs(k)) ** 2 if len(shape_of(v)) < 2 else items(v)


def _linspace(start: Any, stop: Any, num: Any = 50, *_: Any, **__: Any) -> float:
    return float(num) * broadcast(start, stop)


def _of_size(*args: Any, size: Any = None, **keywords: Any) -> float:
    first, last = args[:2], args[2:]
    size = size if size is not None else last[0] if last else None
    return broadcast(*first, **keywords) if size is None else _of_shape(size)


def _of_lengths(*lengths: Any) -> float:
    return _of_shape(lengths)


def _tile(A: Any, reps: Any) -> float:
    return max(1, items(A)) * _of_shape(reps)


def _repeat(a: Any, repeats: Any, axis: int | None = None) -> float:
    return items(a) * float(repeats if shape_of(repeats) == () else max(repeats, default=0))


def _by_dimension(*args: Any, **keywords: Any) -> float:
    return broadcast(*args, **keywords) * max(1, *(len(shape_of(each)) for each in (1, *args, *keywords.values())))


def _where(condition: Any, *args: Any) -> float:
    return broadcast(condition, *args) if args else _by_dimension(condition)


MADE: Mapping[str, Callable[..., float]] = {
    "append": _total,
    "arange": _arange,
    "argwhere": _by_dimension,
    "array_split": _sections,
    "column_stack": _total,
    "convolve": _sum_of_items,
    "correlate": _sum_of_items,
    "concatenate": _total,
    "diag": _diagonal,
    "dot": _dot,
    "dstack": _total,
    "eye": _square,
    "full": _of_shape,
    "full_like": _like,
    "gradient": _by_dimension,
    "histogram": _histogram,
    "hstack": _total,
    "identity": lambda n, *_, **__: _square(n),
    "inner": _inner,
    "insert": _inserted,
    "linspace": _linspace,
    "lstsq": _total,
    "nanpercentile": _quantiles,
    "nonzero": _by_dimension,
    "ones": _of_shape,
    "ones_like": _like,
    "outer": _outer,
    "percentile": _quantiles,
    "quantile": _quantiles,
    "repeat": _repeat,
    "split": _sections,
    "tile": _tile,
    "vstack": _total,
    "where": _where,
    "zeros": _of_shape,
    "zeros_like": _like,
}
"""Functions whose result can have more items than `broadcast` returns -> the number of items, from the arguments."""
RANDOM: Mapping[str, Callable[..., float]] = {
    "normal": _of_size,
    "uniform": _of_size,
    "randint": _of_size,
    "rand": _of_lengths,
    "randn": _of_lengths,
}
"""Like `MADE`, for ``numpy.random``."""


# Work ----------------------------------------------------------------------------------------------------------------


def no_work(*_: Any, **__: Any) -> float:
    """Return 0: the arguments and the result are counted anyway."""
    return 0


def _matrix_work(*args: Any, **keywords: Any) -> float:
    shapes = [shape_of(value) for value in (*args, *keywords.values())]
    return together(shapes) * max((min(shape[-2:]) for shape in shapes if len(shape) > 1), default=1)


def _least_squares_work(a: Any, b: Any, *_: Any, **__: Any) -> float:
    return (items(a) + items(b)) * min(shape_of(a))


def _dot_work(a: Any, b: Any, *_: Any, **__: Any) -> float:
    return _dot(a, b) * (shape_of(a) or (1,))[-1] / 16


def product_work(a: Any, b: Any) -> float:
    """Return the work of a product of matrices."""
    return items(a) * (shape_of(b) or (1,))[-1] * max(1, items(b) // max(1, math.prod(shape_of(b)[-2:]))) / 16


def _inner_work(a: Any, b: Any) -> float:
    return items(a) * items(b) / (shape_of(b) or (1,))[-1] / 16 if items(b) else 0


def _convolution_work(a: Any, v: Any, *_: Any, **__: Any) -> float:
    return items(a) * items(v) / 16


def _fit_work(x: Any, y: Any, deg: Any, *_: Any, **__: Any) -> float:
    require_size(items(x) * float(deg + 1))
    return (items(x) + items(y)) * float(deg + 1) ** 2


def _polynomial_work(p: Any, x: Any) -> float:
    return items(p) * (20 + items(x))


def _difference_work(a: Any, n: int = 1, *_: Any, **__: Any) -> float:
    return float(n) * (20 + items(a))


def _rows_work(a: Any, *args: Any, **keywords: Any) -> float:
    return _ROW_WORK * items(a) if args or keywords else 0


def _quantile_rows_work(a: Any, _q: Any, *args: Any, **keywords: Any) -> float:
    return _rows_work(a, *args, **keywords)


def _round_work(a: Any, decimals: int = 0, *_: Any, **__: Any) -> float:
    if abs(decimals) > _DIGITS:  # numpy multiplies by ten this many times
        raise ExpressionError("cannot round to that many digits")
    return items(a)


WORK: Mapping[str, Callable[..., float]] = {
    **dict.fromkeys(("det", "eigvals", "eigvalsh", "inv", "matrix_rank", "norm", "pinv", "solve"), _matrix_work),
    **dict.fromkeys(("around", "round"), _round_work),
    **dict.fromkeys(("convolve", "correlate"), _convolution_work),
    "diff": _difference_work,
    "dot": _dot_work,
    "inner": _inner_work,
    "lstsq": _least_squares_work,
    "matmul": product_work,
    "nanmedian": _rows_work,
    "nanpercentile": _quantile_rows_work,
    "polyfit": _fit_work,
    "polyval": _polynomial_work,
}
"""Functions that do more than visit each item once or a few times."""
