"""Sizes of arrays and of the results of operators, and checks of these sizes."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import zip_longest
from typing import Any

from pyros1.ground.expressions import ExpressionError, require
from pyros1.ground.expressions.limits import CONTAINERS
from pyros1.msgs import Message
from pyros1.observe.expression import MAX_ITEMS

Shape = tuple[int, ...]

MAX_BYTES = 16 * MAX_ITEMS
"""Maximum size of an array, in bytes."""
MAX_WIDTH = 8192
"""Maximum size of an item of an array, in bytes: numpy's buffers for conversions contain thousands of items."""
_MAX_DIMENSIONS = 8
_MAX_NAME = 32
"""Maximum number of characters in the name of a type."""
_TEXT_BYTES = 256
"""Maximum size of a number as text, in bytes."""
_TEXT_WORK = 100
_TEXT_ITEMS = 1000
_NUMBERS = frozenset({bool, float, int, complex})
_SINGLE = _NUMBERS | {str, bytes, type(None)}


def is_numpy(value: Any) -> bool:
    """Return whether a value is an array or scalar of numpy."""
    return type(value).__module__ == "numpy" and hasattr(value, "itemsize")


def extent(value: Any) -> tuple[Shape, int]:
    """Return the shape that a value has as an array, and the number of bytes of an item.

    If lists in a list have different lengths, the longest counts.

    Raises:
        ExpressionError: the array would have Python objects as items, whose operations cannot be bounded.
    """
    kind = type(value)
    if kind is list or kind is tuple:
        return _of_items(value)
    if is_numpy(value):
        if value.dtype.hasobject:
            raise _not_a_number()
        return value.shape, value.itemsize
    if kind is int and not -(1 << 63) <= value < 1 << 64:
        raise _not_a_number()
    if kind in (str, bytes, bytearray, memoryview):
        return (), 4 * len(value) if kind is str else len(value)
    if kind in _NUMBERS or kind in (type(None), slice, type(...), type) or kind.__module__ == "numpy.dtypes":
        return (), 16
    raise _not_a_number()


def _of_items(items: Any) -> tuple[Shape, int]:
    kinds = set(map(type, items))
    if kinds <= _NUMBERS:
        if int in kinds:
            for number in (min(items, key=_whole), max(items, key=_whole)):
                extent(_whole(number))
        return (len(items),), 16
    if type(None) in kinds or type in kinds:
        raise _not_a_number()
    shapes: set[Shape] = set()
    width = 1
    for item in items:
        shape, size = extent(item)
        shapes.add(shape)
        width = max(width, size)
    return (len(items), *map(max, zip_longest(*shapes, fillvalue=0))), width


def _whole(number: Any) -> int:
    return number if type(number) is int else 0


def _not_a_number() -> ExpressionError:
    return ExpressionError("arrays can only have numbers, truth values and texts here")


def shape_of(value: Any) -> Shape:
    """Return the shape of a value; see `extent`."""
    return extent(value)[0]


def items(value: Any) -> int:
    """Return the number of items of a value as an array."""
    return math.prod(shape_of(value))


def together(shapes: Iterable[Shape]) -> int:
    """Return the number of items of arrays broadcast together: at most each item of one with each of the others."""
    return math.prod(map(max, zip_longest(*(reversed(shape) for shape in shapes), fillvalue=1)))


def require_together(*values: Any) -> None:
    """Check the result of an operator, or of a Python function that compares or adds items, if it involves arrays.

    Raises:
        ExpressionError: it would be too large, or a value cannot be an item of an array.
    """
    shapes: set[Shape] = set()
    pending = [value for value in values if type(value) not in _SINGLE and getattr(value, "shape", None) != ()]
    if not pending:
        return
    texts = 0
    arrays = False
    while pending:
        value = pending.pop()
        kind = type(value)
        if kind in (list, tuple):
            shapes.add((len(value),))
            if not set(map(type, value)) <= _NUMBERS:
                pending.extend(value)
        elif kind is dict:
            pending.extend(value.values())
        elif isinstance(value, CONTAINERS):
            pending.extend(value)
        elif isinstance(value, Message):
            pending.extend(getattr(value, name) for name in value.__slots__)
        elif is_numpy(value) and value.shape:
            arrays = True
            shapes.add(value.shape)
            texts += value.itemsize if value.dtype.kind in "SU" else 0
    if not arrays:
        if any(map(is_numpy, values)):  # a number of numpy turns a list into an array
            for value in values:
                if type(value) in (list, tuple):
                    extent(value)
        return
    extents = [extent(value) for value in values]
    shapes.update(shape for shape, _ in extents)
    require_size(together(shapes), texts)


