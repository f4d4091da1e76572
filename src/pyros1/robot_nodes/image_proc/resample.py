"""Resizes images (no I/O), with the same results as OpenCV's resize up to rounding."""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
NEAREST, LINEAR, CUBIC, AREA, LANCZOS = range(5)
METHODS = {"NN": NEAREST, "Linear": LINEAR, "Cubic": CUBIC, "Lanczos4": LANCZOS}
"""Name of a method in dynamic_reconfigure -> the method used. Cubic and Lanczos4 are computed as Linear."""


def resize(
    pixels: Array, height: int, width: int, method: int = LINEAR, steps: tuple[float, float] | None = None
) -> Array:
    """Return an image resized.

    Args:
        pixels: an array of shape (height, width) or (height, width, channels).
        height, width: the new size, at least 1.
        method: `NEAREST`; `AREA`, the mean of the pixels that become one, if the image shrinks by whole factors;
            anything else is `LINEAR`.
        steps: how many of the image's rows and columns correspond to one new one; None to use the exact ratio of the
            sizes. Pass the inverses of the scale factors if the new size was computed from them and rounded.
    """
    rows, columns = pixels.shape[:2]
    if (rows, columns) == (height, width):
        return pixels
    step_y, step_x = steps or (rows / height, columns / width)
    if method == NEAREST:
        chosen: Array = pixels.take(_nearest(rows, height, step_y), axis=0)
        chosen = chosen.take(_nearest(columns, width, step_x), axis=1)
        return chosen
    if method == AREA and rows % height == 0 and columns % width == 0:
        blocks = pixels.reshape(height, rows // height, width, columns // width, *pixels.shape[2:])
        return _round(blocks.mean(axis=(1, 3), dtype=np.float32), pixels.dtype)
    row, row_weight = _neighbours(rows, height, step_y)
    column, column_weight = _neighbours(columns, width, step_x)
    more = (1,) * (pixels.ndim - 2)
    across = column_weight.reshape(1, -1, *more)
    # Rows first, since they are contiguous, and only the needed ones.
    down = row_weight.reshape(-1, 1, *more)
    wide = pixels[row] * (1 - down) + pixels[np.minimum(row + 1, rows - 1)] * down
    narrow = wide[:, column] * (1 - across) + wide[:, np.minimum(column + 1, columns - 1)] * across
    return _round(narrow, pixels.dtype)


def decimate(pixels: Array, factor_y: int, factor_x: int, method: int) -> Array:
    """Return an image shrunk by whole factors; remaining pixels at the end are dropped."""
    height, width = pixels.shape[0] // factor_y, pixels.shape[1] // factor_x
    pixels = pixels[: height * factor_y, : width * factor_x] if method == AREA else pixels
    if method == NEAREST:
        return pixels[: height * factor_y : factor_y, : width * factor_x : factor_x]
    return resize(pixels, height, width, method)


def _nearest(size: int, new_size: int, step: float) -> Array:
    places: Array = np.minimum(np.arange(new_size) * step, size - 1).astype(np.intp)
    return places


def _neighbours(size: int, new_size: int, step: float) -> tuple[Array, Array]:
    """Return, for each new pixel, the first of the two pixels between which it lies, and the weight of the second."""
    positions = np.clip((np.arange(new_size) + 0.5) * step - 0.5, 0, size - 1)
    first = positions.astype(np.intp)
    return first, (positions - first).astype(np.float32)


def _round(values: Array, dtype: Any) -> Array:
    if dtype.kind == "f":
        return values.astype(dtype)
    return np.rint(values).astype(dtype)
