"""Answers the requests of web_video_server's clients: pages, snapshots and streams."""

from __future__ import annotations

import io
import select
from collections.abc import Callable, Iterator
from contextlib import closing
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from math import inf
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

from pyros1.graph import Graph
from pyros1.ground.errors import Error, InvalidNameError, MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.web.web_video_server.pages import list_page, viewer_page
from pyros1.web.web_video_server.pictures import compressed_type, to_8_bits
from pyros1.web.web_video_server.request_reader import RequestReader
from pyros1.web.web_video_server.requests import Request, RequestProblem, parse_request
from pyros1.web.web_video_server.sources import Frame, Source
from pyros1.web.web_video_server.video_options import VIDEO_TYPES
from pyros1.web.web_video_server.videos import Video, import_av

if TYPE_CHECKING:
    from pyros1.web.web_video_server.server import VideoServer

SNAPSHOT_TIMEOUT = 30.0
"""Seconds to wait for the image of a snapshot."""
REQUEST_TIMEOUT = 10.0
"""Seconds within which a client must have sent its whole request."""
SEND_TIMEOUT = 10.0
"""Seconds within which a client must have read an image, or it is disconnected."""
_MAX_SNAPSHOT_AGE = 1.0
"""Maximum age in seconds of a stream's newest image to be used for a snapshot."""
_CHECK_PERIOD = 1.0
"""Seconds between checks of whether a client is still there while no images arrive."""
_VIDEO_REPEATS = 0.2, 1.0
"""Seconds until a video's last image is repeated for the first time, and then between repetitions: browsers show an
image only when the next one arrives.
"""
_CHUNK = 1 << 16
_BOUNDARY = "boundarydonotcross"
_IMAGE_TYPE, _INFO_TYPE = "sensor_msgs/Image", "sensor_msgs/CameraInfo"
_HEADERS = {
    "Connection": "close",
    "Cache-Control": "no-cache, no-store, must-revalidate, max-age=0",
    "Pragma": "no-cache",
    "Access-Control-Allow-Origin": "*",
    "X-Content-Type-Options": "nosniff",
}
_PAGE_HEADERS = {
    "Content-Security-Policy": "default-src 'none'; img-src 'self' data:; media-src 'self'; base-uri 'none'; "
    "form-action 'none'"
}


class Handler(BaseHTTPRequestHandler):
    """Answers one request."""

    server: VideoServer
    server_version = "web_video_server"
    sys_version = ""

    def setup(self) -> None:
        """Prepare for reading the request."""
        super().setup()
        self.rfile.close()
        self.rfile = io.BufferedReader(RequestReader(self.connection, REQUEST_TIMEOUT))

    def do_GET(self) -> None:
        """Answer the request."""
        self.connection.settimeout(SEND_TIMEOUT)
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
        is_video = request.stream_type in VIDEO_TYPES
        if is_video:
            self._check_video(request.stream_type)
        if request.path == "/stream_viewer":
            self._send_page(viewer_page(request.topic, request.query, request.stream_type))
            return
        topic, is_compressed, stream_type = self.server.select_source(request)
        with self.server.sources.use(topic, is_compressed) as source:
            if is_video:
                self._send_video(request, source, topic)
                return
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
        repeat = self.server.resend_period or inf
        for frame in self._frames(source, (repeat, repeat)):
            try:
                content_type, data = encode(frame)
            except Error as error:
                self._log_problem(topic, error)
                return
            headers = {"Content-type": content_type, "X-Timestamp": _stamp(frame), "Content-Length": len(data)}
            head = "".join(f"{name}: {value}\r\n" for name, value in headers.items())
            self.wfile.write(b"%b\r\n%b\r\n--%b\r\n" % (head.encode(), data, _BOUNDARY.encode()))

    def _check_video(self, stream_type: str) -> None:
        try:
            import_av(stream_type)
        except Error as error:
            self.server.node.log.warn("%s", error, throttle=30)
            raise RequestProblem(HTTPStatus.NOT_IMPLEMENTED, str(error)) from None

    def _send_video(self, request: Request, source: Source, topic: str) -> None:
        if not self.server.video_slots.acquire(blocking=False):
            text = "too many videos are being watched: use type=mjpeg, or close another"
            raise RequestProblem(HTTPStatus.SERVICE_UNAVAILABLE, text)
        rendering, repeats = request.rendering, _VIDEO_REPEATS
        if self.server.resend_period:
            repeats = self.server.resend_period, self.server.resend_period
        try:
            with closing(Video(request.stream_type, request.video, rendering.width, rendering.height)) as video:
                is_first = True
                for frame in self._frames(source, repeats, request.video.framerate):
                    try:
                        data = video.encode(to_8_bits(frame.message, rendering.is_inverted), monotonic())
                    except Error as error:
                        self._log_problem(topic, error)
                        if is_first:
                            raise
                        return
                    if is_first:
                        self._send_headers(HTTPStatus.OK, video.content_type, {})
                        is_first = False
                    self.wfile.write(data)
        finally:
            self.server.video_slots.release()

    def _log_problem(self, topic: str, error: Error) -> None:
        self.server.node.log.error("%s: %s", one_line(topic, 200), error, throttle=30)

    def _frames(self, source: Source, repeats: tuple[float, float], max_rate: float | None = None) -> Iterator[Frame]:
        """Yield the newest image when it is new or must be repeated, until the client disconnects or the source closes.

        Older images that arrived while the caller was busy are skipped.

        Args:
            source: the source of the images.
            repeats: seconds without a new image until the last one is repeated for the first time, and then between
                repetitions.
            max_rate: the maximum number of images per second; None for all.
        """
        last: Frame | None = None
        num_repeats, yielded_at, ready_at = 0, -inf, -inf
        while not source.is_closed:
            sleep(max(ready_at - monotonic(), 0.0))
            due = yielded_at + repeats[min(num_repeats, 1)] if last else inf
            frame = source.wait(last.number if last else 0, min(max(due - monotonic(), 0.0), _CHECK_PERIOD))
            if frame is None:
                if self._is_gone():
                    return
                if last is None or source.is_closed or monotonic() < due:
                    continue
            num_repeats = num_repeats + 1 if frame is None else 0
            last, yielded_at = frame or last, monotonic()
            # An image may be up to one period early, so that slightly irregular images do not reduce the rate.
            period = 1.0 / max_rate if max_rate else 0.0
            ready_at = max(ready_at, yielded_at - period) + period
            assert last is not None
            yield last

    def _wait(self, source: Source, after: int, timeout: float) -> Frame | None:
        """Wait for an image; return None if none arrives in time, or the client has disconnected."""
        deadline = monotonic() + timeout
        while not source.is_closed and (remaining := deadline - monotonic()) > 0.0:
            frame = source.wait(after, min(remaining, _CHECK_PERIOD))
            if frame is not None or self._is_gone():
                return frame
        return None

    def _is_gone(self) -> bool:
        """Return whether the client has disconnected. Data that it sends after its request is discarded."""
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
