"""Remaps the pixels of an image (no I/O). Maps have a resolution of 1/32 pixel, like OpenCV's."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]
NEAREST, LINEAR = 0, 1
_UNITS = 32
_BLOCK = 40_000
"""Pixels that are computed at a time, in whole rows, so that they stay in the processor's cache."""

# Three channels of 8 bits, each multiplied by weights of 10 bits, are blended at once in a number of 64 bits, which is
# little-endian on all machines. The channels begin at bits 0, 22 and 46. The lower 10 bits of each sum are fractions,
# so the results of the second and third channel are whole bytes; that of the first is one after multiplying by 64.
_PACKED = np.dtype("<u8")
_SHIFT = np.uint64(64)
_SECOND_TO_SHIFT, _THIRD_TO_SHIFT = 2, 5
_FIRST_SHIFTED, _SECOND, _THIRD = 2, 4, 7
_ROUNDING = np.uint64(_UNITS**2 // 2 * (1 + 2**22 + 2**46))


class Remap:
    """A precomputed map from pixels to positions in an image. Pixels outside the image are black.

    Args:
        x, y: the positions in pixels, of the same shape (height, width).
        size: height and width of the images to which it is applied.
        interpolation: `NEAREST` or `LINEAR`.
    """

    def __init__(self, x: Array, y: Array, size: tuple[int, int], interpolation: int = LINEAR) -> None:
        self._size = size
        self._row = size[1] + 2  # with a black pixel on either side
        whole_x, fraction_x = _split(x, size[1], interpolation)
        whole_y, fraction_y = _split(y, size[0], interpolation)
        self._places = (whole_y + 1) * self._row + whole_x + 1
        outside = (whole_x < -1) | (whole_x >= size[1]) | (whole_y < -1) | (whole_y >= size[0])
        self._places[outside] = (size[0] + 1) * self._row  # a pixel whose neighbours are also black
        self._is_linear = interpolation == LINEAR
        # Small types: converting them each time takes no longer than fetching larger numbers from memory.
        self._weights = [
            ((_UNITS - fraction_x) * (_UNITS - fraction_y)).astype(np.uint16),
            (fraction_x * (_UNITS - fraction_y)).astype(np.uint16),
            ((_UNITS - fraction_x) * fraction_y).astype(np.uint16),
            (fraction_x * fraction_y).astype(np.uint16),
        ]

    def apply(self, pixels: Array) -> Array:
        """Return an image remapped.

        Args:
            pixels: an array of shape (height, width) or (height, width, channels), with the ``size`` passed to the
                constructor.

        Returns:
            An array with the shape of the map, and the same number and type of channels.
        """
        if pixels.ndim == 2:
            return self._apply_to_channel(pixels)
        if self._is_linear and pixels.dtype == np.uint8 and pixels.shape[2] == 3:
            return self._apply_to_colours(pixels)
        return np.stack([self._apply_to_channel(pixels[..., place]) for place in range(pixels.shape[2])], axis=-1)

    def _apply_to_channel(self, channel: Array) -> Array:
        dtype = channel.dtype
        if self._is_linear:
            dtype = np.dtype(np.float64 if dtype.kind == "f" else np.int64 if dtype.itemsize > 2 else np.int32)
        padded = self._pad(dtype)
        padded[1 : self._size[0] + 1, 1:-1] = channel
        if not self._is_linear:
            return padded.ravel().take(self._places)
        target = np.empty(self._places.shape, channel.dtype)
        if channel.dtype.kind == "f":
            for rows, total in self._blend(padded, 0.0):
                target[rows] = total / _UNITS**2
        else:
            for rows, total in self._blend(padded, _UNITS**2 // 2):
                target[rows] = total >> 10
        return target

    def _apply_to_colours(self, pixels: Array) -> Array:
        """Blend three channels of 8 bits at once; see `_PACKED`."""
        padded = self._pad(_PACKED)
        inner, inner_bytes = padded[1 : self._size[0] + 1, 1:-1], _bytes(padded)[1 : self._size[0] + 1, 1:-1]
        part = np.zeros((_rows(pixels), self._size[1]), _PACKED)
        for rows in _blocks(pixels):
            of_pixels = pixels[rows]
            shifted = part[: len(of_pixels)]
            _bytes(shifted)[..., _SECOND_TO_SHIFT] = of_pixels[..., 1]
            _bytes(shifted)[..., _THIRD_TO_SHIFT] = of_pixels[..., 2]
            np.multiply(shifted, _SHIFT, out=inner[rows])
            inner_bytes[rows, :, 0] = of_pixels[..., 0]
        target = np.empty((*self._places.shape, 3), np.uint8)
        for rows, total in self._blend(padded, _ROUNDING):
            target[rows, :, 1] = _bytes(total)[..., _SECOND]
            target[rows, :, 2] = _bytes(total)[..., _THIRD]
            np.multiply(total, _SHIFT, out=total)
            target[rows, :, 0] = _bytes(total)[..., _FIRST_SHIFTED]
        return target

    def _pad(self, dtype: Any) -> Array:
        return np.zeros((self._size[0] + 3, self._row), dtype)

    def _blend(self, padded: Array, rounding: Any) -> Iterator[tuple[slice, Array]]:
        """Generate the weighted sums of each pixel's four neighbours, plus a rounding term: a few rows at a time, in an
        array that is reused.
        """
        first, *others = self._weights
        source = padded.ravel()
        neighbours = source[1:], source[self._row :], source[self._row + 1 :]
        sums, terms = (np.empty((_rows(self._places), self._places.shape[1]), padded.dtype) for _ in range(2))
        for rows in _blocks(self._places):
            places = self._places[rows]
            total, term = sums[: len(places)], terms[: len(places)]
            # All indices are valid; this mode is the fastest way to skip the check.
            source.take(places, out=total, mode="wrap")
            total *= first[rows]
            for neighbour, weights in zip(neighbours, others, strict=True):
                neighbour.take(places, out=term, mode="wrap")
                term *= weights[rows]
                total += term
            total += rounding
            yield rows, total


def _rows(image: Array) -> int:
    """Return the number of rows of an image that are computed at a time."""
    return min(max(1, _BLOCK // int(image.shape[1])), len(image))


def _blocks(image: Array) -> Iterator[slice]:
    """Generate the rows of an image, block by block."""
    rows = _rows(image)
    return (slice(start, start + rows) for start in range(0, len(image), rows))


def _bytes(numbers: Array) -> Array:
    """Return the bytes of an array of 64-bit numbers of shape (..., columns), as a view of shape (..., columns, 8)."""
    return numbers.view(np.uint8).reshape(*numbers.shape, 8)


def _split(positions: Array, size: int, interpolation: int) -> tuple[Array, Array]:
    """Split positions into whole pixels and fractions in 1/32 pixel; positions far outside the image become -2."""
    units = np.rint(positions * _UNITS)
    units[~((units > -_UNITS) & (units < size * _UNITS))] = -2 * _UNITS
    places = units.astype(np.intp)
    if interpolation == NEAREST:
        places = (places + _UNITS // 2) // _UNITS * _UNITS
    return places >> 5, places & (_UNITS - 1)
