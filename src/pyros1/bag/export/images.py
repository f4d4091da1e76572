"""Converts sensor_msgs/Image messages, in any ROS 1 encoding, to arrays of pixels."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError

Pixels = NDArray[Any]

_NAMED_ENCODINGS = {
    "mono8": ("u1", 1, ""),
    "mono16": ("u2", 1, ""),
    "rgb8": ("u1", 3, "rgb"),
    "bgr8": ("u1", 3, "bgr"),
    "rgba8": ("u1", 4, "rgb"),
    "bgra8": ("u1", 4, "bgr"),
    "rgb16": ("u2", 3, "rgb"),
    "bgr16": ("u2", 3, "bgr"),
    "rgba16": ("u2", 4, "rgb"),
    "bgra16": ("u2", 4, "bgr"),
}
"""Encoding -> (dtype, number of channels, order of the colours)."""
_YUV_POSITIONS = {"yuv422": (1, 0, 2), "uyvy": (1, 0, 2), "yuv422_yuy2": (0, 1, 3), "yuyv": (0, 1, 3)}
"""Encoding -> positions of the first Y, of U and of V in the four bytes of two pixels."""

_GENERIC_ENCODING_PATTERN = re.compile(r"(8|16|32|64)([USF])C\(?([1-4])?\)?\Z")
_BAYER_ENCODING_PATTERN = re.compile(r"bayer_(rggb|bggr|gbrg|grbg)(8|16)\Z")


def pixels(message: Any, *, mosaic: bool = False) -> Pixels:
    """Return an image's pixels.

    Args:
        message: a sensor_msgs/Image.
        mosaic: whether to leave Bayer images unchanged instead of computing colours.

    Returns:
        An array of shape (height, width) with the raw numbers, or (height, width, 3 or 4) with red, green, blue and
        alpha.

    Raises:
        MessageError: the encoding is unknown, or the message is shorter than its size says.
    """
    encoding = str(message.encoding)
    bayer = _BAYER_ENCODING_PATTERN.match(encoding)
    if encoding in _YUV_POSITIONS:
        return _from_yuv(_pixel_rows(message, "u1", 2), *_YUV_POSITIONS[encoding])
    if bayer:
        raw = _pixel_rows(message, f"u{int(bayer[2]) // 8}", 1)[:, :, 0]
        return raw if mosaic else _demosaic(raw, bayer[1])
    dtype_name, channels, order = _parse_encoding(encoding)
    image = _pixel_rows(message, dtype_name, channels)
    if channels == 1:
        return image[:, :, 0]
    return image[:, :, [2, 1, 0, 3][:channels]] if order == "bgr" else image


def to_8_bits(image: Pixels) -> Pixels:
    """Return an image with 8 bits per channel, for display; its shape is unchanged.

    16-bit colours keep only their upper byte; other images are scaled from their minimum to their maximum.
    """
    if image.dtype == np.uint8:
        return image
    if image.dtype == np.uint16 and image.ndim == 3:
        return (image >> 8).astype(np.uint8)
    finite = np.isfinite(image)
    low, high = (float(image[finite].min()), float(image[finite].max())) if finite.any() else (0.0, 0.0)
    with np.errstate(all="ignore"):  # the difference between the largest numbers overflows
        scaled = np.zeros(image.shape) if high <= low else (np.where(finite, image, low) - low) * (255.0 / (high - low))
        return np.rint(scaled).astype(np.uint8)


def _parse_encoding(encoding: str) -> tuple[str, int, str]:
    """Return an encoding's dtype, number of channels and order of the colours; raises MessageError if it is unknown."""
    if encoding in _NAMED_ENCODINGS:
        return _NAMED_ENCODINGS[encoding]
    match = _GENERIC_ENCODING_PATTERN.match(encoding)
    if match is None or (match[2] == "F" and match[1] not in ("32", "64")) or (match[2] != "F" and match[1] == "64"):
        raise MessageError(f"images with the encoding {encoding!r} are not supported")
    channels = int(match[3] or 1)
    # These are OpenCV's encodings, in which blue comes first.
    return f"{match[2].lower().replace('s', 'i')}{int(match[1]) // 8}", channels, "bgr" if channels > 2 else ""


def _pixel_rows(message: Any, dtype_name: str, channels: int) -> Pixels:
    """Return a message's pixels without the padding at the end of rows; raises MessageError if any are missing."""
    height, width, step = int(message.height), int(message.width), int(message.step)
    dtype = np.dtype(f"{'>' if message.is_bigendian else '<'}{dtype_name}")
    row_size = width * channels * dtype.itemsize
    if not height or not width:
        raise MessageError(f"the image is empty: {width} x {height} pixels")
    if step < row_size:
        raise MessageError(
            f"the image's step is {step}, but rows of {width} pixels in {message.encoding} take {row_size} bytes"
        )
    data = np.frombuffer(message.data, dtype=np.uint8)
    size = step * (height - 1) + row_size
    if len(data) < size:
        raise MessageError(
            f"the image has {len(data)} bytes, but {width} x {height} pixels in {message.encoding} take {size}"
        )
    rows = np.lib.stride_tricks.as_strided(data, (height, row_size), (step, 1), writeable=False)
    image = np.ascontiguousarray(rows).view(dtype).reshape(height, width, channels)
    native: Pixels = image.astype(dtype.newbyteorder("="), copy=False)
    return native


def _from_yuv(pixel_pairs: Pixels, y_position: int, u_position: int, v_position: int) -> Pixels:
    height, width, _ = pixel_pairs.shape
    if width % 2:
        raise MessageError(f"the width of a YUV image must be even, not {width}")
    quads = pixel_pairs.reshape(height, width // 2, 4).astype(np.float32)
    y = quads[:, :, [y_position, y_position + 2]].reshape(height, width)
    u = np.repeat(quads[:, :, u_position], 2, axis=1) - 128
    v = np.repeat(quads[:, :, v_position], 2, axis=1) - 128
    y = (y - 16) * 1.164
    colours = np.stack([y + 1.596 * v, y - 0.391 * u - 0.813 * v, y + 2.018 * u], axis=2)
    image: Pixels = np.rint(colours.clip(0, 255)).astype(np.uint8)
    return image


def _demosaic(raw: Pixels, pattern: str) -> Pixels:
    """Return the colours of a Bayer image: each colour that a pixel lacks is a mean over neighbours that have it."""
    height, width = raw.shape
    colours = np.empty((height, width, 3), raw.dtype)
    for channel, channel_colour in enumerate("rgb"):
        mask = np.zeros((height, width), np.float32)
        for position, colour in enumerate(pattern):
            if colour == channel_colour:
                mask[position // 2 :: 2, position % 2 :: 2] = 1
        weight = _weighted_sum(mask)
        mean = _weighted_sum(np.where(mask > 0, raw, 0).astype(np.float32)) / np.where(weight > 0, weight, 1)
        colours[:, :, channel] = np.where(mask > 0, raw, np.rint(mean))
    return colours


def _weighted_sum(values: Pixels) -> Pixels:
    """Return each number plus half the sum of its direct neighbours and a quarter of the sum of its diagonal ones."""
    padded = np.pad(values, 1)
    rows = padded[1:-1] + (padded[:-2] + padded[2:]) / 2
    total: Pixels = rows[:, 1:-1] + (rows[:, :-2] + rows[:, 2:]) / 2
    return total
