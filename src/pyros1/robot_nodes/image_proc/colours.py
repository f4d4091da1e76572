"""Converts images with Bayer patterns or YUV to colour, and images to grey (no I/O).

The results are the same as OpenCV's, which stock uses, except that greys from Bayer patterns may differ by 2.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from pyros1.robot_nodes.image_proc.pixels import Encoding, ImageError, parse_encoding

Array = np.ndarray[Any, Any]
_RED, _GREEN, _BLUE = 9798, 19235, 3735
"""The weights of the colours in grey (ITU-R BT.601), in units of 2^-15."""


def to_bgr(pixels: Array, encoding: Encoding) -> tuple[Array, str]:
    """Convert an image with a Bayer pattern or YUV to colour.

    Args:
        pixels: (height, width), or (height, width, 2) for YUV.
        encoding: the encoding of the pixels.

    Returns:
        The colours of shape (height, width, 3), and "bgr8" or "bgr16".

    Raises:
        ImageError: the image is too small.
    """
    if encoding.is_yuv:
        return _yuv_to_bgr(pixels, encoding), "bgr8"
    return demosaic(pixels, encoding.bayer), f"bgr{8 * encoding.dtype.itemsize}"


def to_mono(pixels: Array, encoding: Encoding) -> tuple[Array, str]:
    """Convert an image to grey.

    Args:
        pixels: an image in colour, with a Bayer pattern or YUV.
        encoding: the encoding of the pixels.

    Returns:
        The greys of shape (height, width), and "mono8" or "mono16".

    Raises:
        ImageError: the image is too small, or has another encoding.
    """
    if encoding.is_yuv:
        return np.ascontiguousarray(pixels[..., _first_y(encoding)]), "mono8"
    if encoding.bayer:
        pixels, name = to_bgr(pixels, encoding)
        encoding = parse_encoding(name)
    if not encoding.is_colour:
        raise ImageError(f"images with the encoding {encoding.name} cannot be converted to grey")
    red, blue = (0, 2) if encoding.name.startswith("rgb") else (2, 0)
    grey = np.multiply(pixels[..., 1], _GREEN, dtype=np.uint32)
    grey += np.multiply(pixels[..., red], _RED, dtype=np.uint32)
    grey += np.multiply(pixels[..., blue], _BLUE, dtype=np.uint32)
    grey += 1 << 14
    grey >>= 15
    return grey.astype(encoding.dtype), f"mono{8 * encoding.dtype.itemsize}"


def demosaic(raw: Array, pattern: str) -> Array:
    """Convert an image with a Bayer pattern to colour, by bilinear interpolation.

    Args:
        raw: brightnesses of shape (height, width), at least (3, 3), as uint8 or uint16.
        pattern: the colours of the first two pixels of the first and second row: "rggb", "bggr", "gbrg" or "grbg".

    Returns:
        Blue, green and red of shape (height, width, 3) and the same type. Pixels at the border are copies of their
        neighbours, as in OpenCV.

    Raises:
        ImageError: the image is too small.
    """
    height, width = raw.shape
    if height < 3 or width < 3:
        raise ImageError(f"an image with a Bayer pattern must have 3 x 3 pixels or more, not {width} x {height}")
    bgr = np.empty((height, width, 3), raw.dtype)
    # Each mean is computed for all pixels, although only some use it, since adding neighbours in memory is fast.
    wide = raw.astype(np.uint16 if raw.dtype == np.uint8 else np.uint32)
    sides = wide[:, :-2] + wide[:, 2:]
    beside, above = sides[1:-1], wide[:-2, 1:-1] + wide[2:, 1:-1]
    around, diagonal = _mean(beside + above, 4), _mean(sides[:-2] + sides[2:], 4)
    beside, above = _mean(beside, 2), _mean(above, 2)
    inner = raw[1:-1, 1:-1]
    for row in (0, 1):
        for column in (0, 1):
            colour = pattern[(1 + row) % 2 * 2 + (1 + column) % 2]
            if colour == "g":  # the left neighbour has one of the other two colours, the upper one has the other
                side = pattern[(1 + row) % 2 * 2 + column % 2]
                sources = {"g": inner, side: beside, _opposite(side): above}
            else:
                sources = {colour: inner, "g": around, _opposite(colour): diagonal}
            for name, source in sources.items():
                bgr[1 + row : -1 : 2, 1 + column : -1 : 2, "bgr".index(name)] = source[row::2, column::2]
    bgr[:, 0], bgr[:, -1] = bgr[:, 1], bgr[:, -2]
    bgr[0], bgr[-1] = bgr[1], bgr[-2]
    return bgr


def _mean(sums: Array, count: int) -> Array:
    """Replace sums of 2 or 4 numbers with their means, rounding halves up."""
    sums += count // 2
    sums >>= count // 2
    return sums


def _opposite(colour: str) -> str:
    return "r" if colour == "b" else "b"


def halve_bayer(raw: Array, pattern: str) -> Array:
    """Convert an image with a Bayer pattern to colour at half the size: each block of 2 x 2 pixels becomes one pixel.

    Args:
        raw: (height, width); an odd last row or column is left out.
        pattern: see `demosaic`.

    Returns:
        Blue, green and red of shape (height // 2, width // 2, 3).
    """
    height, width = raw.shape[0] // 2 * 2, raw.shape[1] // 2 * 2
    quarters = {
        place: raw[place // 2 : height : 2, place % 2 : width : 2].astype(np.uint32) for place in range(len(pattern))
    }
    greens = [quarters[place] for place in range(4) if pattern[place] == "g"]
    channels = [quarters[pattern.index("b")], (greens[0] + greens[1]) // 2, quarters[pattern.index("r")]]
    return np.stack(channels, axis=-1).astype(raw.dtype)


def _first_y(encoding: Encoding) -> int:
    return 1 if encoding.name == "yuv422" else 0  # UYVY or YUY2


def _yuv_to_bgr(pixels: Array, encoding: Encoding) -> Array:
    y_place = _first_y(encoding)
    height, width = pixels.shape[0], pixels.shape[1] // 2 * 2
    if not width:
        raise ImageError("an image with YUV must have two columns or more")
    y = (pixels[:, :width, y_place].astype(np.float32) - 16.0) * 1.164
    chroma = pixels[:, :width, 1 - y_place].astype(np.float32) - 128.0
    u, v = (np.repeat(chroma[:, start::2], 2, axis=1) for start in (0, 1))
    bgr = np.empty((height, width, 3), np.float32)
    bgr[..., 0] = y + 2.018 * u
    bgr[..., 1] = y - 0.391 * u - 0.813 * v
    bgr[..., 2] = y + 1.596 * v
    return np.clip(np.rint(bgr), 0, 255).astype(np.uint8)
