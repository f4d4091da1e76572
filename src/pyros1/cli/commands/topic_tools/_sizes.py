"""Determines the sizes of arrays and of operator results, and checks that they are small enough."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import zip_longest
from typing import Any

from pyros1.ground.expressions import ExpressionError, check_limit
from pyros1.ground.expressions.limits import CONTAINER_TYPES
from pyros1.msgs import Message
from pyros1.observe.expression import MAX_ITEMS

Shape = tuple[int, ...]

MAX_BYTES = 16 * MAX_ITEMS
"""Maximum size of an array in bytes."""
MAX_WIDTH = 8192
"""Maximum size of an array item in bytes. numpy's conversion buffers contain thousands of items."""
_MAX_DIMENSIONS = 8
_MAX_TYPE_NAME_LENGTH = 32
"""Maximum length of a type name."""
_MAX_NUMBER_STRING_WIDTH = 256
"""Maximum size of a number converted to a string, in bytes."""
_STRING_COST = 100
_MAX_PRINTED_ITEMS = 1000
"""Number of items above which numpy abbreviates an array."""
_NUMBER_TYPES = frozenset({bool, float, int, complex})
_SCALAR_TYPES = _NUMBER_TYPES | {str, bytes, type(None)}


def is_numpy(value: Any) -> bool:
    """Return whether a value is a numpy array or scalar."""
    return type(value).__module__ == "numpy" and hasattr(value, "itemsize")


def extent(value: Any) -> tuple[Shape, int]:
    """Return the shape that a value would have as an array, and the size of an item in bytes.

    If nested lists have different lengths, the length of the longest is used.

    Raises:
        ExpressionError: the array would contain Python objects, whose operations cannot be bounded.
    """
    value_type = type(value)
    if value_type is list or value_type is tuple:
        return _extent_of_items(value)
    if is_numpy(value):
        if value.dtype.hasobject:
            raise _item_type_error()
        return value.shape, value.itemsize
    if value_type is int and not -(1 << 63) <= value < 1 << 64:
        raise _item_type_error()
    if value_type in (str, bytes, bytearray, memoryview):
        return (), 4 * len(value) if value_type is str else len(value)
    if (
        value_type in _NUMBER_TYPES
        or value_type in (type(None), slice, type(...), type)
        or value_type.__module__ == "numpy.dtypes"
    ):
        return (), 16
    raise _item_type_error()


def _extent_of_items(elements: Any) -> tuple[Shape, int]:
    element_types = set(map(type, elements))
    if element_types <= _NUMBER_TYPES:
        if int in element_types:
            for number in (min(elements, key=_int_or_zero), max(elements, key=_int_or_zero)):
                extent(_int_or_zero(number))
        return (len(elements),), 16
    if type(None) in element_types or type in element_types:
        raise _item_type_error()
    shapes: set[Shape] = set()
    width = 1
    for element in elements:
        shape, element_width = extent(element)
        shapes.add(shape)
        width = max(width, element_width)
    return (len(elements), *map(max, zip_longest(*shapes, fillvalue=0))), width


def _int_or_zero(number: Any) -> int:
    return number if type(number) is int else 0


def _item_type_error() -> ExpressionError:
    return ExpressionError("arrays can only contain numbers, booleans and strings here")


def shape_of(value: Any) -> Shape:
    """Return the shape of a value. See `extent`."""
    return extent(value)[0]


def item_count(value: Any) -> int:
    """Return the number of items that a value would have as an array."""
    return math.prod(shape_of(value))


def broadcast_count(shapes: Iterable[Shape]) -> int:
    """Return the number of items that arrays of these shapes have after broadcasting."""
    return math.prod(map(max, zip_longest(*(reversed(shape) for shape in shapes), fillvalue=1)))


def require_broadcast(*values: Any) -> None:
    """Check the result size of an operator or of a Python function that compares or adds items, if arrays are involved.

    Raises:
        ExpressionError: the result would be too large, or a value cannot be an array item.
    """
    shapes: set[Shape] = set()
    pending = [value for value in values if type(value) not in _SCALAR_TYPES and getattr(value, "shape", None) != ()]
    if not pending:
        return
    string_width = 0
    has_arrays = False
    while pending:
        value = pending.pop()
        value_type = type(value)
        if value_type in (list, tuple):
            shapes.add((len(value),))
            if not set(map(type, value)) <= _NUMBER_TYPES:
                pending.extend(value)
        elif value_type is dict:
            pending.extend(value.values())
        elif isinstance(value, CONTAINER_TYPES):
            pending.extend(value)
        elif isinstance(value, Message):
            pending.extend(getattr(value, name) for name in value.__slots__)
        elif is_numpy(value) and value.shape:
            has_arrays = True
            shapes.add(value.shape)
            string_width += value.itemsize if value.dtype.kind in "SU" else 0
    if not has_arrays:
        if any(map(is_numpy, values)):  # a numpy number turns a list into an array
            for value in values:
                if type(value) in (list, tuple):
                    extent(value)
        return
    extents = [extent(value) for value in values]
    shapes.update(shape for shape, _ in extents)
    require_size(broadcast_count(shapes), string_width)


