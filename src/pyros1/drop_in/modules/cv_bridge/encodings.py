"""Encodings of images (https://wiki.ros.org/sensor_msgs), their OpenCV types, and conversions between them."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

import numpy as np

_DEPTHS = ("uint8", "int8", "uint16", "int16", "int32", "float32", "float64")
"""numpy's types, indexed by OpenCV's depth number."""
DEPTH_NAMES = dict(zip(_DEPTHS, ("8U", "8S", "16U", "16S", "32S", "32F", "64F"), strict=True))
_GENERIC = re.compile(r"(8U|8S|16U|16S|32S|32F|64F)C([0-9]{1,3})\Z")
_BAYER = re.compile(r"bayer_(rggb|bggr|gbrg|grbg)(8|16)\Z")
_ORDERS = {"rgb": "rgb", "bgr": "bgr", "rgba": "rgba", "bgra": "bgra", "mono": "m"}
_COLOR = re.compile(r"(rgba|bgra|rgb|bgr|mono)(8|16)\Z")
_YUV = {"yuv422": "COLOR_YUV2BGR_UYVY", "yuv422_yuy2": "COLOR_YUV2BGR_YUY2"}
_BAYER_CODES = {"rggb": "BayerBG", "bggr": "BayerRG", "gbrg": "BayerGR", "grbg": "BayerGB"}
_WEIGHTS = {"r": 9798, "g": 19235, "b": 3735}
"""Weights of the colours when converting to grey, in units of 2 ** -15."""


class CvBridgeError(TypeError):
    """An image cannot be converted."""


class Encoding(NamedTuple):
    """An encoding: numpy type, number of channels, order of the colours ("m": grey, "": no colours), and name."""

    dtype: str
    channels: int
    order: str
    name: str

    @property
    def is_color(self) -> bool:
        """Whether the channels are colours; grey counts as a colour."""
        return bool(self.order)


_MAX_CHANNELS = 512
"""OpenCV's limit for the number of channels."""


_ROUNDING_LIMIT = 1 << 31
"""The smallest number that is too large for OpenCV to round."""


def find_encoding(name: str) -> Encoding:
    """Return an encoding; raises CvBridgeError if it does not exist."""
    match = _COLOR.match(name)
    if match:
        order = _ORDERS[match[1]]
        return Encoding("uint8" if match[2] == "8" else "uint16", len(order), order, name)
    match = _BAYER.match(name)
    if match:
        return Encoding("uint8" if match[2] == "8" else "uint16", 1, "bayer", name)
    if name in _YUV:
        return Encoding("uint8", 2, "yuv", name)
    match = _GENERIC.match(name)
    if not match or not 1 <= int(match[2]) <= _MAX_CHANNELS:
        raise CvBridgeError(f"Unrecognized image encoding [{name}]")
    depth = next(depth for depth, short in DEPTH_NAMES.items() if short == match[1])
    return Encoding(depth, int(match[2]), "", name)


def cv_type(depth: str, channels: int) -> int:
    """Return OpenCV's type number for a depth and a number of channels."""
    return _DEPTHS.index(depth) + 8 * (channels - 1)


def getCvType(name: str) -> int:
    """Return OpenCV's type number for an encoding; raises CvBridgeError if there is no such encoding."""
    encoding = find_encoding(name)
    return cv_type(encoding.dtype, encoding.channels)


def depth_of_cv_type(cvtype: int) -> str:
    """Return the name of numpy's type for an OpenCV type number; raises KeyError if its depth is unknown."""
    if not 0 <= cvtype % 8 < len(_DEPTHS):
        raise KeyError(cvtype % 8)
    return _DEPTHS[cvtype % 8]


