"""The image transports: how images are sent on topics (https://wiki.ros.org/image_transport).

``raw`` is the topic itself; every other transport has a topic TOPIC/TRANSPORT. ``compressed`` sends JPEG or PNG files,
``compressedDepth`` sends depths as PNG or RVL, and ``theora`` videos can only be received.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.observe.compressed_depth import DEPTH_FORMATS, decode_depth, encode_depth
from pyros1.observe.image_files import Pixels
from pyros1.reconfigure import Parameters
from pyros1.topic_tools.image_encoding import COMPRESSED_FORMATS, compress, decompress
from pyros1.topic_tools.theora import TheoraDecoder, packet_class


@dataclass(frozen=True)
class ImageTransport:
    """A transport.

    Attributes:
        message_class: returns the class of its messages.
        make_decoder: returns a function that decodes a message to a sensor_msgs/Image, or None if there is none yet.
        encode: encodes an image, given the configuration; None if the transport can only be received.
        parameters: returns the parameters of the configuration; None if there is no configuration.
        is_video: whether messages depend on earlier ones, so that all must be decoded.
    """

    message_class: Callable[[], Any]
    make_decoder: Callable[[], Callable[[Any], Any]]
    encode: Callable[[Any, Any], Any] | None = None
    parameters: Callable[[], Parameters] | None = None
    is_video: bool = False


def transport_topic(topic: str, transport: str) -> str:
    """Return the topic of a transport."""
    return topic if transport == "raw" else f"{topic}/{transport}"


def compress_depth(
    image: Any, format: str = "png", depth_max: float = 10.0, quantization: float = 100.0, level: int = 1
) -> Any:
    """Return a depth image as a sensor_msgs/CompressedImage, as compressed_depth_image_transport sends it.

    Args:
        image: a sensor_msgs/Image in millimetres (16UC1, mono16) or metres (32FC1).
        format: "png" or "rvl".
        depth_max: the depth in metres beyond which depths are unknown.
        quantization: the depth in metres at which the resolution of float depths is 1 m.
        level: how hard to try to make a PNG small, 1 to 9.

    Raises:
        MessageError: the image has no depths, or is damaged.
        Error: the format is PNG, and Pillow is not installed.
    """
    encoding = str(image.encoding)
    if encoding not in ("16UC1", "mono16", "32FC1"):
        raise MessageError(f"only depths (16UC1, 32FC1) can be sent as compressedDepth, not {encoding!r:.40}")
    data = encode_depth(_depths(image, 4 if encoding == "32FC1" else 2), format, depth_max, quantization, level)
    return CompressedImage(image.header, f"{encoding}; compressedDepth {format}", data)


def _depths(image: Any, size: int) -> Pixels:
    """Return the depths of an image, in this machine's byte order; ``size`` is the number of bytes per pixel."""
    if not image.width or not image.height:
        raise MessageError("the image has no pixels")
    if image.step < image.width * size or len(image.data) < image.step * image.height:
        raise MessageError(f"the image has {len(image.data)} bytes, too few for {image.width}x{image.height}")
    rows = np.frombuffer(image.data, np.uint8, image.step * image.height).reshape(image.height, image.step)
    name = f"{'>' if image.is_bigendian else '<'}{'f' if size == 4 else 'u'}{size}"
    depths = np.ascontiguousarray(rows[:, : image.width * size]).view(name)
    return depths.astype(depths.dtype.newbyteorder("="))


def decompress_depth(message: Any) -> Any:
    """Return the sensor_msgs/Image of a message from compressed_depth_image_transport.

    Raises:
        MessageError: the format is not supported, or the data is damaged.
        Error: Pillow is not installed.
    """
    depths = decode_depth(str(message.format), bytes(message.data))
    height, width = depths.shape
    encoding = str(message.format).partition(";")[0].strip()
    data = np.ascontiguousarray(depths).astype(depths.dtype.newbyteorder("<")).tobytes()
    return Image(message.header, height, width, encoding, 0, len(data) // height, data)


def _compressed_parameters() -> Parameters:
    parameters = Parameters()
    parameters.add("format", "jpeg", "format of compressed images", choices={name: name for name in COMPRESSED_FORMATS})
    parameters.add("jpeg_quality", 80, "JPEG quality", minimum=1, maximum=100)
    parameters.add("png_level", 9, "PNG compression level", minimum=1, maximum=9)
    return parameters


def _depth_parameters() -> Parameters:
    parameters = Parameters()
    parameters.add("format", "png", "format of depth images", choices={name: name for name in DEPTH_FORMATS})
    parameters.add("depth_max", 10.0, "maximum depth in metres", minimum=1.0, maximum=100.0)
    text = "depth in metres at which the steps are 1 m"
    parameters.add("depth_quantization", 100.0, text, minimum=1.0, maximum=150.0)
    parameters.add("png_level", 1, "PNG compression level", minimum=1, maximum=9)
    return parameters


def _encode_compressed(image: Any, config: Any) -> Any:
    format = config.format if config.format in COMPRESSED_FORMATS else COMPRESSED_FORMATS[0]
    return compress(image, format, config.jpeg_quality, config.png_level)


def _encode_depth(image: Any, config: Any) -> Any:
    format = config.format if config.format in DEPTH_FORMATS else DEPTH_FORMATS[0]
    return compress_depth(image, format, config.depth_max, config.depth_quantization, config.png_level)


IMAGE_TRANSPORTS = {
    "raw": ImageTransport(lambda: Image, lambda: lambda image: image, lambda image, config: image),
    "compressed": ImageTransport(
        lambda: CompressedImage, lambda: decompress, _encode_compressed, _compressed_parameters
    ),
    "compressedDepth": ImageTransport(
        lambda: CompressedImage, lambda: decompress_depth, _encode_depth, _depth_parameters
    ),
    "theora": ImageTransport(packet_class, lambda: TheoraDecoder().decode, is_video=True),
}
"""The transports by name."""
