"""Lengths and unit vectors; see `pyros1.tf.transformations`."""

from __future__ import annotations

from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def float_array(values: ArrayLike, max_values: int | None = None) -> Array:
    """Return ``values``, or the first ``max_values`` of them, as an array of floats; it may share their memory."""
    return np.asarray(values, np.float64)[:max_values]


def vector_norm(data: ArrayLike, axis: int | None = None, out: NDArray[Any] | None = None) -> Any:
    """Return the length of a vector, or of each vector along an axis.

    Args:
        data: numbers, of any shape.
        axis: axis along which the vectors lie; None if all numbers are one vector.
        out: the array for the result; None for a new one.

    Returns:
        A float for data of shape (n,); otherwise an array of data's shape without the axis, or of shape (1,) if
        ``axis`` is None; None if ``out`` is given.
    """
    data = np.asarray(data, np.float64)
    if out is not None:
        np.sqrt(np.sum(data * data, axis, out=out), out)
        return None
    if data.ndim == 1:
        return float(np.sqrt(data @ data))
    return np.atleast_1d(np.sqrt(np.sum(data * data, axis)))


@overload
def unit_vector(data: ArrayLike, axis: int | None = None, out: None = None) -> Array: ...
@overload
def unit_vector(data: ArrayLike, axis: int | None = None, *, out: NDArray[Any]) -> None: ...
def unit_vector(data: ArrayLike, axis: int | None = None, out: NDArray[Any] | None = None) -> Array | None:
    """Return the unit vector in the direction of a vector, or of each vector along an axis.

    Args:
        data: numbers, of any shape.
        axis: axis along which the vectors lie; None if all numbers are one vector.
        out: the array for the result, of data's shape; None for a new one.

    Returns:
        An array of data's shape; None if ``out`` is given.
    """
    data = np.asarray(data, np.float64)
    length = np.sqrt(data @ data) if data.ndim == 1 else np.sqrt(np.sum(data * data, axis, keepdims=True))
    result: Array = np.divide(data, length, out)
    return result if out is None else None


def random_vector(size: int | tuple[int, ...]) -> Array:
    """Return an array of random numbers from 0 to 1, of a given size or shape; `numpy.random.seed` sets the seed."""
    return np.random.random(size)
