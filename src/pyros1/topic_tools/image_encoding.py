"""Converts images to JPEG or PNG and back: sensor_msgs/Image and sensor_msgs/CompressedImage.

The ``format`` of compressed images is described at https://wiki.ros.org/compressed_image_transport. Needs Pillow.
"""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.observe.image_files import Pixels, decode, encode

_COLOURS = re.compile(r"(rgb|bgr|rgba|bgra)(8|16)\Z")
_SINGLE_CHANNEL_OR_RAW = re.compile(r"(?:mono|bayer_(?:rggb|bggr|gbrg|grbg))(8|16)\Z|(8|16)UC([134]?)\Z")
COMPRESSED_FORMATS = ("jpeg", "png")


def compress(image: Any, format: str = "jpeg", quality: int = 80, level: int = 9) -> Any:
    """Return an image as a sensor_msgs/CompressedImage.

    Args:
        image: a sensor_msgs/Image with 8 or 16 bits per channel.
        format: "jpeg", which has 8 bits and no alpha channel, or "png", which is lossless. Colours with 16 bits are
            converted to 8 bits for JPEG. Depths and other images with a single 16-bit channel are not supported by
            JPEG.
        quality: the JPEG quality from 1 to 100.
        level: the PNG compression level from 0 to 9.

    Raises:
        MessageError: the encoding is not supported, or the data is shorter than the image's size requires.
        Error: Pillow is not installed.
    """
    encoding = str(image.encoding)
    pixels = to_pixels(image)
    bits, channels = 8 * pixels.itemsize, pixels.shape[2]
    if format == "png":
        data = encode(pixels, "PNG", compress_level=level)
    elif format == "jpeg" and (bits == 8 or _COLOURS.match(encoding)):
        data = encode(pixels if bits == 8 else np.rint(pixels / 257).astype(np.uint8), "JPEG", quality=quality)
    else:
        raise MessageError(f"an image with the encoding {encoding} cannot be converted to {format!r:.20}")
    inner_encoding = f"bgr{bits if format == 'png' else 8}" if channels > 1 else ""
    return CompressedImage(image.header, f"{encoding}; {format} compressed {inner_encoding}", data)


def to_pixels(image: Any) -> Pixels:
    """Return the pixels of a sensor_msgs/Image.

    Returns:
        An array of shape (height, width, 1, 3 or 4) and type uint8 or uint16; colours begin with red.

    Raises:
        MessageError: the encoding is not supported, or the data is shorter than the image's size requires.
    """
    encoding = str(image.encoding)
    layout = _layout(encoding)
    if layout is None:
        raise MessageError(
            f"images with the encoding {encoding!r:.40} cannot be compressed: only 8 and 16 bits are supported"
        )
    bits, channels, is_blue_first = layout
    pixels = _to_pixels(image, bits, channels)
    return _swap_red_and_blue(pixels) if is_blue_first else pixels


def is_deep_grey(encoding: str) -> bool:
    """Return whether images of an encoding have 16 bits and no colours, so that `compress` only supports PNG."""
    layout = _layout(encoding)
    return layout is not None and layout[0] == 16 and not _COLOURS.match(encoding)


def decompress(message: Any) -> Any:
    """Return a sensor_msgs/CompressedImage as a sensor_msgs/Image with the original encoding.

    If the format does not contain the encoding, or the file's channels or depth differ from it, the encoding is mono,
    bgr or bgra with the file's depth.

    Raises:
        MessageError: the image cannot be read, or the encoding is not supported.
        Error: Pillow is not installed.
    """
    encoding, separator, _ = str(message.format).partition(";")
    encoding = encoding.strip()
    layout = _layout(encoding)
    if separator and layout is None:
        raise MessageError(
            f"images with the encoding {encoding!r:.40} cannot be decompressed: only 8 and 16 bits are supported"
        )
    pixels = decode(bytes(message.data))
    if pixels.dtype not in (np.uint8, np.uint16):
        raise MessageError(f"the image has values of the type {pixels.dtype}, not of 8 or 16 bits")
    bits, channels = 8 * pixels.itemsize, 1 if pixels.ndim == 2 else pixels.shape[2]
    if layout is not None and layout[1:2] == (4,) and channels == 3:  # JPEG and other formats drop the alpha channel
        pixels = np.dstack([pixels, np.full(pixels.shape[:2], np.iinfo(pixels.dtype).max, pixels.dtype)])
        channels = 4
    if layout is None or layout[:2] != (bits, channels):
        encoding = {1: "mono", 3: "bgr", 4: "bgra"}[channels] + str(bits)
        layout = _layout(encoding)
    if layout is not None and layout[2]:
        pixels = _swap_red_and_blue(pixels)
    height, width = pixels.shape[:2]
    data = np.ascontiguousarray(pixels).astype(pixels.dtype.newbyteorder("<")).tobytes()
    return Image(message.header, height, width, encoding, 0, len(data) // height, data)


def _layout(encoding: str) -> tuple[int, int, bool] | None:
    """Return an encoding's bits per channel, number of channels, and whether blue comes first; None if unsupported."""
    match = _COLOURS.match(encoding)
    if match:
        return int(match[2]), len(match[1]), match[1].startswith("b")
    match = _SINGLE_CHANNEL_OR_RAW.match(encoding)
    if match:
        channels = int(match[3] or 1)
        return int(match[1] or match[2]), channels, channels > 1  # OpenCV's colours begin with blue
    return None


def _to_pixels(image: Any, bits: int, channels: int) -> Pixels:
    size = channels * bits // 8
    if image.step < image.width * size or len(image.data) < image.step * image.height:
        raise MessageError(f"the image has {len(image.data)} bytes, too few for {image.width}x{image.height}")
    if not image.width or not image.height:
        raise MessageError("the image has no pixels")
    rows = np.frombuffer(image.data, np.uint8, image.step * image.height).reshape(image.height, image.step)
    pixels = np.ascontiguousarray(rows[:, : image.width * size])
    if bits == 16:
        return (
            pixels.view(">u2" if image.is_bigendian else "<u2")
            .astype(np.uint16)
            .reshape(image.height, image.width, channels)
        )
    return pixels.reshape(image.height, image.width, channels)


def _swap_red_and_blue(pixels: Pixels) -> Pixels:
    return pixels[:, :, [2, 1, 0, 3][: pixels.shape[2]]]