def convert(image: Any, source: Encoding, target: Encoding) -> Any:
    """Convert an image to another encoding.

    Args:
        image: array of shape (rows, columns), or (rows, columns, channels).
        source: the encoding of the array.
        target: the encoding of the result.

    Raises:
        CvBridgeError: there is no such conversion.
    """
    if source.name == target.name:
        return image.copy()
    if not source.is_color and target.is_color:
        raise CvBridgeError(
            f"[{source.name}] is not a color format. but [{target.name}] is. The conversion does not make sense"
        )
    if not target.is_color:
        if source.channels != target.channels:
            raise CvBridgeError(
                f"[{source.name}] is a color format but [{target.name}] is not so they must have the same OpenCV type,"
                " CV_8UC3, CV16UC1 ...."
                if source.is_color
                else f"[{source.name}] and [{target.name}] do not have the same number of channel"
            )
        return convert_depth(image, target.dtype)
    if source.order in ("bayer", "yuv"):
        image, source = _decode_bayer_or_yuv(image, source, target)
    if target.order in ("bayer", "yuv"):
        raise CvBridgeError(f"Unsupported conversion from [{source.name}] to [{target.name}]")
    return convert_depth(convert_color_order(image, source.order, target.order), target.dtype)


def convert_depth(image: Any, dtype: str) -> Any:
    """Convert an image to another type of numbers, like OpenCV's ``convertTo``.

    8-bit and 16-bit integers represent the same range of intensities, signed or unsigned; other numbers are kept, or
    replaced with the nearest ones. Floats that need more than 32 bits, and NaN, become the minimum.
    """
    if image.dtype == dtype:
        return image.copy()
    if (image.dtype.name, dtype) == ("uint8", "uint16"):
        return image.astype(dtype) * np.uint16(257)
    target = np.dtype(dtype)
    with np.errstate(all="ignore"):
        if target.kind == "f":
            return image.astype(target)
        factor = {(1, 2): 257.0, (2, 1): 1 / 257.0}.get((image.dtype.itemsize, target.itemsize), 1.0)
        values = image
        if factor != 1 or image.dtype.kind == "f":
            values = np.rint(image * np.float64(factor))
            values = np.where(np.abs(values) < _ROUNDING_LIMIT, values, -_ROUNDING_LIMIT)
        limits = np.iinfo(target)
        return np.clip(values, limits.min, limits.max).astype(target)


def convert_color_order(image: Any, source: str, target: str) -> Any:
    """Change the order of an image's colours."""
    if source == target:
        return image
    if target == "m":
        if image.dtype.kind == "f":
            return sum(image[..., source.index(color)] * (weight / (1 << 15)) for color, weight in _WEIGHTS.items())
        total = sum(image[..., source.index(color)].astype(np.int64) * weight for color, weight in _WEIGHTS.items())
        return ((total + (1 << 14)) >> 15).astype(image.dtype)
    max_value = 1 if image.dtype.kind == "f" else np.iinfo(image.dtype).max
    result = np.empty((*image.shape[:2], len(target)), image.dtype)
    for channel, color in enumerate(target):
        if source == "m":
            result[..., channel] = max_value if color == "a" else image
        else:
            result[..., channel] = image[..., source.index(color)] if color in source else max_value
    return result


def _decode_bayer_or_yuv(image: Any, source: Encoding, target: Encoding) -> tuple[Any, Encoding]:
    """Convert an image in a Bayer or YUV format to BGR or grey."""
    grey_channel = {"yuv422": 1, "yuv422_yuy2": 0}.get(source.name)
    if grey_channel is not None and target.order == "m":
        return image[..., grey_channel], find_encoding("mono8")
    try:
        import cv2  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError:
        raise CvBridgeError(
            f"[{source.name}] needs OpenCV for [{target.name}]: pip install opencv-python-headless"
        ) from None
    if source.order == "bayer" and target.order not in ("bgr", "rgb", "m"):
        raise CvBridgeError(f"Unsupported conversion from [{source.name}] to [{target.name}]")
    name = "BGR" if target.order != "m" else "GRAY"
    code = _YUV[source.name] if source.order == "yuv" else f"COLOR_{_BAYER_CODES[source.name[6:10]]}2{name}"
    bits = 8 if source.dtype == "uint8" else 16
    return cv2.cvtColor(image, getattr(cv2, code)), find_encoding(f"{'bgr' if name == 'BGR' else 'mono'}{bits}")
