"""Writes videos from sensor_msgs/Image and CompressedImage messages; the frames keep the timing of the bag."""

from __future__ import annotations

import errno
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from fractions import Fraction
from typing import Any

import numpy as np

from pyros1.bag.export.extras import import_extra
from pyros1.bag.export.image_files import IMAGE_TYPES, compressed_pixels
from pyros1.bag.export.images import Pixels, pixels, to_8_bits
from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time

_TICK = Fraction(1, 1_000_000)
_CODECS = ("libx264", "mpeg4")
_X264_OPTIONS = {"crf": "20", "preset": "fast"}


class VideoWriter:
    """Writes the images of each topic to a separate video.

    Args:
        topic_path: returns the path of a topic's file; its extension determines the format: ``.mp4``, ``.mkv``, ...

    Raises:
        Error: PyAV or Pillow is not installed.
    """

    def __init__(self, topic_path: Callable[[str], str]) -> None:
        self._av = import_extra("av", "video")
        import_extra("PIL.Image", "video")
        self._topic_path = topic_path
        self._videos: dict[str, _Video] = {}

    def write_message(self, topic: str, message: Any, time: Time) -> None:
        """Write a frame.

        Args:
            topic: its topic.
            message: an Image or a CompressedImage.
            time: its time in the bag.

        Raises:
            MessageError: the image is damaged, its encoding is not supported, or its size differs from that of earlier
                frames.
            OSError: the file cannot be written.
        """
        image = pixels(message) if message._type == IMAGE_TYPES[0] else compressed_pixels(message)
        image = _pad_to_even(to_8_bits(image))
        video = self._videos.get(topic)
        with self._as_os_errors(topic):
            if video is None:
                video = self._videos[topic] = _Video(self._av, self._topic_path(topic), image, time)
            video.write(image, time)

    def close(self) -> None:
        """Write the remaining data, and close the files.

        Raises:
            OSError: the file cannot be written.
        """
        for topic, video in self._videos.items():
            with self._as_os_errors(topic):
                video.finish()

    def abort(self) -> None:
        """Close the files in their current state."""
        for video in self._videos.values():
            with suppress(self._av.error.FFmpegError):
                video.container.close()

    @contextmanager
    def _as_os_errors(self, topic: str) -> Iterator[None]:
        """Raise PyAV's errors as OSError, with the path of the topic's file."""
        try:
            yield
        except self._av.error.FFmpegError as error:
            raise OSError(error.errno or errno.EIO, str(error.strerror), self._topic_path(topic)) from error


class _Video:
    def __init__(self, av: Any, path: str, image: Pixels, time: Time) -> None:
        self._av = av
        self._begin_ns = time.to_nsec()
        self._last_pts = -1
        self._size = image.shape[:2]
        self.container = av.open(path, "w")
        # The video begins at 0 s; this is the corresponding clock time.
        self.container.metadata["comment"] = f"begins at {time.secs}.{time.nsecs:09d}"
        codec = next(name for name in _CODECS if name in av.codecs_available)
        self._stream = self.container.add_stream(codec, rate=30)
        self._stream.height, self._stream.width = self._size
        self._stream.pix_fmt = "yuv420p"
        self._stream.codec_context.time_base = _TICK
        if codec == _CODECS[0]:
            self._stream.options = _X264_OPTIONS

    def write(self, image: Pixels, time: Time) -> None:
        if image.shape[:2] != self._size:
            (height, width), (rows, columns) = self._size, image.shape[:2]
            raise MessageError(f"the image has {columns} x {rows} pixels, but earlier images have {width} x {height}")
        pixel_format = "gray" if image.ndim == 2 else "rgb24" if image.shape[2] == 3 else "rgba"
        frame = self._av.VideoFrame.from_ndarray(np.ascontiguousarray(image), format=pixel_format)
        self._last_pts = max((time.to_nsec() - self._begin_ns) // 1000, self._last_pts + 1)
        frame.pts, frame.time_base = self._last_pts, _TICK
        self.container.mux(self._stream.encode(frame))

    def finish(self) -> None:
        self.container.mux(self._stream.encode(None))
        self.container.close()


def _pad_to_even(image: Pixels) -> Pixels:
    """Return the image with an even width and height, as videos require; the last row or column is repeated if
    needed.
    """
    height, width = image.shape[:2]
    if not height % 2 and not width % 2:
        return image
    return np.pad(image, [(0, height % 2), (0, width % 2), (0, 0)][: image.ndim], mode="edge")
