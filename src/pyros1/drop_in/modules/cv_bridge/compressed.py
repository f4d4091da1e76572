"""Converts compressed images to arrays in BGR order, and back, with OpenCV as in stock ROS, or else with Pillow."""

from __future__ import annotations

from typing import Any

import numpy as np

from cv_bridge import encodings
from cv_bridge.encodings import CvBridgeError, Encoding
from pyros1.ground.errors import Error
from pyros1.observe import image_files

_OPTIONS: dict[str, dict[str, Any]] = {
    **{key: {"quality": 95} for key in ("jpg", "jpeg", "jpe")},
    "png": {"compress_level": 1},
    "webp": {"lossless": True},
}
"""Format -> Pillow's options for writing files as OpenCV does by default."""
_OPENCV_HINT = ", or install OpenCV: pip install opencv-python-headless"


def decode(data: bytes) -> Any:
    """Decode the image in a file, with its depth and channels; return None if it cannot be read.

    Raises:
        CvBridgeError: the data are empty, Pillow does not support the format, or neither Pillow nor OpenCV is
            installed.
    """
    if not data:
        raise CvBridgeError("the compressed image has no data")
    cv2 = _import_cv2()
    if cv2 is not None:
        return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED)
    try:
        return _swap_red_and_blue(image_files.decode(data))
    except image_files.UnsupportedFileError as error:
        raise CvBridgeError(f"{error}{_OPENCV_HINT}") from None
    except image_files.ImageFileError:
        return None
    except Error as error:
        raise CvBridgeError(str(error)) from None


def encode(image: Any, file_format: str) -> bytes:
    """Encode an image as a file; raise CvBridgeError if it cannot be written in that format."""
    cv2 = _import_cv2()
    if cv2 is not None:
        try:
            succeeded, data = cv2.imencode("." + file_format, image)
        except cv2.error as error:
            raise CvBridgeError(str(error)) from error
        if not succeeded:
            raise CvBridgeError(f"the image cannot be written as {file_format}")
        return bytes(data.tobytes())
    image = np.asarray(image)
    try:
        return image_files.encode(
            _swap_red_and_blue(image if image.ndim > 1 else image[:, None]),
            file_format,
            **_OPTIONS.get(file_format.lower(), {}),
        )
    except image_files.UnsupportedFileError as error:
        raise CvBridgeError(f"{error}{_OPENCV_HINT}") from None
    except Error as error:
        raise CvBridgeError(str(error)) from None


def convert(image: Any, target: Encoding) -> Any:
    """Convert an image that was read from a file to an encoding other than "bgr8".

    As in stock ROS, the file is assumed to be "bgr8", whatever its depth and channels are. There are two differences: a
    16-bit image keeps its values in 16-bit encodings, while in stock ROS the values overflow; and a grey image may
    remain grey.

    Raises:
        CvBridgeError: there is no such conversion.
    """
    channels = 1 if image.ndim < 3 else image.shape[2]
    order = {1: "m", 3: "bgr", 4: "bgra"}[channels]
    source = Encoding(image.dtype.name, channels if channels == target.channels else 3, order, "bgr8")
    if not target.is_color or target.order in ("bayer", "yuv"):
        return encodings.convert(image, source, target)
    if target.name == "bgr16":
        return encodings.convert_depth(image, "uint16")
    result = encodings.convert_color_order(image, order, target.order)
    return result if target.dtype == "uint8" else encodings.convert_depth(result, target.dtype)


def _swap_red_and_blue(image: Any) -> Any:
    """Swap red and blue in an image, if it has colours."""
    if image.ndim < 3 or image.shape[2] not in (3, 4):
        return image
    return np.ascontiguousarray(image[:, :, [2, 1, 0, 3][: image.shape[2]]])


def _import_cv2() -> Any:
    try:
        import cv2  # type: ignore[import-not-found, import-untyped, unused-ignore]
    except ImportError:
        return None
    return cv2
