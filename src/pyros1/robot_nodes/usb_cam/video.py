"""Videos from V4L2 devices, files, and other sources that libav reads."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any, Protocol

import numpy as np

from pyros1.ground.errors import Error

OPEN_TIMEOUT = 10.0
"""Maximum number of seconds to wait for a source."""
_INDEPENDENT = ("mjpeg", "rawvideo", "wrapped_avframe")
"""Codecs in which each image can be decoded independently."""


class VideoError(Error):
    """A video cannot be opened, or is broken."""


class VideoEndedError(VideoError):
    """A file has no more images."""


class Video(Protocol):
    """A source of images."""

    def read(self, is_wanted: bool) -> np.ndarray[Any, Any] | None:
        """Wait for the next image.

        Args:
            is_wanted: whether the image is needed; if not, it is not decoded if possible.

        Returns:
            An array of shape (height, width, 3), or (height, width) in grey; None if the image is not wanted.

        Raises:
            VideoEndedError: there are no more images.
            VideoError: the source is broken.
        """

    def close(self) -> None:
        """Close the source."""


class AvVideo:
    """A video, opened with PyAV.

    Args:
        source: the device, the file, or another source that the format needs.
        format: libav's name of the format, such as "v4l2"; None for any file.
        options: libav's options, such as "video_size".
        pixels: the pixel format of returned images: "rgb24", "bgr24" or "gray".

    Raises:
        VideoError: the source cannot be opened, or PyAV is not installed.
    """

    def __init__(self, source: str, format: str | None, options: Mapping[str, str], pixels: str) -> None:
        try:
            av: Any = import_module("av")  # an optional dependency
        except ImportError:
            raise VideoError("cameras need PyAV: pip install 'pyros1[video]'") from None
        self._source, self._pixels = source, pixels
        self._error: type[Exception] = av.FFmpegError
        try:
            self._container = av.open(source, format=format, options=dict(options), timeout=OPEN_TIMEOUT)
        except (av.FFmpegError, OSError, ValueError) as error:
            raise VideoError(_explain(source, options, error)) from None
        streams = self._container.streams.video
        if not streams:
            self._container.close()
            raise VideoError(f"{source} has no images")
        self._can_skip = streams[0].codec_context.name in _INDEPENDENT
        self._packets: Iterator[Any] = self._container.demux(streams[0])
        self._frames: list[Any] = []

    def read(self, is_wanted: bool) -> np.ndarray[Any, Any] | None:
        """Wait for the next image; see `Video`."""
        try:
            while not self._frames:
                packet = next(self._packets)
                if packet.size and self._can_skip and not is_wanted:
                    return None
                self._frames = packet.decode()
            frame = self._frames.pop(0)
            image: np.ndarray[Any, Any] = frame.to_ndarray(format=self._pixels)
        except (StopIteration, EOFError):
            raise VideoEndedError(f"{self._source} has ended") from None
        except (self._error, OSError, ValueError) as error:
            raise VideoError(f"{self._source}: {getattr(error, 'strerror', None) or error}") from None
        return image if is_wanted else None

    def close(self) -> None:
        """Close the source."""
        self._container.close()


def _explain(source: str, options: Mapping[str, str], error: Exception) -> str:
    if isinstance(error, FileNotFoundError):
        return f"there is no {source}: plug the camera in, or set the parameter for its device"
    if isinstance(error, PermissionError):
        return f"no permission to open {source}: sudo usermod -a -G video $USER, and log in again"
    text = getattr(error, "strerror", None) or str(error)
    wanted = ", ".join(f"{name} {value}" for name, value in options.items())
    return f"{source} cannot be opened with {wanted}: {text}; v4l2-ctl --list-formats-ext shows what a camera can"
