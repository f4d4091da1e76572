"""republish: converts images between forms, like image_transport's (https://wiki.ros.org/image_transport#republish).

The forms are ``raw`` on the topic itself, and ``compressed`` (JPEG or PNG) on ``TOPIC/compressed``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

from pyros1.ground.errors import Error, MessageError
from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.node import Node
from pyros1.reconfigure import Parameters, Server
from pyros1.topic_tools.image_encoding import FORMATS, compress, decompress

USAGE = "Usage: republish in_transport in:=<in_base_topic> [out_transport] out:=<out_base_topic>\n"
TRANSPORTS = ("raw", "compressed")


class Republisher:
    """Republishes the images of a topic until the node ends.

    Compression is configured by dynamic_reconfigure in ``OUTPUT/compressed``: ``format``,
    ``jpeg_quality`` and ``png_level``.

    Args:
        node: the node.
        source, source_transport: topic and form of the input images.
        output, output_transport: topic and form of the output images.

    Raises:
        NodeError: input and output are the same.
        ValueError: a form is unknown.
    """

    def __init__(self, node: Node, source: str, source_transport: str, output: str, output_transport: str) -> None:
        for each in (source_transport, output_transport):
            if each not in TRANSPORTS:
                raise ValueError(f"there is no image transport {each!r}: only {' and '.join(TRANSPORTS)}")
        self._node = node
        self._options: dict[str, Any] = {}
        self._convert = self._conversion(source_transport, output_transport)
        self.topic, type = _topic(node, output, output_transport)
        incoming, incoming_type = _topic(node, source, source_transport)
        if incoming == self.topic:
            raise ValueError(f"{incoming} would be republished to itself")
        if output_transport == "compressed":
            Server(node, _parameters(), self._configured, namespace=self.topic)
        self._publisher = node.advertise(self.topic, type, queue_size=1)
        node.subscribe(incoming, incoming_type, self._receive, queue_size=1)

    def _conversion(self, source: str, output: str) -> Callable[[Any], Any]:
        if source == output:
            return lambda message: message
        return decompress if source == "compressed" else lambda message: compress(message, **self._options)

    def _configured(self, config: Any, level: int) -> Any:
        self._options = {
            "format": config.format if config.format in FORMATS else FORMATS[0],
            "quality": config.jpeg_quality,
            "level": config.png_level,
        }
        return config

    def _receive(self, message: Any) -> None:
        if not self._publisher.num_connections:
            return
        try:
            self._publisher.publish(self._convert(message))
        except MessageError as error:
            self._node.log.error("%s: %s", self.topic, error, throttle=10)


def _topic(node: Node, base: str, transport: str) -> tuple[str, Any]:
    name = node.resolve(base)
    return (name, Image) if transport == "raw" else (f"{name}/compressed", CompressedImage)


def _parameters() -> Parameters:
    found = Parameters()
    found.add("format", "jpeg", "of compressed images", choices={each: each for each in FORMATS})
    found.add("jpeg_quality", 80, "quality of JPEG", minimum=1, maximum=100)
    found.add("png_level", 9, "level of PNG's compression", minimum=1, maximum=9)
    return found


def main(argv: list[str]) -> int:
    """Run the program; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    words = [word for word in argv[1:] if ":=" not in word]
    if not 1 <= len(words) <= 2 or words[0] in ("-h", "--help"):
        sys.stderr.write(USAGE)
        return int(words[:1] not in (["-h"], ["--help"]))
    try:
        with Node("image_republisher", anonymous=True, argv=argv[1:]) as node:
            Republisher(node, "in", words[0], "out", words[1] if len(words) == 2 else "raw")
            node.spin()
    except (Error, ValueError) as error:
        sys.stderr.write(f"ERROR: republish: {error}\n")
        return 1
    return 0
