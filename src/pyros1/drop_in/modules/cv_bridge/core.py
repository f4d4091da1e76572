"""Converts images between messages and arrays."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np

from cv_bridge import compressed
from cv_bridge.encodings import DEPTH_NAMES, CvBridgeError, convert, cv_type, depth_of_cv_type, find_encoding
from pyros1.drop_in.module_attributes import module_getattr
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image

__getattr__ = module_getattr(__name__)


class CvBridge:
    """Converts images.

    Attributes:
        cvtype_to_name: OpenCV's type number -> the type's name.
        cvdepth_to_numpy_depth: OpenCV's depth number -> the name of numpy's type.
        numpy_type_to_cvtype: numpy's type -> short name of OpenCV's depth, and vice versa.
    """

    def __init__(self) -> None:
        self.cvdepth_to_numpy_depth = dict(enumerate(DEPTH_NAMES))
        self.cvtype_to_name = {
            cv_type(depth, count): f"{short}C{count}" for depth, short in DEPTH_NAMES.items() for count in (1, 2, 3, 4)
        }
        self.numpy_type_to_cvtype = {**DEPTH_NAMES, **{short: depth for depth, short in DEPTH_NAMES.items()}}

    def dtype_with_channels_to_cvtype2(self, dtype: Any, n_channels: int) -> str:
        """Return the name of the OpenCV type for a numpy type and a number of channels."""
        return f"{self.numpy_type_to_cvtype[dtype.name]}C{n_channels}"

    def cvtype2_to_dtype_with_channels(self, cvtype: int) -> tuple[str, int]:
        """Return the name of numpy's type, and the number of channels, for an OpenCV type number."""
        return depth_of_cv_type(cvtype), cvtype // 8 % 64 + 1

    def encoding_to_cvtype2(self, encoding: str) -> int:
        """Return OpenCV's type number for an encoding; raises CvBridgeError if there is no such encoding."""
        encoding_info = find_encoding(encoding)
        return cv_type(encoding_info.dtype, encoding_info.channels)

    def encoding_to_dtype_with_channels(self, encoding: str) -> tuple[str, int]:
        """Return the name of numpy's type, and the number of channels, for an encoding; raises CvBridgeError if
        unknown.
        """
        encoding_info = find_encoding(encoding)
        return encoding_info.dtype, encoding_info.channels

    def imgmsg_to_cv2(self, img_msg: Any, desired_encoding: str = "passthrough") -> Any:
        """Convert a message to an array.

        Args:
            img_msg: a sensor_msgs/Image.
            desired_encoding: the encoding of the array; "passthrough" for the message's encoding.

        Returns:
            Array of shape (height, width), or (height, width, channels) if there are several. Without conversion, it
            refers to the message's data and is read-only.

        Raises:
            CvBridgeError: the encoding is unknown, the data are too short, or there is no such conversion.
        """
        source = find_encoding(img_msg.encoding)
        dtype = np.dtype(source.dtype).newbyteorder(">" if img_msg.is_bigendian else "<")
        shape = (img_msg.height, img_msg.width, source.channels)[: 3 if source.channels > 1 else 2]
        inner_strides = (source.channels * dtype.itemsize, dtype.itemsize)[: len(shape) - 1]
        step = img_msg.step or inner_strides[0] * img_msg.width
        data = bytes(img_msg.data) if isinstance(img_msg.data, (list, tuple)) else memoryview(img_msg.data)
        size = memoryview(data).nbytes
        required_size = (
            step * (img_msg.height - 1) + inner_strides[0] * img_msg.width if img_msg.height and img_msg.width else 0
        )
        # numpy does not check the size of empty buffers.
        if step < inner_strides[0] * img_msg.width or size < required_size:
            rows = f"{img_msg.height} rows of {step} bytes"
            raise CvBridgeError(f"the {size} bytes of the image do not fit its size: {rows}")
        image: Any = (
            np.ndarray(shape, dtype, data, strides=(step, *inner_strides)) if required_size else np.zeros(shape, dtype)
        )
        if dtype != np.dtype(source.dtype):
            image = image.astype(source.dtype)
        if desired_encoding == "passthrough":
            return image
        return convert(image, source, find_encoding(desired_encoding))

    def cv2_to_imgmsg(self, cvim: Any, encoding: str = "passthrough", header: Any = None) -> Image:
        """Convert an array to a message.

        Args:
            cvim: array of shape (height, width), or (height, width, channels).
            encoding: the encoding of the array; "passthrough" for the OpenCV name of its type.
            header: the header; None for an empty one.

        Raises:
            TypeError: ``cvim`` is not an array.
            CvBridgeError: the array does not have the type of the encoding.
        """
        if not isinstance(cvim, np.ndarray):
            raise TypeError("Your input type is not a numpy array")
        channels = 1 if cvim.ndim < 3 else cvim.shape[2]
        name = f"{DEPTH_NAMES.get(cvim.dtype.name, '?')}C{channels}"
        if encoding != "passthrough":
            if (cvim.dtype.name, channels) != self.encoding_to_dtype_with_channels(encoding):
                raise CvBridgeError(f"encoding specified as {encoding}, but image has incompatible type {name}")
            name = encoding
        elif "?" in name:
            raise CvBridgeError(f"there is no encoding for numbers of the type {cvim.dtype.name}")
        data = cvim.tobytes()
        is_big_endian = cvim.dtype.byteorder == ">" or (cvim.dtype.byteorder == "=" and sys.byteorder == "big")
        message = Image(
            height=cvim.shape[0],
            width=cvim.shape[1],
            encoding=name,
            is_bigendian=int(is_big_endian),
            step=len(data) // (cvim.shape[0] or 1),
            data=data,
        )
        if header is not None:
            message.header = header
        return message

    def compressed_imgmsg_to_cv2(self, cmprs_img_msg: Any, desired_encoding: str = "passthrough") -> Any:
        """Convert a sensor_msgs/CompressedImage to an array; colours are in the order BGR.

        Args:
            cmprs_img_msg: the message.
            desired_encoding: the encoding of the array. For "passthrough" and, as in stock ROS, "bgr8", the array keeps
            the file's channels and depth; other 8-bit colour encodings keep the depth as well.

        Returns:
            The array; None, as in stock ROS, if the data cannot be read and the order of channels would not change.

        Raises:
            CvBridgeError: there are no data, they cannot be converted, or only OpenCV can read such files and it is not
            installed.
        """
        image = compressed.decode(bytes(cmprs_img_msg.data))
        if desired_encoding in ("passthrough", "bgr8", ""):
            return image
        target = find_encoding(desired_encoding)
        if image is None and target.channels == 3 and target.order in ("bgr", ""):
            return None  # stock checks the image only if it converts it
        if image is None:
            raise CvBridgeError(f"the data of the compressed image cannot be read as {desired_encoding}")
        return compressed.convert(image, target)

    def cv2_to_compressed_imgmsg(self, cvim: Any, dst_format: str = "jpg") -> CompressedImage:
        """Convert an array to a sensor_msgs/CompressedImage.

        Args:
            cvim: array of shape (height, width), or (height, width, channels) in the order BGR.
            dst_format: "jpg", "png" or another format supported by OpenCV or Pillow. Pixel values that the format
                cannot represent are clipped to 0-255.

        Raises:
            TypeError: ``cvim`` is not an array.
            CvBridgeError: the image cannot be written in that format.
        """
        if not isinstance(cvim, np.ndarray):
            raise TypeError("Your input type is not a numpy array")
        return CompressedImage(format=dst_format, data=compressed.encode(cvim, dst_format))
