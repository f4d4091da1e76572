"""Depth images compressed by compressed_depth_image_transport (https://wiki.ros.org/compressed_depth_image_transport)."""

from __future__ import annotations

import struct

import numpy as np

from pyros1.observe.image_files import MAX_PIXELS, ImageFileError, Pixels, decode

HEAD = struct.Struct("<iff")
"""The header before the PNG file: the format, and two numbers for converting its values."""
_KINDS = ("16UC1", "32FC1")


def decode_depth(form: str, data: bytes, max_pixels: int = MAX_PIXELS) -> Pixels:
    """Return the depths in a message, of shape (height, width).

    Args:
        form: the ``format`` of the sensor_msgs/CompressedImage.
        data: its ``data``.
        max_pixels: an image with more pixels is refused.

    Returns:
        Millimetres as uint16 if the format begins with 16UC1; metres as float32, NaN where there is no depth, if it
        begins with 32FC1.

    Raises:
        ImageFileError: the format is another one, or the data is damaged or not a PNG file.
        Error: Pillow is not installed.
    """
    kind = form.partition(";")[0].strip()
    if "compressedDepth" not in form or kind not in _KINDS or len(data) < HEAD.size:
        raise ImageFileError(f"not a depth image of {' or '.join(_KINDS)}, but an image of the format {form[:200]}")
    if data[HEAD.size :][:4] != b"\x89PNG":
        raise ImageFileError("only PNG is supported for compressed depth images")
    found = decode(data[HEAD.size :], max_pixels)
    if found.ndim != 2:
        raise ImageFileError("compressed depths with colours")
    if kind == _KINDS[0]:
        return found.astype(np.uint16)
    _, one, other = HEAD.unpack_from(data)
    with np.errstate(all="ignore"):
        metres: Pixels = np.where(found > 0, one / (found.astype(np.float32) - other), np.nan).astype(np.float32)
    return metres
