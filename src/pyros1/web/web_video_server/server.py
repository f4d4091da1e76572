"""Serves images and streams over HTTP, with a thread for each connection.

As with the original, whoever can reach the port sees the images; PYROS1_ALLOW limits it to some machines.
"""

from __future__ import annotations

import contextlib
import os
import select
import socket
import sys
import threading
from collections.abc import Callable
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from time import monotonic
from typing import TYPE_CHECKING, Any

from pyros1.graph import Graph
from pyros1.ground.errors import Error, InvalidNameError, MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.web.web_video_server.pages import list_page, viewer_page
from pyros1.web.web_video_server.pictures import compressed_type
from pyros1.web.web_video_server.requests import Request, RequestProblem, parse_request
from pyros1.web.web_video_server.sources import Frame, Source, Sources

if TYPE_CHECKING:
    from pyros1.net.allowlist import Allowlist
    from pyros1.node import Node

MAX_CONNECTIONS = 64
SNAPSHOT_TIMEOUT = 30.0
"""Seconds to wait for the image of a snapshot."""
_MAX_SNAPSHOT_AGE = 1.0
"""Age in seconds up to which the newest image of a stream is used for a snapshot."""
_SOCKET_TIMEOUT = 10.0
"""Seconds after which a client is disconnected that sends no request, or reads nothing."""
_CHECK_PERIOD = 1.0
"""Seconds between checks of whether a client is still there while no images arrive."""
_CHUNK = 1 << 16
_BOUNDARY = "boundarydonotcross"
_IMAGE_TYPE, _COMPRESSED_TYPE, _INFO_TYPE = map("sensor_msgs/{}".format, ("Image", "CompressedImage", "CameraInfo"))
_HEADERS = {
    "Connection": "close",
    "Cache-Control": "no-cache, no-store, must-revalidate, max-age=0",
    "Pragma": "no-cache",
    "Access-Control-Allow-Origin": "*",
    "X-Content-Type-Options": "nosniff",
}
_PAGE_HEADERS = {"Content-Security-Policy": "default-src 'none'; img-src 'self'; base-uri 'none'; form-action 'none'"}


