"""Encodes images as a video that a browser can play as it arrives. Needs PyAV.

Each image is written only when the next one arrives, since containers store how long an image is shown.
"""

from __future__ import annotations

from fractions import Fraction
from importlib import import_module
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import Error, MessageError
from pyros1.web.web_video_server.video_options import VideoOptions

MAX_VIDEO_SIDE = 4096
"""Maximum width and height of a video in pixels."""
_MILLISECOND = Fraction(1, 1000)
_DEFAULT_BITRATE = 100_000
_CRF = "20"
"""The constant quality of H.264 and VP9."""
_USUAL_FRAME_RATE = 30
"""Images per second that encoders are told to expect if the URL has no framerate. The video's actual rate is
that of the arriving images.
"""
_PIXEL_FORMATS = {1: "gray", 3: "rgb24", 4: "rgba"}


class _Codec(NamedTuple):
    name: str
    container: str
    content_type: str


_CODECS = {
    "h264": _Codec("libx264", "mp4", "video/mp4"),
    "vp8": _Codec("libvpx", "webm", "video/webm"),
    "vp9": _Codec("libvpx-vp9", "webm", "video/webm"),
}
_CONTAINER_OPTIONS = {
    # A fragment for each image: otherwise nothing is shown before the second key frame.
    "mp4": {"movflags": "frag_every_frame+empty_moov+default_base_moof", "flush_packets": "1"},
    "webm": {"live": "1", "cluster_time_limit": "1", "flush_packets": "1"},
}


def import_av(stream_type: str) -> Any:
    """Import and return PyAV.

    Args:
        stream_type: the stream type that needs PyAV.

    Raises:
        Error: PyAV is not installed, or cannot encode such streams.
    """
    hint = "pip install 'pyros1[video]', or use type=mjpeg"
    try:
        av = import_module("av")
    except ImportError as error:
        raise Error(f"streams of the type {stream_type} need PyAV ({error}): {hint}") from None
    codec = _CODECS[stream_type].name
    if codec not in av.codecs_available:
        raise Error(f"streams of the type {stream_type} need PyAV with the encoder {codec}, like PyPI's: {hint}")
    return av


class Video:
    """A video made of images as they arrive, each of which is scaled to the video's size.

    Args:
        stream_type: one of `VIDEO_TYPES`.
        options: the encoding options.
        width, height: the video's size in pixels, rounded up to even numbers for the encoders; None for the size of
            the first image.

    Raises:
        Error: PyAV is not installed, or cannot encode such videos.
    """

    def __init__(
        self, stream_type: str, options: VideoOptions, width: int | None = None, height: int | None = None
    ) -> None:
        self._av = import_av(stream_type)
        self._codec = _CODECS[stream_type]
        self._options = options
        self._size = width, height
        self._sink = _Sink()
        self._container: Any = None
        self._stream: Any = None
        self._begin = 0.0
        self._last_pts = -1

    @property
    def content_type(self) -> str:
        """The content type of the video."""
        return self._codec.content_type

    def encode(self, pixels: NDArray[np.uint8], now: float) -> bytes:
        """Return the next bytes of the video.

        Args:
            pixels: the next image, of shape (height, width, 1, 3 or 4).
            now: the time in seconds from which it is shown.

        Raises:
            MessageError: the image cannot be encoded.
        """
        try:
            if self._container is None:
                self._open(pixels, now)
            flat = pixels[:, :, 0] if pixels.shape[2] == 1 else pixels
            frame = self._av.VideoFrame.from_ndarray(
                np.ascontiguousarray(flat), format=_PIXEL_FORMATS[pixels.shape[2]]
            ).reformat(self._stream.width, self._stream.height, "yuv420p")
            self._last_pts = max(int((now - self._begin) * 1000), self._last_pts + 1)
            frame.pts, frame.time_base = self._last_pts, _MILLISECOND
            self._container.mux(self._stream.encode(frame))
        except (self._av.error.FFmpegError, ValueError) as error:
            raise MessageError(f"the image cannot be encoded with {self._codec.name}: {error}") from None
        return self._sink.take()

    def _open(self, pixels: NDArray[np.uint8], now: float) -> None:
        width, height = self._size[0] or pixels.shape[1], self._size[1] or pixels.shape[0]
        if max(width, height) > MAX_VIDEO_SIDE:
            text = f"the image has {width}x{height} pixels; videos can have at most {MAX_VIDEO_SIDE} in each direction"
            raise MessageError(f"{text}: add width=... and height=... to the URL")
        options, codec = self._options, self._codec
        self._container = self._av.open(
            self._sink, "w", format=codec.container, options=_CONTAINER_OPTIONS[codec.container]
        )
        stream = self._stream = self._container.add_stream(codec.name, rate=options.framerate or _USUAL_FRAME_RATE)
        stream.width, stream.height = width + width % 2, height + height % 2
        stream.pix_fmt = "yuv420p"
        stream.options = self._encoder_options()
        stream.codec_context.time_base = _MILLISECOND
        stream.codec_context.thread_count = 1
        self._begin = now

    def _encoder_options(self) -> dict[str, str]:
        options = self._options
        common = {"g": str(options.gop), "bf": "0", "qmin": str(options.qmin), "qmax": str(options.qmax)}
        if self._codec.name == "libx264":
            # As in the original, the quality is constant. A bitrate in the URL is the maximum; the original ignores it.
            limit = {"maxrate": str(options.bitrate), "bufsize": str(options.bitrate)} if options.bitrate else {}
            return {"preset": options.preset, "tune": "zerolatency", "crf": _CRF, **common, **limit}
        common |= {"b": str(options.bitrate or _DEFAULT_BITRATE), "cpu-used": "8", "lag-in-frames": "0"}
        if self._codec.name == "libvpx":
            return {"deadline": options.quality, "auto-alt-ref": "0", **common}
        level = min(max(int(_CRF), options.qmin), options.qmax)  # the encoder rejects other values
        return {"deadline": "realtime", "crf": str(level), **common}

    def close(self) -> None:
        """End the video, and free the encoder's memory."""
        container, self._container, self._stream = self._container, None, None
        if container is not None:
            try:
                container.close()
            except self._av.error.FFmpegError:  # the video ends in any case
                return
            finally:
                self._sink.take()


class _Sink:
    """The file-like object to which PyAV writes the video."""

    def __init__(self) -> None:
        self._parts: list[bytes] = []

    def write(self, data: Any) -> int:
        self._parts.append(bytes(data))
        return len(data)

    def take(self) -> bytes:
        """Return what has been written since the last call."""
        data = b"".join(self._parts)
        self._parts.clear()
        return data
