"""Reads and writes PGM, the image format of most maps, without Pillow (no I/O).

See https://netpbm.sourceforge.net/doc/pgm.html.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from pyros1.robot_nodes.map_server.errors import MapDataError

MAX_PIXELS = 1 << 27
"""Maximum number of pixels of an image."""
_MAX_TEXT_BYTES = 1 << 26
_MAX_HEADER_BYTES = 1 << 16
"""Limits memory: matching a gap takes a hundred bytes for each of its characters."""
_WHITE = 255
_GAP = rb"(?:\s|#[^\r\n]*[\r\n])+"
_HEADER = re.compile(rb"(P[25])" + 3 * (_GAP + rb"(\d{1,9})") + rb"(?:#[^\r\n]*[\r\n]|\s)")
_COMMENT = re.compile(rb"#[^\r\n]*")
_NUMBERS = re.compile(rb"[0-9\s]*")


def is_pgm(data: bytes) -> bool:
    """Return whether a file begins like a PGM file."""
    return data[:2] in (b"P2", b"P5")


def read_pgm(data: bytes) -> NDArray[np.uint8]:
    """Read a PGM file: binary (P5) or text (P2), with 8 or 16 bits.

    As in SDL, which the original uses to read maps, brightness is scaled to 0 ... 255. SDL rejects 16 bits.

    Returns:
        The brightness of the pixels, with shape (height, width), the upper row first.

    Raises:
        MapDataError: the file is damaged, or has more than `MAX_PIXELS` pixels.
    """
    header = _HEADER.match(data, 0, _MAX_HEADER_BYTES)
    if header is None:
        raise MapDataError("the PGM file is damaged: it needs P2 or P5, its width, height and maximum value")
    width, height, maximum = (int(header[number]) for number in (2, 3, 4))
    count = width * height
    if not 0 < count <= MAX_PIXELS or not 0 < maximum < 1 << 16:
        raise MapDataError(f"a PGM file of {width} x {height} pixels up to {maximum} cannot be read")
    raster = data[header.end() :]
    values: NDArray[np.unsignedinteger] = (
        _read_text(raster, count) if header[1] == b"P2" else _read_binary(raster, count, maximum)
    )
    if len(values) < count:
        raise MapDataError(f"the PGM file is cut off: it has {len(values)} of {count} pixels")
    values = np.minimum(values, maximum)
    if maximum != _WHITE:
        values = values.astype(np.uint32) * np.uint32(_WHITE) // maximum
    return values.astype(np.uint8).reshape(height, width)


def _read_binary(raster: bytes, count: int, maximum: int) -> NDArray[np.unsignedinteger]:
    dtype = np.dtype(np.uint8) if maximum <= _WHITE else np.dtype(">u2")
    return np.frombuffer(raster, dtype, min(count, len(raster) // dtype.itemsize))


def _read_text(raster: bytes, count: int) -> NDArray[np.unsignedinteger]:
    if len(raster) > _MAX_TEXT_BYTES:
        raise MapDataError(f"a PGM file of more than {_MAX_TEXT_BYTES >> 20} MiB must be binary (P5)")
    text = (_COMMENT.sub(b" ", raster) if b"#" in raster else raster).strip()
    if not _NUMBERS.fullmatch(text):
        raise MapDataError("the PGM file is damaged: its pixels are not numbers")
    values = np.fromstring(text.decode(), np.int64, sep=" ") if text else np.zeros(0, np.int64)
    return values[:count].astype(np.uint64)


def write_pgm(pixels: NDArray[np.uint8], comment: str) -> bytes:
    """Return a binary PGM file.

    Args:
        pixels: brightness, with shape (height, width), the upper row first.
        comment: a line of text to put into the file.
    """
    height, width = pixels.shape
    return f"P5\n# {comment}\n{width} {height}\n255\n".encode() + pixels.tobytes()