class VideoServer(ThreadingHTTPServer):
    """Serves the images of a node's system; listens as soon as it is created.

    Args:
        node: the node that subscribes to the images.
        address, port: the address and port to listen on; port 0 stands for any free port.
        default_type: the type of streams for which a URL has none.
        publish_rate: how often per second the newest image of a stream is sent again if no other arrives; 0 for never.
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
        self._allowlist = allowlist
        self._lock = threading.Lock()
        self._connections: set[Any] = set()
        if ":" in address:
            self.address_family = socket.AF_INET6
        super().__init__((address, port), _Handler)

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
        """Ignore that a client has disconnected; other errors are bugs, and logged."""
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
        if types.get(topic) == _COMPRESSED_TYPE:
            return topic, True, stream_type
        is_compressed = (
            stream_type == "ros_compressed"
            or request.transport == "compressed"
            or (has_compressed and types.get(topic) != _IMAGE_TYPE)
        )
        return (f"{topic}/compressed" if is_compressed else topic), is_compressed, stream_type


class _Handler(BaseHTTPRequestHandler):
    server: VideoServer
    timeout = _SOCKET_TIMEOUT
    server_version = "web_video_server"
    sys_version = ""

    def do_GET(self) -> None:
        if self.server.is_verbose:
            self.server.node.log.info("request: %s", one_line(self.path, 300))
        try:
            request = parse_request(self.path, self.server.default_type)
            self._respond(request)
        except RequestProblem as problem:
            self._send_text(problem.status, str(problem))
        except InvalidNameError as error:
            self._send_text(HTTPStatus.BAD_REQUEST, str(error))
        except Error as error:
            self._send_text(HTTPStatus.SERVICE_UNAVAILABLE, str(error))

    def _respond(self, request: Request) -> None:
        if request.path == "/":
            types = Graph(self.server.node.master).topic_types()
            images = [topic for topic, type_name in types.items() if type_name == _IMAGE_TYPE]
            infos = [topic for topic, type_name in types.items() if type_name == _INFO_TYPE]
            self._send_page(list_page(images, infos))
            return
        if request.path == "/stream_viewer":
            self._send_page(viewer_page(request.topic, request.query))
            return
        topic, is_compressed, stream_type = self.server.select_source(request)
        with self.server.sources.use(topic, is_compressed) as source:
            encode = self._encoder(request, source, stream_type)
            if request.path == "/snapshot":
                self._send_snapshot(source, topic, encode)
            else:
                self._send_stream(source, topic, encode)

    def _encoder(self, request: Request, source: Source, stream_type: str) -> Callable[[Frame], tuple[str, bytes]]:
        """Return a function that returns an image's content type and data."""
        if stream_type != "ros_compressed":
            content_type = f"image/{request.rendering.format}"
            return lambda frame: (content_type, source.encode(frame, request.rendering))

        def take(frame: Frame) -> tuple[str, bytes]:
            content_type = compressed_type(frame.message)
            if not content_type:
                raise MessageError(f"browsers cannot show images of the format {one_line(frame.message.format, 100)}")
            return content_type, bytes(frame.message.data)

        return take

    def _send_snapshot(self, source: Source, topic: str, encode: Callable[[Frame], tuple[str, bytes]]) -> None:
        frame = source.newest
        if frame is None or monotonic() - frame.arrived_at > _MAX_SNAPSHOT_AGE:
            frame = self._wait(source, frame.number if frame else 0, SNAPSHOT_TIMEOUT)
        if frame is None:
            text = f"no image has arrived on {topic} within {SNAPSHOT_TIMEOUT:g} s"
            self._send_text(HTTPStatus.GATEWAY_TIMEOUT, text)
            return
        content_type, data = encode(frame)
        self._send(HTTPStatus.OK, content_type, data, {"X-Timestamp": _stamp(frame)})

    def _send_stream(self, source: Source, topic: str, encode: Callable[[Frame], tuple[str, bytes]]) -> None:
        self._send_headers(HTTPStatus.OK, f"multipart/x-mixed-replace;boundary={_BOUNDARY}", {})
        self.wfile.write(f"--{_BOUNDARY}\r\n".encode())
        last: Frame | None = None
        sent_at, resend_period = 0.0, self.server.resend_period
        while not source.is_closed:
            frame = source.wait(last.number if last else 0, min(resend_period or _CHECK_PERIOD, _CHECK_PERIOD))
            if frame is None:
                if self._is_gone():
                    return
                if last is None or not resend_period or monotonic() - sent_at < resend_period:
                    continue
                frame = last
            last, sent_at = frame, monotonic()
            try:
                content_type, data = encode(frame)
            except Error as error:
                self.server.node.log.error("%s: %s", one_line(topic, 200), error, throttle=30)
                return
            headers = {"Content-type": content_type, "X-Timestamp": _stamp(frame), "Content-Length": len(data)}
            head = "".join(f"{name}: {value}\r\n" for name, value in headers.items())
            self.wfile.write(b"%b\r\n%b\r\n--%b\r\n" % (head.encode(), data, _BOUNDARY.encode()))

    def _wait(self, source: Source, after: int, timeout: float) -> Frame | None:
        """Wait for an image; return None if none arrives in time, or the client has disconnected."""
        deadline = monotonic() + timeout
        while not source.is_closed and (remaining := deadline - monotonic()) > 0.0:
            frame = source.wait(after, min(remaining, _CHECK_PERIOD))
            if frame is not None or self._is_gone():
                return frame
        return None

    def _is_gone(self) -> bool:
        """Return whether the client has disconnected. What it sends after its request is discarded."""
        try:
            readable, _, _ = select.select([self.connection], [], [], 0)
            return bool(readable) and not self.connection.recv(_CHUNK)
        except (OSError, ValueError):
            return True

    def _send_page(self, html: str) -> None:
        self._send(HTTPStatus.OK, "text/html; charset=utf-8", html.encode(), _PAGE_HEADERS)

    def _send_text(self, status: HTTPStatus, text: str) -> None:
        self._send(status, "text/plain; charset=utf-8", f"{one_line(text, 1000)}\n".encode(), {})

    def _send(self, status: HTTPStatus, content_type: str, data: bytes, headers: dict[str, str]) -> None:
        self._send_headers(status, content_type, {"Content-Length": str(len(data)), **headers})
        self.wfile.write(data)

    def _send_headers(self, status: HTTPStatus, content_type: str, headers: dict[str, str]) -> None:
        self.send_response(status)
        for name, value in {"Content-type": content_type, **_HEADERS, **headers}.items():
            self.send_header(name, value)
        self.end_headers()

    def log_message(self, format: str, *args: Any) -> None:
        """Log nothing: the base class would write to stderr."""


def _stamp(frame: Frame) -> str:
    return f"{frame.message.header.stamp.to_sec():.6f}"


def describe(error: OSError) -> str:
    """Return what is wrong, in the system's words."""
    return os.strerror(error.errno) if error.errno and error.errno > 0 else str(error.strerror or error)
