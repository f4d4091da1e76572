"""Images as JPEG or PNG, and back: sensor_msgs/Image and sensor_msgs/CompressedImage.

The ``format`` of compressed images is that of https://wiki.ros.org/compressed_image_transport. Needs Pillow.
"""

from __future__ import annotations

import io
from importlib import import_module
from typing import Any

from pyros1.ground.errors import Error, MessageError
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image

_KINDS = {
    "rgb8": ("RGB", "RGB", 3),
    "bgr8": ("RGB", "BGR", 3),
    "8UC3": ("RGB", "BGR", 3),
    "rgba8": ("RGBA", "RGBA", 4),
    "bgra8": ("RGBA", "BGRA", 4),
    "mono8": ("L", "L", 1),
    "8UC1": ("L", "L", 1),
    "mono16": ("I;16", "I;16", 2),
    "16UC1": ("I;16", "I;16", 2),
}
"""Encoding -> Pillow's mode, how the bytes lie in the message, and bytes per pixel."""
FORMATS = ("jpeg", "png")


def _pillow() -> Any:
    try:
        return import_module("PIL.Image")
    except ImportError as error:
        raise Error(f"compressed images need Pillow ({error}): pip install 'pyros1[images]'") from None


def _kind(encoding: str) -> tuple[str, str, int]:
    if encoding not in _KINDS:
        raise MessageError(f"images with the encoding {encoding!r:.40} cannot be compressed: only {', '.join(_KINDS)}")
    return _KINDS[encoding]


def compress(image: Any, format: str = "jpeg", quality: int = 80, level: int = 9) -> Any:
    """Return an image as a sensor_msgs/CompressedImage.

    Args:
        image: a sensor_msgs/Image.
        format: "jpeg", which has 8 bits and no opacity, or "png", which loses nothing.
        quality: of JPEG, from 1 to 100.
        level: of PNG's compression, from 0 to 9.

    Raises:
        MessageError: the encoding is not supported, or the message is shorter than its size says.
        Error: Pillow is not installed.
    """
    mode, raw, size = _kind(image.encoding)
    if image.step < image.width * size or len(image.data) < image.step * image.height:
        raise MessageError(f"the image has {len(image.data)} bytes, too few for {image.width}x{image.height}")
    if not image.width or not image.height:
        raise MessageError("the image has no pixels")
    if size == 2 and image.is_bigendian:
        raw = "I;16B"
    picture = _pillow().frombytes(mode, (image.width, image.height), bytes(image.data), "raw", raw, image.step, 1)
    file = io.BytesIO()
    if format == "png":
        picture.save(file, "PNG", compress_level=level)
    elif format == "jpeg" and size != 2:
        (picture.convert("RGB") if mode == "RGBA" else picture).save(file, "JPEG", quality=quality)
    else:
        raise MessageError(f"an image with the encoding {image.encoding} cannot become {format!r:.20}")
    inside = "bgr8" if size > 2 else ""
    return CompressedImage(image.header, f"{image.encoding}; {format} compressed {inside}", file.getvalue())


def decompress(message: Any) -> Any:
    """Return a sensor_msgs/CompressedImage as a sensor_msgs/Image, in the encoding that it had.

    Raises:
        MessageError: it cannot be read, or the encoding is not supported.
        Error: Pillow is not installed.
    """
    pillow = _pillow()
    encoding, found, _ = str(message.format).partition(";")
    try:
        with pillow.open(io.BytesIO(message.data), formats=[each.upper() for each in FORMATS]) as picture:
            if not found:  # an older publisher, or one that is not of ROS
                encoding = "mono8" if picture.mode == "L" else "bgr8"
            mode, raw, size = _kind(encoding)
            if size != 2:
                picture = picture.convert(mode)  # noqa: PLW2901
            elif not picture.mode.startswith("I"):
                raise MessageError(f"the picture has not the 16 bits of {encoding}")
            width, height = picture.size
            data = picture.convert("I").convert("I;16").tobytes() if size == 2 else picture.tobytes("raw", raw)
    except (OSError, ValueError, SyntaxError, pillow.DecompressionBombError) as error:
        raise MessageError(f"the picture cannot be read: {error}") from None
    return Image(message.header, height, width, encoding, 0, width * size, data)
