"""The part of numpy that expressions of transform and relay_field can use.

Functions that access files, run code or return results of unlimited size are excluded.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from importlib import import_module
from typing import Any

from pyros1.cli.commands.topic_tools._estimates import (
    CALL_COSTS,
    RANDOM_RESULT_SIZE_FUNCTIONS,
    RESULT_SIZE_FUNCTIONS,
    broadcast_size,
    no_cost,
)
from pyros1.cli.commands.topic_tools._sizes import extent, require_size, type_width
from pyros1.observe.expression_modules import Module

_NUMPY_NAMES = """
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
bitwise_and bitwise_or bitwise_xor delete digitize double expand_dims flatnonzero fliplr flipud isin matmul single uint
vdot
"""
_LINALG_NAMES = ["det", "eigvals", "eigvalsh", "inv", "lstsq", "matrix_rank", "norm", "pinv", "solve"]
_ARRAY_NAMES = """
T all any argmax argmin argsort astype clip conj copy cumprod cumsum diagonal dot dtype flatten imag item max mean min
ndim nonzero prod ptp ravel real reshape round searchsorted shape size squeeze std sum swapaxes tolist tobytes trace
transpose var
"""
ARRAY_MEMBERS = frozenset(_ARRAY_NAMES.split())
"""Members of arrays that expressions can use."""


_MAX_NUMBER_WIDTH = 16
"""Size of the largest number type in bytes."""
_CALL_COST = 100
"""Cost of estimating and calling a function with small arguments."""


def numpy_module() -> Module:
    """Return the part of numpy that expressions can use."""
    numpy: Any = import_module("numpy")
    members = {
        name: getattr(numpy, name) for name in (*_NUMPY_NAMES.split(), *RESULT_SIZE_FUNCTIONS) if hasattr(numpy, name)
    }
    for name, value in members.items():
        if callable(value) and not isinstance(value, type):
            members[name] = CheckedFunction(value, name)
    linalg = Module(
        "numpy.linalg", {name: CheckedFunction(getattr(numpy.linalg, name), name) for name in _LINALG_NAMES}
    )
    random_members = {
        name: CheckedFunction(getattr(numpy.random, name), name, size_function=size_function)
        for name, size_function in RANDOM_RESULT_SIZE_FUNCTIONS.items()
    }
    return Module("numpy", {**members, "linalg": linalg, "random": Module("numpy.random", random_members)})


def array_member(array: Any, name: str) -> Any:
    """Return a member of an array.

    Args:
        array: the array.
        name: the member's name, one of `ARRAY_MEMBERS`.
    """
    value = getattr(array, name)
    return CheckedFunction(value, name, array) if callable(value) else value


class CheckedFunction:
    """A numpy function whose result size and cost are estimated before it is called.

    Args:
        function: the function.
        name: the function's name.
        array: the array if the function is a method of an array.
        size_function: called with the arguments of a call; returns the number of items in the result. If None, the
            entry for `name` in `RESULT_SIZE_FUNCTIONS` is used, or `broadcast_size` if there is no entry.
    """

    def __init__(
        self, function: Callable[..., Any], name: str, *array: Any, size_function: Callable[..., float] | None = None
    ) -> None:
        self._function = function
        self._array = array
        self._name = name
        self._estimate_size = functools.partial(
            size_function or RESULT_SIZE_FUNCTIONS.get(name, broadcast_size), *array
        )
        self._estimate_cost = functools.partial(CALL_COSTS.get(name, no_cost), *array)

    def cost(self, *args: Any, **keywords: Any) -> int:
        """Return the cost of a call itself. The cost of its arguments and result is counted separately.

        Raises:
            ExpressionError: the result would be too large, or an argument is not allowed.
        """
        # The first argument of frombuffer is data, which may be long.
        sized_args = args[1:] if self._name == "frombuffer" else args
        widths = [extent(value)[1] for value in (*self._array, *sized_args, *keywords.values())]
        types = [type_width(value) for value in (*sized_args, *keywords.values())]
        width = max(sum(width for width in widths if width > _MAX_NUMBER_WIDTH), *types, _MAX_NUMBER_WIDTH)
        require_size(self._estimate_size(*args, **keywords), width)
        method_cost = sum(int(array.nbytes) >> 3 for array in self._array)
        return _CALL_COST + int(self._estimate_cost(*args, **keywords)) + method_cost

    def __call__(self, *args: Any, **keywords: Any) -> Any:
        """Call the function.

        Raises:
            TypeError: an argument is malformed.
        """
        try:
            return self._function(*args, **keywords)
        except SyntaxError as error:  # raised for malformed type names
            raise TypeError(str(error)) from None
