"""Writes image files from messages of the types sensor_msgs/Image and CompressedImage."""

from __future__ import annotations

import os
import re
from io import BytesIO
from pathlib import Path
from typing import Any

from pyros1.bag.export.extras import import_extra
from pyros1.bag.export.file_names import TopicFileNames
from pyros1.bag.export.images import Pixels, pixels
from pyros1.ground.errors import MessageError
from pyros1.ground.timing import Time
from pyros1.observe import png16
from pyros1.observe.compressed_depth import DEPTH_HEADER, decode_depth
from pyros1.observe.image_files import MAX_PIXELS, decode

IMAGE_TYPES = ("sensor_msgs/Image", "sensor_msgs/CompressedImage")
"""Types of image messages."""

_EXTENSION_BY_SIGNATURE = {
    b"\xff\xd8": "jpg",
    b"\x89PNG": "png",
    b"BM": "bmp",
    b"II*\0": "tiff",
    b"MM\0*": "tiff",
    b"RIFF": "webp",
}


class ImageFileWriter:
    """Writes images to ``folder/<topic>/<stamp>.png``; the stamp is the one in the header, or the time in the bag if
    the stamp is 0.

    Images whose pixel type PNG cannot store become TIFF files. Compressed images are written unchanged, except that
    compressed 32FC1 depth images become TIFF files in metres.

    Args:
        folder: the folder to create.
        mosaic: whether to write Bayer images as they are, instead of computing colours.

    Raises:
        Error: Pillow is not installed.
    """

    def __init__(self, folder: str | os.PathLike[str], *, mosaic: bool = False) -> None:
        self._pil_image = import_extra("PIL.Image", "images")
        self._folder = Path(folder)
        self._mosaic = mosaic
        self._names = TopicFileNames()
        self._duplicates: dict[str, int] = {}
        self._folder.mkdir()

    def write_message(self, topic: str, message: Any, time: Time) -> None:
        """Write an image.

        Args:
            topic: its topic.
            message: a message of one of the `IMAGE_TYPES`.
            time: its time in the bag.

        Raises:
            MessageError: the image is damaged, or its encoding is not supported.
            OSError: the file cannot be written, for example because the disk is full.
        """
        stamp = message.header.stamp if message.header.stamp else time
        if message._type == IMAGE_TYPES[0]:
            image = pixels(message, mosaic=self._mosaic)
            extension = lossless_extension(image, str(message.encoding))
            if image.dtype == "u2" and image.ndim == 3:
                data = png16.write(image)
            else:
                data = _encode(
                    self._pil_image.fromarray(image.astype("i4") if image.dtype == "i2" else image), extension
                )
        elif _is_float_depth(str(message.format)):
            extension = "tiff"
            data = _encode(self._pil_image.fromarray(compressed_pixels(message)), extension)
        else:
            data, extension = image_file(message)
        self._unused_path(topic, stamp, extension).write_bytes(data)

    def close(self) -> None:
        """Do nothing: every image is already written."""

    def abort(self) -> None:
        """Do nothing: no file is open."""

    def _unused_path(self, topic: str, stamp: Time, extension: str) -> Path:
        folder = self._folder / self._names[topic]
        folder.mkdir(exist_ok=True)
        stem = f"{stamp.secs}.{stamp.nsecs:09d}"
        if (folder / f"{stem}.{extension}").exists():
            number = self._duplicates[f"{topic} {stem}"] = self._duplicates.get(f"{topic} {stem}", 1) + 1
            stem = f"{stem}_{number}"
        return folder / f"{stem}.{extension}"


def lossless_extension(image: Pixels, encoding: str) -> str:
    """Return the extension of a file type that can store an image without loss.

    Raises:
        MessageError: neither PNG nor TIFF can store it.
    """
    channels = 1 if image.ndim == 2 else image.shape[2]
    if image.dtype in ("u1", "u2") and channels in (1, 3, 4):
        return "png"
    if channels == 1 and image.dtype in ("i2", "i4", "f4"):
        return "tiff"
    raise MessageError(f"PNG and TIFF files cannot store images of the encoding {encoding!r}; try --format video")


def image_file(message: Any) -> tuple[bytes, str]:
    """Return the content of an image file, and the extension for the file's name.

    Args:
        message: a sensor_msgs/CompressedImage.

    Raises:
        MessageError: the image is empty, or is a compressed depth image other than a 16UC1 PNG.
    """
    data, format_text = bytes(message.data), str(message.format)
    if "compressedDepth" in format_text:
        if not format_text.startswith("16UC1") or not data[DEPTH_HEADER.size :].startswith(b"\x89PNG"):
            raise MessageError(f"depth images of the format {format_text!r} are not supported, only 16UC1")
        data = data[DEPTH_HEADER.size :]
    if not data:
        raise MessageError("the compressed image is empty")
    for signature, extension in _EXTENSION_BY_SIGNATURE.items():
        if data.startswith(signature):
            return data, extension
    codec_name = re.search(r"[A-Za-z]\w*", format_text.rpartition(";")[2])
    return data, codec_name[0].lower() if codec_name else "bin"


def compressed_pixels(message: Any, max_pixels: int = MAX_PIXELS) -> Pixels:
    """Return the pixels of a sensor_msgs/CompressedImage, as `decode` does, or `decode_depth` for compressed depth
    images.

    Raises:
        MessageError: the image cannot be decoded.
        Error: Pillow is not installed.
    """
    format_text, data = str(message.format), bytes(message.data)
    return decode_depth(format_text, data, max_pixels) if "compressedDepth" in format_text else decode(data, max_pixels)


def _is_float_depth(format_text: str) -> bool:
    return "compressedDepth" in format_text and format_text.startswith("32FC1")


def _encode(image: Any, extension: str) -> bytes:
    file = BytesIO()
    image.save(file, extension.upper())
    return file.getvalue()
