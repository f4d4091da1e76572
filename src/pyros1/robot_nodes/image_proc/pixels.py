"""Converts sensor_msgs/Image to and from numpy arrays (no I/O); encodings as in https://wiki.ros.org/cv_bridge."""

from __future__ import annotations

import re
import sys
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyros1.ground.errors import Error
from pyros1.msgs.sensor_msgs.msg import Image

_COLOURS = re.compile(r"(rgb|bgr|rgba|bgra)(8|16)\Z")
_SINGLE = re.compile(r"(mono|bayer_(?:rggb|bggr|gbrg|grbg))(8|16)\Z")
_PLAIN = re.compile(r"(8|16|32|64)([USF])C([1-9]?)\Z")
_YUV = ("yuv422", "yuv422_yuy2")
_KINDS = {"U": "u", "S": "i", "F": "f"}


class ImageError(Error):
    """An image cannot be processed."""


@dataclass(frozen=True)
class Encoding:
    """The pixel format of an image.

    Attributes:
        name: the encoding, such as "bgr8" or "bayer_rggb16".
        dtype: the type of a channel, in the machine's byte order.
        channels: the number of channels of a pixel.
    """

    name: str
    dtype: np.dtype[Any]
    channels: int

    @property
    def bayer(self) -> str:
        """The pattern of a Bayer encoding, such as "rggb", or an empty string."""
        return self.name[6:10] if self.name.startswith("bayer_") else ""

    @property
    def is_mono(self) -> bool:
        """Whether it has one channel for brightness; 8UC1 and 16UC1 count as such."""
        return self.name.startswith("mono") or self.name in ("8UC1", "16UC1")

    @property
    def is_colour(self) -> bool:
        """Whether it has red, green and blue."""
        return _COLOURS.match(self.name) is not None

    @property
    def is_yuv(self) -> bool:
        """Whether neighbouring pixels share their colour (UYVY or YUY2); each pixel has two bytes."""
        return self.name in _YUV


def parse_encoding(name: str) -> Encoding:
    """Return the pixel format that an encoding names.

    Raises:
        ImageError: the encoding is unknown.
    """
    if match := _COLOURS.match(name):
        return Encoding(name, np.dtype(f"u{int(match[2]) // 8}"), len(match[1]))
    if match := _SINGLE.match(name):
        return Encoding(name, np.dtype(f"u{int(match[2]) // 8}"), 1)
    if name in _YUV:
        return Encoding(name, np.dtype("u1"), 2)
    if (match := _PLAIN.match(name)) and f"{match[1]}{match[2]}" not in ("8F", "16F", "64U", "64S", "32U"):
        return Encoding(name, np.dtype(f"{_KINDS[match[2]]}{int(match[1]) // 8}"), int(match[3] or 1))
    raise ImageError(f"images with the encoding {name!r:.40} are not supported")


def to_array(image: Any) -> np.ndarray[Any, Any]:
    """Return the pixels of a sensor_msgs/Image.

    Returns:
        An array of shape (height, width), or (height, width, channels) if there are several, in the machine's byte
        order. It may be a read-only view of the image's data.

    Raises:
        ImageError: the encoding is unknown, or the data does not have the size that the image claims.
    """
    encoding = parse_encoding(image.encoding)
    size = encoding.dtype.itemsize
    row = image.width * encoding.channels * size
    if not image.width or not image.height:
        raise ImageError("the image has no pixels")
    if image.step < row or len(image.data) < image.step * image.height:
        raise ImageError(
            f"the image has {len(image.data)} bytes, too few for {image.width} x {image.height} pixels of "
            f"{image.encoding} in rows of {image.step} bytes"
        )
    data = np.frombuffer(image.data, np.uint8, image.step * image.height)
    rows = data.reshape(image.height, image.step)[:, :row]
    if size > 1:
        rows = np.ascontiguousarray(rows)  # numpy before 1.23 needs this to view another type
    swapped = size > 1 and bool(image.is_bigendian) != (sys.byteorder == "big")
    pixels = rows.view(encoding.dtype.newbyteorder() if swapped else encoding.dtype)
    if swapped:
        pixels = pixels.astype(encoding.dtype)
    return pixels if encoding.channels == 1 else pixels.reshape(image.height, image.width, encoding.channels)


def to_image(header: Any, pixels: np.ndarray[Any, Any], encoding: str) -> Any:
    """Return a sensor_msgs/Image.

    Args:
        header: the image's header.
        pixels: an array of shape (height, width) or (height, width, channels) in the machine's byte order.
        encoding: the image's encoding, which must fit the array.
    """
    height, width = pixels.shape[:2]
    return Image(
        header=header,
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=int(sys.byteorder == "big"),
        step=pixels.nbytes // height,
        data=pixels.tobytes(),
    )
