"""Converts images to numpy arrays, and back."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
from cv_bridge.encodings import find_encoding

from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.sensor_msgs.msg import Image
from ros_numpy.registry import converts_from_numpy, converts_to_numpy

__getattr__ = module_getattr(__name__)


@converts_to_numpy(Image)
def image_to_numpy(msg: Any) -> Any:
    """Convert an image to an array of shape (height, width), or (height, width, channels) if there are several.

    Raises:
        TypeError: the encoding is unknown.
    """
    from cv_bridge import CvBridge

    return CvBridge().imgmsg_to_cv2(msg)


@converts_from_numpy(Image)
def numpy_to_image(arr: Any, encoding: str) -> Any:
    """Convert an image to a message.

    Args:
        arr: array of shape (height, width), or (height, width, channels).
        encoding: its encoding.

    Raises:
        TypeError: the encoding is unknown, or the array has the wrong type.
    """
    expected = find_encoding(encoding)
    if expected.dtype != arr.dtype.name or expected.channels != (1 if arr.ndim < 3 else arr.shape[2]):
        raise TypeError(f"Array type {arr.dtype.name} with shape {arr.shape} does not fit the encoding {encoding}")
    data = np.ascontiguousarray(arr)
    is_big_endian = data.dtype.byteorder == ">" or (data.dtype.byteorder == "=" and sys.byteorder == "big")
    height, width = arr.shape[:2]
    return Image(
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=int(is_big_endian),
        step=width * expected.channels * data.itemsize,
        data=data.tobytes(),
    )
