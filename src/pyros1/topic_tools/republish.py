"""republish: converts images between transports, like image_transport's republish.

See https://wiki.ros.org/image_transport#republish, and `pyros1.topic_tools.image_transports` for the transports.
"""

from __future__ import annotations

import sys
from typing import Any

from pyros1.ground.errors import Error
from pyros1.node import Node
from pyros1.reconfigure import Server
from pyros1.topic_tools.image_transports import IMAGE_TRANSPORTS, transport_topic

USAGE = "Usage: republish in_transport in:=<in_base_topic> [out_transport] out:=<out_base_topic>\n"


class Republisher:
    """Converts the images on a topic and publishes them on another until the node shuts down.

    Compressed outputs can be configured with dynamic_reconfigure, in the namespace of their topic: ``compressed`` has
    ``format``, ``jpeg_quality`` and ``png_level``; ``compressedDepth`` has ``format``, ``depth_max``,
    ``depth_quantization`` and ``png_level``.

    Args:
        node: the node that subscribes and publishes.
        source, source_transport: the topic and transport of the input images.
        output: the topic of the output images.
        output_transport: their transport; None for all that can be sent, except the input's own topic. Images are only
            converted for transports that have subscribers.

    Raises:
        ValueError: a transport is unknown or cannot be sent, or input and output are the same.
        Error: a library that the transport needs is not installed.
    """

    def __init__(
        self, node: Node, source: str, source_transport: str, output: str, output_transport: str | None = None
    ) -> None:
        for transport in (source_transport, output_transport or "raw"):
            if transport not in IMAGE_TRANSPORTS:
                raise ValueError(f"there is no image transport {transport!r}, only {', '.join(IMAGE_TRANSPORTS)}")
        if output_transport and IMAGE_TRANSPORTS[output_transport].encode is None:
            text = "can only be received, as PyAV has no encoder for it: publish as compressed"
            raise ValueError(f"the image transport {output_transport} {text}")
        self._node = node
        self._source_transport = source_transport
        self._is_video = IMAGE_TRANSPORTS[source_transport].is_video
        self._decode = IMAGE_TRANSPORTS[source_transport].make_decoder()
        self._input_topic = transport_topic(node.resolve(source), source_transport)
        topics = {name: transport_topic(node.resolve(output), name) for name in IMAGE_TRANSPORTS}
        if output_transport is None:
            names = [name for name in topics if IMAGE_TRANSPORTS[name].encode and topics[name] != self._input_topic]
        elif topics[output_transport] == self._input_topic:
            raise ValueError(f"{self._input_topic} would be republished to itself")
        else:
            names = [output_transport]
        self._outputs = [_Output(node, topics[name], name) for name in names]
        message_class = IMAGE_TRANSPORTS[source_transport].message_class()
        node.subscribe(self._input_topic, message_class, self._receive, queue_size=10 if self._is_video else 1)

    def _receive(self, message: Any) -> None:
        wanted = [output for output in self._outputs if output.publisher.num_connections]
        conversions = [output for output in wanted if output.transport != self._source_transport]
        for output in wanted:
            if output not in conversions:
                output.publisher.publish(message)
        if not conversions and not self._is_video:
            return
        try:
            image = self._decode(message)
            for output in conversions if image is not None else ():
                output.send(image)
        except Error as error:
            self._node.log.error("%s: %s", self._input_topic, error, throttle=10)


class _Output:
    def __init__(self, node: Node, topic: str, transport: str) -> None:
        self.transport = transport
        self._topic, self._log = topic, node.log
        self._kind = IMAGE_TRANSPORTS[transport]
        self._config: Any = None
        if self._kind.parameters:
            Server(node, self._kind.parameters(), self._on_configured, namespace=topic)
        self.publisher = node.advertise(topic, self._kind.message_class(), queue_size=1)

    def _on_configured(self, config: Any, level: int) -> Any:
        self._config = config
        return config

    def send(self, image: Any) -> None:
        assert self._kind.encode is not None
        try:
            self.publisher.publish(self._kind.encode(image, self._config))
        except Error as error:
            self._log.error("%s: %s", self._topic, error, throttle=10)


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
            Republisher(node, "in", args[0], "out", args[1] if len(args) == 2 else None)
            node.spin()
    except (Error, ValueError) as error:
        sys.stderr.write(f"ERROR: republish: {error}\n")
        return 1
    return 0