def has_array(value: Any) -> bool:
    """Return whether a value is an array (not a numpy number) or a list or tuple that contains one."""
    if type(value) in (list, tuple):
        return any(map(has_array, value))
    return is_numpy(value) and bool(value.shape)


def require_size(count: float, width: int = 8) -> None:
    """Check the size of an array before it is created.

    Raises:
        ExpressionError: the array would have more than `MAX_ITEMS` items, more than `MAX_BYTES`, or items wider than
            `MAX_WIDTH`.
    """
    if not (count <= MAX_ITEMS and count * width <= MAX_BYTES and width <= MAX_WIDTH):  # also True for NaN
        check_limit(MAX_ITEMS + 1, MAX_ITEMS)


def check_array(value: Any) -> None:
    """Check an array returned by numpy.

    Raises:
        ExpressionError: the array is too large, contains Python objects, or has too many dimensions.
    """
    extent(value)
    require_size(value.size, value.itemsize)
    if value.ndim > _MAX_DIMENSIONS:
        raise ExpressionError(f"arrays can have at most {_MAX_DIMENSIONS} dimensions here")


def type_width(value: Any) -> int:
    """Return the item size in bytes that an argument such as ``float32`` selects; 0 if the argument is not a type.

    Raises:
        ExpressionError: the argument is a string that is too long for a type name, or it is a type of Python objects.
    """
    if isinstance(value, (str, bytes)) and len(value) > _MAX_TYPE_NAME_LENGTH:
        raise ExpressionError(
            f"string arguments of numpy functions can have at most {_MAX_TYPE_NAME_LENGTH} characters here"
        )
    if value is None or not isinstance(value, (str, bytes, list, tuple, type)):
        return 0
    import numpy as np  # noqa: PLC0415 - only needed for expressions with arrays

    try:
        dtype: np.dtype[Any] = np.dtype(value)  # type: ignore[arg-type]  # most arguments are not types
    except (TypeError, ValueError, SyntaxError):
        return 0
    if dtype.hasobject:
        raise _item_type_error()
    return max(dtype.itemsize, _MAX_NUMBER_STRING_WIDTH) if dtype.kind in "SU" else dtype.itemsize


def require_index(array: Any, key: Any) -> None:
    """Check the size of ``array[key]`` before it is created.

    Raises:
        ExpressionError: the result would be too large.
    """
    keys = key if type(key) is tuple else (key,)
    shapes = [None if type(part) is slice or part is None or part is ... else shape_of(part) for part in keys]
    if not any(shapes):
        return  # the result is a view
    remaining_lengths = list(array.shape)
    masks = [is_numpy(part) and part.dtype.kind == "b" for part in keys]
    dimensions = [0 if part is None or part is ... else (len(shape or ()) if mask else 1)
            for part, shape, mask in zip(keys, shapes, masks, strict=True)]  # fmt: skip
    count = 1
    for position, (part, shape) in enumerate(zip(keys, shapes, strict=True)):
        indexed_count = len(remaining_lengths) - sum(dimensions[position:]) if part is ... else dimensions[position]
        indexed_lengths, remaining_lengths = remaining_lengths[:indexed_count], remaining_lengths[indexed_count:]
        if not shape and shape != ():
            count *= math.prod(indexed_lengths)  # a slice
    index_shapes = [(math.prod(shape),) if mask else shape for shape, mask in zip(shapes, masks, strict=True) if shape]
    require_size(count * math.prod(remaining_lengths) * broadcast_count(index_shapes), array.itemsize)


def string_cost(*values: Any) -> int:
    """Return the cost of converting the arrays in some values to strings. numpy abbreviates large arrays."""
    total = 0
    pending = list(values)
    while pending:
        value = pending.pop()
        if type(value) in (list, tuple):
            pending.extend(value)
        elif is_numpy(value):
            total += _STRING_COST * min(value.size, _MAX_PRINTED_ITEMS)
    return total
