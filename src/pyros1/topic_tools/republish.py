"""republish: converts images between transports, like image_transport's republish.

The transports are ``raw`` on the topic itself, and ``compressed`` (JPEG or PNG) on ``TOPIC/compressed``. See
https://wiki.ros.org/image_transport#republish.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import Error, MessageError
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.node import Node
from pyros1.reconfigure import Parameters, Server
from pyros1.topic_tools.image_encoding import COMPRESSED_FORMATS, compress, decompress

USAGE = "Usage: republish in_transport in:=<in_base_topic> [out_transport] out:=<out_base_topic>\n"
TRANSPORTS = ("raw", "compressed")


class Republisher:
    """Converts the images on a topic and publishes them on another until the node shuts down.

    Compression is configured by dynamic_reconfigure in ``OUTPUT/compressed``: ``format``, ``jpeg_quality`` and
    ``png_level``.

    Args:
        node: the node that subscribes and publishes.
        source, source_transport: the topic and transport of the input images.
        output, output_transport: the topic and transport of the output images.

    Raises:
        ValueError: a transport is unknown, or input and output are the same.
    """

    def __init__(self, node: Node, source: str, source_transport: str, output: str, output_transport: str) -> None:
        for transport in (source_transport, output_transport):
            if transport not in TRANSPORTS:
                raise ValueError(f"there is no image transport {transport!r}: only {' and '.join(TRANSPORTS)}")
        self._node = node
        self._options: dict[str, Any] = {}
        self._convert_image = self._make_conversion(source_transport, output_transport)
        self.topic, output_type = _topic_and_type(node, output, output_transport)
        input_topic, input_type = _topic_and_type(node, source, source_transport)
        if input_topic == self.topic:
            raise ValueError(f"{input_topic} would be republished to itself")
        if output_transport == "compressed":
            Server(node, _make_parameters(), self._on_configured, namespace=self.topic)
        self._publisher = node.advertise(self.topic, output_type, queue_size=1)
        node.subscribe(input_topic, input_type, self._receive, queue_size=1)

    def _make_conversion(self, source_transport: str, output_transport: str) -> Callable[[Any], Any]:
        if source_transport == output_transport:
            return lambda message: message
        return decompress if source_transport == "compressed" else lambda message: compress(message, **self._options)

    def _on_configured(self, config: Any, level: int) -> Any:
        self._options = {
            "format": config.format if config.format in COMPRESSED_FORMATS else COMPRESSED_FORMATS[0],
            "quality": config.jpeg_quality,
            "level": config.png_level,
        }
        return config

    def _receive(self, message: Any) -> None:
        if not self._publisher.num_connections:
            return
        try:
            self._publisher.publish(self._convert_image(message))
        except MessageError as error:
            self._node.log.error("%s: %s", self.topic, error, throttle=10)


def _topic_and_type(node: Node, base: str, transport: str) -> tuple[str, Any]:
    name = node.resolve(base)
    return (name, Image) if transport == "raw" else (f"{name}/compressed", CompressedImage)


def _make_parameters() -> Parameters:
    parameters = Parameters()
    parameters.add("format", "jpeg", "format of compressed images", choices={name: name for name in COMPRESSED_FORMATS})
    parameters.add("jpeg_quality", 80, "JPEG quality", minimum=1, maximum=100)
    parameters.add("png_level", 9, "PNG compression level", minimum=1, maximum=9)
    return parameters


def main(argv: list[str]) -> int:
    """Run the program. Return its exit code.

    Args:
        argv: the command line, including the program's name.
    """
    args = [arg for arg in argv[1:] if ":=" not in arg]
    if not 1 <= len(args) <= 2 or args[0] in ("-h", "--help"):
        sys.stderr.write(USAGE)
        return int(args[:1] not in (["-h"], ["--help"]))
    try:
        with Node("image_republisher", anonymous=True, argv=argv[1:]) as node:
            Republisher(node, "in", args[0], "out", args[1] if len(args) == 2 else "raw")
            node.spin()
    except (Error, ValueError) as error:
        sys.stderr.write(f"ERROR: republish: {error}\n")
        return 1
    return 0
