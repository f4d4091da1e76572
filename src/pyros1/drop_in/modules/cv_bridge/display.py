"""Converts images in any encoding to colours or grey, for display (https://wiki.ros.org/cv_bridge)."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from cv_bridge.encodings import CvBridgeError, convert, find_encoding

_DISPLAYABLE_AS_BGR = re.compile(r"(8U|8S|16U|16S)C[1-4]\Z|32FC1\Z|32SC1\Z")
"""Encodings without colours that are displayed in BGR by default."""
_CALLER = "cv_bridge.cvtColorForDisplay()"


def cvtColorForDisplay(
    source: Any,
    encoding_in: str,
    encoding_out: str,
    do_dynamic_scaling: bool = False,
    min_image_value: float = 0.0,
    max_image_value: float = 0.0,
) -> Any:
    """Convert an image for display.

    Args:
        source: array of shape (rows, columns), or (rows, columns, channels).
        encoding_in: the encoding of the array.
        encoding_out: "bgr8", "mono8" or another 8-bit colour encoding; "" for "bgr8".
        do_dynamic_scaling: whether to map the minimum to black and the maximum to white; only for one channel.
        min_image_value, max_image_value: without dynamic scaling, the values to map to black and white; if they are
            equal, values are not scaled.

    Returns:
        An array of uint8.

    Raises:
        RuntimeError: the image cannot be converted.
    """
    if not encoding_out:
        if not (_is_color(encoding_in) or _DISPLAYABLE_AS_BGR.match(encoding_in)):
            raise RuntimeError(f"{_CALLER} output encoding is empty and cannot be guessed.")
        encoding_out = "bgr8"
    elif not _is_color(encoding_out) or find_encoding(encoding_out).dtype != "uint8":
        raise RuntimeError(f"{_CALLER} does not have an output encoding that is color or mono, and has is bit in depth")
    if encoding_in == "32SC1" and encoding_out == "bgr8":
        raise RuntimeError(f"{_CALLER}: pyros1 has no colours for the labels of a [32SC1] image")
    try:
        source_encoding = find_encoding(encoding_in)
    except CvBridgeError:
        raise RuntimeError(f"Unknown encoding {encoding_in}") from None
    image = np.asarray(source)
    if do_dynamic_scaling or min_image_value != max_image_value:
        if source_encoding.channels != 1:
            raise RuntimeError(f"{_CALLER} scaling for images with more than one channel is unsupported")
        if do_dynamic_scaling:
            finite = image[~np.isnan(image)] if image.dtype.kind == "f" else image
            min_image_value, max_image_value = (finite.min(), finite.max()) if finite.size else (0.0, 1.0)
            if min_image_value == max_image_value:
                return np.full((*image.shape[:2], 3), 128, np.uint8)
        image, source_encoding = (
            _scale_to_8_bits(image, float(min_image_value), float(max_image_value)),
            find_encoding("mono8"),
        )
    try:
        return convert(image, source_encoding, find_encoding(encoding_out))
    except CvBridgeError as error:
        raise RuntimeError(
            f"{_CALLER} while trying to convert image from '{encoding_in}' to '{encoding_out}' an exception was thrown"
            f" ({error})"
        ) from error


def _is_color(name: str) -> bool:
    try:
        return find_encoding(name).is_color
    except CvBridgeError:
        return False


def _scale_to_8_bits(image: Any, low: float, high: float) -> Any:
    """Return an image with the values from low to high scaled to 0 to 255; NaN becomes 0."""
    with np.errstate(invalid="ignore"):
        values = image.astype(np.float64) - low
        if image.dtype.kind == "u":  # as in stock ROS: OpenCV's unsigned subtraction stops at 0
            values = np.maximum(values, 0.0)
        values *= 255.0 / (high - low)
    values[~np.isfinite(values)] = 0.0
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)
