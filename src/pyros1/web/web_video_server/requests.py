"""Parses the URLs of web_video_server (no I/O)."""

from __future__ import annotations

from dataclasses import dataclass
from http import HTTPStatus
from urllib.parse import parse_qs, urlsplit

from pyros1.ground.errors import Error
from pyros1.web.web_video_server.video_options import VIDEO_TYPES, VideoOptions, parse_integer, parse_video_options

MAX_SIDE = 8192
"""Maximum width and height in pixels to which images are scaled."""
_MAX_PARAMETERS = 50
_JPEG_QUALITY, _PNG_LEVEL = 95, 3
STREAM_TYPES = ("mjpeg", "png", "ros_compressed", *VIDEO_TYPES)
_DEFAULT_VIDEO = VideoOptions()
_PATHS = ("/", "/stream", "/stream_viewer", "/snapshot")


class RequestProblem(Error):
    """A request cannot be answered.

    Attributes:
        status: the HTTP status of the response.
    """

    def __init__(self, status: HTTPStatus, text: str) -> None:
        super().__init__(text)
        self.status = status


@dataclass(frozen=True)
class Rendering:
    """The options for converting images to files.

    Attributes:
        format: "jpeg" or "png".
        quality: the JPEG quality from 1 to 100, or the PNG compression level from 0 to 9.
        width, height: the size to scale to, in pixels; None to keep the image's own.
        is_inverted: whether images are turned by 180 degrees.
    """

    format: str = "jpeg"
    quality: int = _JPEG_QUALITY
    width: int | None = None
    height: int | None = None
    is_inverted: bool = False


@dataclass(frozen=True)
class Request:
    """A parsed request.

    Attributes:
        path: "/", "/stream", "/stream_viewer" or "/snapshot".
        query: the URL's query, for the page of ``/stream_viewer``.
        topic: the image topic as written in the URL; empty if the URL has none.
        stream_type: one of `STREAM_TYPES`.
        transport: how the images are sent to this node: "raw" or "compressed".
        rendering: how the images are converted to files.
        video: how the video is encoded if ``stream_type`` is one of `VIDEO_TYPES`.
    """

    path: str
    query: str = ""
    topic: str = ""
    stream_type: str = "mjpeg"
    transport: str = "raw"
    rendering: Rendering = Rendering()
    video: VideoOptions = _DEFAULT_VIDEO


def parse_request(url: str, default_type: str = "mjpeg") -> Request:
    """Parse a URL, and return the request in it.

    Args:
        url: path and query.
        default_type: the stream type if the URL has none.

    Raises:
        RequestProblem: the page, stream type or transport does not exist, or the topic is missing.
    """
    try:
        parts = urlsplit(url)
        fields = parse_qs(parts.query, keep_blank_values=True, max_num_fields=_MAX_PARAMETERS)
    except ValueError:
        raise RequestProblem(HTTPStatus.BAD_REQUEST, "this is not a valid URL") from None
    path = parts.path
    if path not in _PATHS:
        raise RequestProblem(HTTPStatus.NOT_FOUND, f"there is no such page; there are {', '.join(_PATHS)}")
    if path == "/":
        return Request(path)
    texts = {name: values[0] for name, values in fields.items()}
    if not texts.get("topic"):
        raise RequestProblem(HTTPStatus.BAD_REQUEST, f"the URL lacks a topic, as in {path}?topic=/camera/image_raw")
    stream_type = texts.get("type", default_type) if path != "/snapshot" else "mjpeg"
    if stream_type not in STREAM_TYPES:
        raise RequestProblem(HTTPStatus.NOT_FOUND, f"the type of a stream must be one of {', '.join(STREAM_TYPES)}")
    transport = texts.get("default_transport", "raw")
    if transport not in ("raw", "compressed"):
        raise RequestProblem(HTTPStatus.NOT_IMPLEMENTED, "default_transport must be raw or compressed")
    video = parse_video_options(texts, stream_type) if stream_type in VIDEO_TYPES else _DEFAULT_VIDEO
    return Request(path, parts.query, texts["topic"], stream_type, transport, _rendering(texts, stream_type), video)


def _rendering(texts: dict[str, str], stream_type: str) -> Rendering:
    is_png = stream_type == "png"
    lowest, highest, default = (0, 9, _PNG_LEVEL) if is_png else (1, 100, _JPEG_QUALITY)
    return Rendering(
        "png" if is_png else "jpeg",
        parse_integer(texts.get("quality"), default, lowest, highest),
        _dimension(texts, "width"),
        _dimension(texts, "height"),
        "invert" in texts,
    )


def _dimension(texts: dict[str, str], name: str) -> int | None:
    """Return a width or height; None, which keeps the image's own, if it is missing or -1."""
    size = parse_integer(texts.get(name), -1, -2, MAX_SIDE + 1)
    if size == -1:
        return None
    if not 1 <= size <= MAX_SIDE:
        raise RequestProblem(HTTPStatus.BAD_REQUEST, f"the {name} must be from 1 to {MAX_SIDE}")
    return size