def has_array(value: Any) -> bool:
    """Return whether a value is an array, not a number of numpy, or a list or tuple with one."""
    if type(value) in (list, tuple):
        return any(map(has_array, value))
    return is_numpy(value) and bool(value.shape)


def require_size(count: float, width: int = 8) -> None:
    """Check the size of an array before it is made.

    Raises:
        ExpressionError: it would have more than `MAX_ITEMS` items, more than `MAX_BYTES`, or items of more than
            `MAX_WIDTH`.
    """
    if not (count <= MAX_ITEMS and count * width <= MAX_BYTES and width <= MAX_WIDTH):  # NaN fails as well
        require(MAX_ITEMS + 1, MAX_ITEMS)


def check_array(value: Any) -> None:
    """Check a result of numpy.

    Raises:
        ExpressionError: it is too large, contains Python objects, or has more dimensions than are useful.
    """
    extent(value)
    require_size(value.size, value.itemsize)
    if value.ndim > _MAX_DIMENSIONS:
        raise ExpressionError(f"arrays can have at most {_MAX_DIMENSIONS} dimensions here")


def type_width(value: Any) -> int:
    """Return the number of bytes of an item, if an argument is the type of an array; otherwise 0.

    Raises:
        ExpressionError: it is a text that is too long for the name of a type, or a type of Python objects.
    """
    if isinstance(value, (str, bytes)) and len(value) > _MAX_NAME:
        raise ExpressionError(f"arguments of numpy's functions can be texts of at most {_MAX_NAME} characters here")
    if value is None or not isinstance(value, (str, bytes, list, tuple, type)):
        return 0
    import numpy as np  # noqa: PLC0415 - only for expressions with arrays

    try:
        found: np.dtype[Any] = np.dtype(value)  # type: ignore[arg-type]  # most are not types
    except (TypeError, ValueError, SyntaxError):
        return 0
    if found.hasobject:
        raise _not_a_number()
    return max(found.itemsize, _TEXT_BYTES) if found.kind in "SU" else found.itemsize


def require_index(array: Any, key: Any) -> None:
    """Check the size of ``array[key]`` before it is made.

    Raises:
        ExpressionError: it would be too large.
    """
    keys = key if type(key) is tuple else (key,)
    shapes = [None if type(each) is slice or each is None or each is ... else shape_of(each) for each in keys]
    if not any(shapes):
        return  # a view
    lengths = list(array.shape)
    masks = [is_numpy(each) and each.dtype.kind == "b" for each in keys]
    used = [0 if each is None or each is ... else (len(shape or ()) if mask else 1)
            for each, shape, mask in zip(keys, shapes, masks, strict=True)]  # fmt: skip
    count = 1
    for number, (each, shape) in enumerate(zip(keys, shapes, strict=True)):
        taken = len(lengths) - sum(used[number:]) if each is ... else used[number]
        here, lengths = lengths[:taken], lengths[taken:]
        if not shape and shape != ():
            count *= math.prod(here)  # a slice
    chosen = [(math.prod(shape),) if mask else shape for shape, mask in zip(shapes, masks, strict=True) if shape]
    require_size(count * math.prod(lengths) * together(chosen), array.itemsize)


def text_work(*values: Any) -> int:
    """Return the work of writing arrays in values as text, which is slow; numpy writes a few items of large ones."""
    total = 0
    pending = list(values)
    while pending:
        value = pending.pop()
        if type(value) in (list, tuple):
            pending.extend(value)
        elif is_numpy(value):
            total += _TEXT_WORK * min(value.size, _TEXT_ITEMS)
    return total
