"""Depth images compressed by compressed_depth_image_transport (https://wiki.ros.org/compressed_depth_image_transport)."""

from __future__ import annotations

import struct

import numpy as np

from pyros1.ground.errors import MessageError
from pyros1.observe.image_files import MAX_PIXELS, ImageFileError, Pixels, decode, encode
from pyros1.observe.rvl import decode_rvl, encode_rvl

DEPTH_HEADER = struct.Struct("<iff")
"""The header before the compressed image: the format, and two numbers for the conversion of values."""
DEPTH_FORMATS = ("png", "rvl")
_SIZE = struct.Struct("<II")
"""The header of RVL data: the number of columns and of rows."""
_MAX_RVL_PIXELS = 1 << 24
"""Maximum number of pixels of RVL data: a few bytes may stand for any number of zeros."""
_ENCODINGS = ("16UC1", "32FC1", "mono16")


def decode_depth(format_text: str, data: bytes, max_pixels: int = MAX_PIXELS) -> Pixels:
    """Return the depths in a message as an array of shape (height, width).

    Args:
        format_text: the ``format`` of the sensor_msgs/CompressedImage message.
        data: the ``data`` of the message.
        max_pixels: the maximum number of pixels.

    Returns:
        Millimetres as uint16 if the format begins with 16UC1 or mono16; metres as float32, with NaN for unknown depths,
        if it begins with 32FC1.

    Raises:
        ImageFileError: the format is not supported, or the data is damaged.
        Error: Pillow is not installed.
    """
    encoding = format_text.partition(";")[0].strip()
    if "compressedDepth" not in format_text or encoding not in _ENCODINGS or len(data) < DEPTH_HEADER.size:
        raise ImageFileError(
            f"not a depth image of {' or '.join(_ENCODINGS)}, but an image of the format {format_text[:200]}"
        )
    if "compressedDepth rvl" in format_text:
        pixels = _decode_rvl(data[DEPTH_HEADER.size :], min(max_pixels, _MAX_RVL_PIXELS))
    elif data[DEPTH_HEADER.size :][:4] == b"\x89PNG":
        pixels = decode(data[DEPTH_HEADER.size :], max_pixels)
    else:
        raise ImageFileError("only PNG and RVL are supported for compressed depth images")
    if pixels.ndim != 2:
        raise ImageFileError("the compressed depth image has colours")
    if encoding != "32FC1":
        return pixels.astype(np.uint16)
    _, numerator, offset = DEPTH_HEADER.unpack_from(data)
    with np.errstate(all="ignore"):
        metres: Pixels = np.where(pixels > 0, numerator / (pixels.astype(np.float32) - offset), np.nan).astype(
            np.float32
        )
    return metres


def _decode_rvl(data: bytes, max_pixels: int) -> Pixels:
    width, height = _SIZE.unpack_from(data) if len(data) >= _SIZE.size else (0, 0)
    if not 0 < width * height <= max_pixels:
        raise ImageFileError(f"a compressed depth image of {width}x{height} pixels, of at most {max_pixels}")
    try:
        return decode_rvl(data[_SIZE.size :], width * height).reshape(height, width)
    except MessageError as error:
        raise ImageFileError(str(error)) from None


def encode_depth(depths: Pixels, format: str, depth_max: float, depth_quantization: float, png_level: int) -> bytes:
    """Return the ``data`` of a message with a compressed depth image.

    Args:
        depths: millimetres as uint16 or metres as float32, of shape (height, width).
        format: one of `DEPTH_FORMATS`.
        depth_max: the depth in metres beyond which depths are unknown.
        depth_quantization: the depth in metres at which the resolution of float depths is 1 m.
        png_level: the PNG compression level from 0 to 9.

    Raises:
        Error: the format is PNG, and Pillow is not installed.
    """
    numerator = offset = 0.0
    if depths.dtype == np.uint16:
        values = np.where(depths > min(depth_max * 1000.0, 65535.0), 0, depths).astype(np.uint16)
    else:
        numerator = depth_quantization * (depth_quantization + 1.0)
        offset = 1.0 - numerator / depth_max
        with np.errstate(all="ignore"):
            inverse = np.where((depths > 0.0) & (depths < depth_max), numerator / depths + offset, 0.0)
        values = np.clip(np.nan_to_num(inverse), 0.0, 65535.0).astype(np.uint16)
    header = DEPTH_HEADER.pack(0, numerator, offset)
    if format == "rvl":
        return header + _SIZE.pack(depths.shape[1], depths.shape[0]) + encode_rvl(values)
    return header + encode(values, "PNG", compress_level=png_level)
