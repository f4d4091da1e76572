"""Encodes images as H.264 video, one message per picture. Needs PyAV.

The messages are of Foxglove's type foxglove_msgs/CompressedVideo: Annex B, without B-frames, so that each can be
decoded on arrival. Each picture is encoded as its difference from the one before, except for key frames, which are sent
at least every two seconds, and on request for a new receiver.
"""

from __future__ import annotations

from fractions import Fraction
from importlib import import_module
from typing import Any

import numpy as np

from pyros1.bag.export.images import Pixels, pixels, to_8_bits
from pyros1.ground.errors import Error, MessageError
from pyros1.msgs import from_definition

VIDEO = "foxglove_msgs/CompressedVideo"
_DEFINITION = """\
# One picture of a video, from https://github.com/foxglove/schemas
time timestamp
string frame_id  # optical frame of the camera
uint8[] data     # exactly one picture, for example in Annex B form
string format    # h264
"""
KEY_FRAME_PERIOD = 2.0
"""Maximum seconds between key frames, as long as there are pictures."""
_MAX_PUBLISHERS = 4
"""Maximum number of publishers of a topic, each with its own video; the one that paused longest is dropped."""
_MICROSECOND = Fraction(1, 1_000_000)


def video_class() -> Any:
    """Return the message class."""
    return from_definition(VIDEO, _DEFINITION)


def import_av() -> Any:
    """Import and return PyAV.

    Raises:
        Error: it is not installed.
    """
    try:
        return import_module("av")
    except ImportError as error:
        raise Error(f"convert: h264 needs PyAV ({error}): pip install 'pyros1[video]'") from None


class Video:
    """Encodes the images of a topic.

    Args:
        bitrate: approximate bits per second.

    Raises:
        Error: PyAV is not installed, or it has no encoder for H.264.
    """

    def __init__(self, bitrate: float) -> None:
        self._av = import_av()
        if "libx264" not in self._av.codecs_available:
            raise Error("convert: h264 needs a PyAV with the encoder libx264, as on PyPI: pip install 'pyros1[video]'")
        self._bitrate = int(bitrate)
        self._class = video_class()
        self._encoders: dict[str, _Encoder] = {}

    def restart(self) -> None:
        """Encode the next picture of each publisher as a key frame."""
        for encoder in self._encoders.values():
            encoder.needs_key_frame = True

    def convert(self, publisher: str, image: Any, now: float) -> Any:
        """Return the next picture of a publisher's video.

        Args:
            publisher: its name.
            image: a sensor_msgs/Image.
            now: when it came, in seconds.

        Raises:
            MessageError: the image cannot be encoded.
        """
        picture = _to_even_size(to_8_bits(pixels(image)))
        encoder = self._encoders.pop(publisher, None)
        if encoder is None or encoder.shape != picture.shape:
            encoder = _Encoder(self._av, picture.shape, self._bitrate)
        self._encoders[publisher] = encoder  # the last one is the newest
        while len(self._encoders) > _MAX_PUBLISHERS:
            del self._encoders[next(iter(self._encoders))]
        try:
            data = encoder.encode(picture, now)
        except self._av.error.FFmpegError as error:
            del self._encoders[publisher]
            raise MessageError(f"the image cannot be encoded as H.264: {error}") from None
        return self._class(image.header.stamp, image.header.frame_id, data, "h264")


class _Encoder:
    def __init__(self, av: Any, shape: tuple[int, ...], bitrate: int) -> None:
        self.shape = shape
        self.needs_key_frame = True
        self._av = av
        self._key_frame_at = 0.0
        self._last_pts = -1
        self._begin: float | None = None
        context = self._context = av.CodecContext.create("libx264", "w")
        context.height, context.width = shape[:2]
        context.pix_fmt = "yuv420p"
        context.time_base = _MICROSECOND
        context.framerate = Fraction(30)
        context.bit_rate = bitrate
        context.thread_count = 1
        # zerolatency: each picture comes out at once. The rate limit allows bursts of one second's bits.
        context.options = {
            "preset": "veryfast",
            "tune": "zerolatency",
            "maxrate": str(bitrate),
            "bufsize": str(bitrate),
        }

    def encode(self, picture: Pixels, now: float) -> bytes:
        if self._begin is None:
            self._begin = now
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format=_format(picture))
        frame = frame.reformat(format="yuv420p")
        self._last_pts = max(int((now - self._begin) * 1_000_000), self._last_pts + 1)
        frame.pts, frame.time_base = self._last_pts, _MICROSECOND
        if self.needs_key_frame or now - self._key_frame_at >= KEY_FRAME_PERIOD:
            frame.pict_type = self._av.video.frame.PictureType.I
            self.needs_key_frame, self._key_frame_at = False, now
        return b"".join(map(bytes, self._context.encode(frame)))


def _format(picture: Pixels) -> str:
    return "gray" if picture.ndim == 2 else "rgb24" if picture.shape[2] == 3 else "rgba"


def _to_even_size(picture: Pixels) -> Pixels:
    """Return a picture of even size, as the encoder requires: the last row or column is repeated if necessary."""
    height, width = picture.shape[:2]
    if not height % 2 and not width % 2:
        return picture
    return np.pad(picture, [(0, height % 2), (0, width % 2), (0, 0)][: picture.ndim], mode="edge")
