"""Converts messages with images to JPEG and PNG files (no I/O). Needs Pillow."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError
from pyros1.observe.image_files import encode, import_pillow, to_uint8
from pyros1.topic_tools.image_encoding import decompress, is_deep_grey, to_pixels
from pyros1.web.web_video_server.requests import Rendering

_FLOATS = re.compile(r"(32|64)FC([134]?)\Z")
_COMPRESSED_TYPE = "sensor_msgs/CompressedImage"


def render(message: Any, rendering: Rendering) -> bytes:
    """Return an image as a file.

    Args:
        message: a sensor_msgs/Image or sensor_msgs/CompressedImage.
        rendering: how to convert it.

    Raises:
        MessageError: the image cannot be read, or its encoding is not supported.
        Error: Pillow is not installed.
    """
    pixels = to_8_bits(message, rendering.is_inverted)
    size = (rendering.width or pixels.shape[1], rendering.height or pixels.shape[0])
    if size != (pixels.shape[1], pixels.shape[0]):
        image = import_pillow()
        flat = pixels[:, :, 0] if pixels.shape[2] == 1 else pixels
        pixels = np.asarray(image.fromarray(np.ascontiguousarray(flat)).resize(size, image.Resampling.BILINEAR))
    if rendering.format == "png":
        return encode(pixels, "PNG", compress_level=rendering.quality)
    return encode(pixels, "JPEG", quality=rendering.quality)


def compressed_type(message: Any) -> str:
    """Return the content type of a sensor_msgs/CompressedImage; empty if browsers cannot show it."""
    for name in ("jpeg", "jpg", "png"):
        if name in message.format[:200]:
            return "image/png" if name == "png" else "image/jpeg"
    return ""


def to_8_bits(message: Any, is_inverted: bool = False) -> NDArray[np.uint8]:
    """Return an image's pixels as 8-bit values; depths are scaled so that the farthest is white.

    Args:
        message: a sensor_msgs/Image or sensor_msgs/CompressedImage.
        is_inverted: whether to turn the image by 180 degrees.

    Returns:
        An array of shape (height, width, 1, 3 or 4); colours are RGB or RGBA.

    Raises:
        MessageError: the image cannot be read, or its encoding is not supported.
        Error: Pillow is not installed, and the image is compressed.
    """
    pixels = _to_8_bits(decompress(message) if message._type == _COMPRESSED_TYPE else message)
    return pixels[::-1, ::-1] if is_inverted else pixels


def _to_8_bits(image: Any) -> NDArray[np.uint8]:
    encoding = str(image.encoding)
    if _FLOATS.match(encoding):
        return _scale(_float_pixels(image))
    pixels: NDArray[Any] = to_pixels(image)
    if is_deep_grey(encoding) and not encoding.startswith("mono"):
        return _scale(pixels)
    return pixels if pixels.dtype == np.uint8 else to_uint8(pixels / 257)


def _scale(pixels: NDArray[Any]) -> NDArray[np.uint8]:
    with np.errstate(over="ignore"):
        values = np.nan_to_num(pixels.astype(np.float32), nan=0.0, posinf=0.0, neginf=0.0)
    largest = float(values.max())
    factor = min(255.0 / largest, 1e38) if largest > 0.0 else 1.0  # fits in a float32 even for tiny depths
    return to_uint8(np.clip(values * factor, 0.0, 255.0))


def _float_pixels(image: Any) -> NDArray[Any]:
    match = _FLOATS.match(str(image.encoding))
    assert match is not None
    size, channels = int(match[1]) // 8, int(match[2] or 1)
    row_size = image.width * size * channels
    if not image.width or not image.height:
        raise MessageError("the image has no pixels")
    if image.step < row_size or len(image.data) < image.step * image.height:
        raise MessageError(f"the image has {len(image.data)} bytes, too few for {image.width}x{image.height}")
    rows = np.frombuffer(image.data, np.uint8, image.step * image.height).reshape(image.height, image.step)
    order = ">" if image.is_bigendian else "<"
    values = np.ascontiguousarray(rows[:, :row_size]).view(f"{order}f{size}")
    return values.reshape(image.height, image.width, channels)
