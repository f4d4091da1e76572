"""Listens for the clients of web_video_server, with a thread for each connection.

As with the original, anyone who can reach the port can see the images; PYROS1_ALLOW restricts access to some machines.
"""

from __future__ import annotations

import contextlib
import os
import socket
import sys
import threading
from http.server import ThreadingHTTPServer
from typing import TYPE_CHECKING, Any

from pyros1.graph import Graph
from pyros1.ground.terminal_text import one_line
from pyros1.web.web_video_server.handler import Handler
from pyros1.web.web_video_server.requests import Request
from pyros1.web.web_video_server.sources import Sources

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist
    from pyros1.node import Node

MAX_CONNECTIONS = 64
MAX_VIDEOS = 16
"""Maximum number of videos that are encoded at the same time."""
_IMAGE_TYPE, _COMPRESSED_TYPE = "sensor_msgs/Image", "sensor_msgs/CompressedImage"


class VideoServer(ThreadingHTTPServer):
    """Serves the images of a node's system; listens as soon as it is created.

    Args:
        node: the node that subscribes to the images.
        address, port: the address and port to listen on; port 0 stands for any free port.
        default_type: the stream type for URLs without one.
        publish_rate: how often per second a stream's newest image is repeated if no other arrives; 0 for never.
        is_verbose: whether requests are logged.
        allowlist: decides which machines may connect; None for all.

    Raises:
        OSError: the port is not available.
    """

    daemon_threads = False
    block_on_close = True
    request_queue_size = 32

    def __init__(
        self,
        node: Node,
        address: str,
        port: int,
        default_type: str = "mjpeg",
        publish_rate: float = 0.0,
        is_verbose: bool = True,
        allowlist: Allowlist | None = None,
    ) -> None:
        self.node = node
        self.sources = Sources(node)
        self.default_type = default_type
        self.resend_period = 1.0 / publish_rate if publish_rate > 0.0 else 0.0
        self.is_verbose = is_verbose
        self.video_slots = threading.BoundedSemaphore(MAX_VIDEOS)
        self._allowlist = allowlist
        self._lock = threading.Lock()
        self._connections: set[Any] = set()
        if ":" in address:
            self.address_family = socket.AF_INET6
        super().__init__((address, port), Handler)

    @property
    def port(self) -> int:
        """The port that the server listens on."""
        return int(self.server_address[1])

    def server_bind(self) -> None:
        """Bind the socket. The base class would also look up the host's name, which may take long."""
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self.socket.bind(self.server_address)
        self.server_address = self.socket.getsockname()

    def verify_request(self, request: Any, client_address: Any) -> bool:
        """Return whether a new connection is accepted."""
        if self._allowlist is not None and not self._allowlist.admit(request, client_address):
            return False
        with self._lock:
            if len(self._connections) >= MAX_CONNECTIONS:
                return False
            self._connections.add(request)
            return True

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        with self._lock:
            self._connections.discard(request)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore disconnections by clients; log other errors, which are bugs."""
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            self.node.log.error("a request failed: %s", one_line(repr(error), 300))

    def stop(self) -> None:
        """Stop the server, which must be running in another thread, and end all connections."""
        self.shutdown()
        self.sources.close()
        with self._lock:
            connections = list(self._connections)
        for connection in connections:
            with contextlib.suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)
        self.server_close()

    def select_source(self, request: Request) -> tuple[str, bool, str]:
        """Return the topic to subscribe to for a request, whether its images are compressed, and the stream's type.

        Raises:
            InvalidNameError: the topic's name is invalid.
            Error: the master does not respond.
        """
        topic = self.node.resolve(request.topic)
        types = Graph(self.node.master).topic_types()
        has_compressed = types.get(f"{topic}/compressed") == _COMPRESSED_TYPE
        stream_type = request.stream_type
        if stream_type == "ros_compressed" and not has_compressed:
            self.node.log.warn("there is no topic %s/compressed: sending mjpeg", one_line(topic, 200), throttle=10)
            stream_type = "mjpeg"
        elif request.transport == "compressed" and not has_compressed and types.get(topic) == _IMAGE_TYPE:
            self.node.log.warn("waiting for %s/compressed, which nobody publishes", one_line(topic, 200), throttle=10)
        if types.get(topic) == _COMPRESSED_TYPE:
            return topic, True, stream_type
        is_compressed = (
            stream_type == "ros_compressed"
            or request.transport == "compressed"
            or (has_compressed and types.get(topic) != _IMAGE_TYPE)
        )
        return (f"{topic}/compressed" if is_compressed else topic), is_compressed, stream_type


def describe(error: OSError) -> str:
    """Return the system's error message."""
    return os.strerror(error.errno) if error.errno and error.errno > 0 else str(error.strerror or error)
