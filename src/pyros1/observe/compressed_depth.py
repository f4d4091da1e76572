"""Depth images compressed by compressed_depth_image_transport (https://wiki.ros.org/compressed_depth_image_transport)."""

from __future__ import annotations

import struct

import numpy as np

from pyros1.observe.image_files import MAX_PIXELS, ImageFileError, Pixels, decode

DEPTH_HEADER = struct.Struct("<iff")
"""The header before the PNG file: the format, and two numbers for the conversion of values."""
_ENCODINGS = ("16UC1", "32FC1")


def decode_depth(format_text: str, data: bytes, max_pixels: int = MAX_PIXELS) -> Pixels:
    """Return the depths in a message as an array of shape (height, width).

    Args:
        format_text: the ``format`` of the sensor_msgs/CompressedImage message.
        data: the ``data`` of the message.
        max_pixels: the maximum number of pixels.

    Returns:
        Millimetres as uint16 if the format begins with 16UC1; metres as float32, with NaN for unknown depths, if it
        begins with 32FC1.

    Raises:
        ImageFileError: the format is not supported, or the data is damaged or not a PNG file.
        Error: Pillow is not installed.
    """
    encoding = format_text.partition(";")[0].strip()
    if "compressedDepth" not in format_text or encoding not in _ENCODINGS or len(data) < DEPTH_HEADER.size:
        raise ImageFileError(
            f"not a depth image of {' or '.join(_ENCODINGS)}, but an image of the format {format_text[:200]}"
        )
    if data[DEPTH_HEADER.size :][:4] != b"\x89PNG":
        raise ImageFileError("only PNG is supported for compressed depth images")
    pixels = decode(data[DEPTH_HEADER.size :], max_pixels)
    if pixels.ndim != 2:
        raise ImageFileError("the compressed depth image has colours")
    if encoding == _ENCODINGS[0]:
        return pixels.astype(np.uint16)
    _, numerator, offset = DEPTH_HEADER.unpack_from(data)
    with np.errstate(all="ignore"):
        metres: Pixels = np.where(pixels > 0, numerator / (pixels.astype(np.float32) - offset), np.nan).astype(
            np.float32
        )
    return metres
