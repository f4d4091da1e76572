"""Moves the pixels of an image to where a map says (no I/O). The maps have 1/32 pixel, like OpenCV's."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
NEAREST, LINEAR = 0, 1
_UNITS = 32
_ROWS = 32
"""Rows that are computed at a time: their numbers stay in the processor's cache."""
_LANE = 21
"""Bits of a channel, when three channels of 8 bits, each multiplied by weights of 10 bits, are in one number."""
_ROUNDING = np.uint64(sum(512 << _LANE * channel for channel in range(3)))


class Remap:
    """A precomputed map from pixels to places in an image. Pixels outside of the image are black.

    Args:
        x, y: the places in pixels, of the same shape (height, width).
        size: height and width of the images that it is for.
        interpolation: `NEAREST` or `LINEAR`.
    """

    def __init__(self, x: Array, y: Array, size: tuple[int, int], interpolation: int = LINEAR) -> None:
        self._size = size
        self._row = size[1] + 2  # with a black pixel on either side
        whole_x, fraction_x = _split(x, size[1], interpolation)
        whole_y, fraction_y = _split(y, size[0], interpolation)
        self._places = (whole_y + 1) * self._row + whole_x + 1
        outside = (whole_x < -1) | (whole_x >= size[1]) | (whole_y < -1) | (whole_y >= size[0])
        self._places[outside] = (size[0] + 1) * self._row  # whose right, lower and lower right neighbours are black
        self._is_linear = interpolation == LINEAR
        self._weights = [
            ((_UNITS - fraction_x) * (_UNITS - fraction_y)),
            (fraction_x * (_UNITS - fraction_y)),
            ((_UNITS - fraction_x) * fraction_y),
            (fraction_x * fraction_y),
        ]
        self._weights_by_type: dict[type, list[Array]] = {}

    def apply(self, pixels: Array) -> Array:
        """Return the image that the map makes of another one.

        Args:
            pixels: an array of shape (height, width) or (height, width, channels), with the size of this map.

        Returns:
            An array with the shape of the map, and as many channels of the same type.
        """
        if pixels.ndim == 2:
            return self._apply_to_channel(pixels)
        if self._is_linear and pixels.dtype == np.uint8 and pixels.shape[2] == 3:
            return self._apply_to_colours(pixels)
        return np.stack([self._apply_to_channel(pixels[..., place]) for place in range(pixels.shape[2])], axis=-1)

    def _apply_to_channel(self, channel: Array) -> Array:
        padded = self._pad(channel.dtype)
        padded[1 : self._size[0] + 1, 1:-1] = channel
        source = padded.ravel()
        if not self._is_linear:
            return source.take(self._places)
        target = np.empty(self._places.shape, channel.dtype)
        if channel.dtype.kind == "f":
            for rows, total in self._blend(source, np.float64, 0.0):
                target[rows] = total / _UNITS**2
        else:
            for rows, total in self._blend(source, np.int64 if channel.itemsize > 2 else np.int32, _UNITS**2 // 2):
                target[rows] = total >> 10
        return target

    def _apply_to_colours(self, pixels: Array) -> Array:
        """Blend three channels of 8 bits at once, side by side in one number of 64 bits."""
        padded = self._pad(np.uint64)
        inner = padded[1 : self._size[0] + 1, 1:-1]
        np.left_shift(pixels[..., 2], np.uint64(2 * _LANE), out=inner, dtype=np.uint64)
        inner |= np.left_shift(pixels[..., 1], np.uint64(_LANE), dtype=np.uint64)
        inner |= pixels[..., 0]
        target = np.empty((*self._places.shape, 3), np.uint8)
        for rows, total in self._blend(padded.ravel(), np.uint64, _ROUNDING):
            for channel in range(3):
                target[rows, :, channel] = total >> np.uint64(_LANE * channel + 10)
        return target

    def _pad(self, dtype: Any) -> Array:
        return np.zeros((self._size[0] + 3, self._row), dtype)

    def _blend(self, source: Array, dtype: type, rounding: Any) -> Iterator[tuple[slice, Array]]:
        """Generate the weighted sums of each pixel's four neighbours, a few rows at a time, plus a number."""
        if dtype not in self._weights_by_type:
            self._weights_by_type[dtype] = [weights.astype(dtype) for weights in self._weights]
        weights = self._weights_by_type[dtype]
        for start in range(0, len(self._places), _ROWS):
            rows = slice(start, start + _ROWS)
            places = self._places[rows].copy()
            total = source.take(places) * weights[0][rows]
            for step, factors in zip((1, self._row - 1, 1), weights[1:], strict=True):
                places += step
                total += source.take(places) * factors[rows]
            total += rounding
            yield rows, total


def _split(positions: Array, size: int, interpolation: int) -> tuple[Array, Array]:
    """Return the whole pixels of positions, and the fractions in 1/32; what is far outside of the image is at -2."""
    units = np.rint(positions * _UNITS)
    units[~((units > -_UNITS) & (units < size * _UNITS))] = -2 * _UNITS
    places = units.astype(np.intp)
    if interpolation == NEAREST:
        places = (places + _UNITS // 2) // _UNITS * _UNITS
    return places >> 5, places & (_UNITS - 1)
