"""PNG files with 16 bits per channel (https://www.w3.org/TR/png): for colours, Pillow reads only the upper bytes.

The filters of PNG work on each byte of a pixel separately. So the upper bytes of all channels are an 8-bit image, and
so are the lower bytes, and Pillow can read both. Pure except for numpy and Pillow.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_HEAD = struct.Struct(">IIBBBBB")
_MODES = {0: "L", 2: "RGB", 4: "LA", 6: "RGBA"}
"""Colour type -> Pillow's mode."""
_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}
"""Number of channels -> colour type."""
_WHOLE = ((0, 0, 1, 1),)
_INTERLACED = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""First column and row, and steps between columns and rows, of each pass."""


class Header(NamedTuple):
    """The first chunk of a PNG file."""

    width: int
    height: int
    bits: int
    colour: int
    compression: int
    filter: int
    interlace: int


def header(data: bytes) -> Header | None:
    """Return the header of a PNG file; None if it is not a PNG file."""
    if not data.startswith(_SIGNATURE) or data[12:16] != b"IHDR" or len(data) < 29:
        return None
    return Header(*_HEAD.unpack_from(data, 16))


def read(data: bytes, pillow: Any) -> NDArray[np.uint16]:
    """Return the pixels of a PNG file with 16 bits per channel.

    Args:
        data: the file.
        pillow: the module PIL.Image.

    Returns:
        An array of shape (height, width, channels): grey, or red, green and blue, and opacity.

    Raises:
        ValueError: it is damaged.
    """
    head = header(data)
    if (
        head is None
        or head.bits != 16
        or head.colour not in _MODES
        or head.interlace > 1
        or head.compression
        or head.filter
    ):
        raise ValueError("no PNG file with 16 bits per channel")
    mode = _MODES[head.colour]
    chunks = list(_chunks(data))
    passes = [
        (max(0, -(-(head.width - x) // across)), max(0, -(-(head.height - y) // down)))
        for x, y, across, down in (_INTERLACED if head.interlace else _WHOLE)
    ]
    sizes = [(1 + 2 * len(mode) * width) * height if width else 0 for width, height in passes]
    rows = _unpacked(b"".join(body for kind, body in chunks if kind == b"IDAT"), sum(sizes))
    upper, lower = (
        np.asarray(pillow.frombytes(mode, (head.width, head.height), part, "zip", mode, head.interlace))
        for part in _halves(
            rows, [(1 + 2 * len(mode) * width, size) for (width, _), size in zip(passes, sizes, strict=True)]
        )
    )
    pixels: NDArray[np.uint16] = (upper.astype(np.uint16) << 8 | lower).reshape(head.height, head.width, len(mode))
    clear = [body for kind, body in chunks if kind == b"tRNS"]
    if clear and head.colour == 2 and len(clear[0]) >= 6:
        opacity = np.where((pixels == struct.unpack_from(">3H", clear[0])).all(axis=2), 0, 0xFFFF)
        pixels = np.dstack([pixels, opacity.astype(np.uint16)])
    return pixels


def write(pixels: NDArray[np.uint16], level: int = 6) -> bytes:
    """Return a PNG file with 16 bits per channel.

    Args:
        pixels: array of shape (height, width, channels); see `read`.
        level: compression level, from 0 to 9.
    """
    height, width, channels = pixels.shape
    big = pixels.astype(">u2", order="C").view(np.uint8).reshape(height, width, 2 * channels)
    rows = np.empty((height, 1 + width * 2 * channels), np.uint8)
    rows[:, 0] = 1  # each byte is the difference from the previous pixel's byte
    rows[:, 1:] = np.diff(big, axis=1, prepend=np.uint8(0)).reshape(height, -1)
    head = _HEAD.pack(width, height, 16, _TYPES[channels], 0, 0, 0)
    body = zlib.compress(rows.tobytes(), level)
    return _SIGNATURE + _chunk(b"IHDR", head) + _chunk(b"IDAT", body) + _chunk(b"IEND", b"")


def _chunk(kind: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))


def _chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    at, kind = len(_SIGNATURE), b""
    while kind != b"IEND":
        if at + 12 > len(data):
            raise ValueError("the file is cut off")
        (size,) = struct.unpack_from(">I", data, at)
        kind, body = data[at + 4 : at + 8], data[at + 8 : at + 8 + size]
        if data[at + 8 + size : at + 12 + size] != struct.pack(">I", zlib.crc32(kind + body)):
            raise ValueError(f"a checksum is wrong at byte {at}")
        yield kind, body
        at += 12 + size


def _unpacked(data: bytes, size: int) -> bytes:
    """Return the rows of all passes, each with its filter before it."""
    try:
        rows = zlib.decompressobj().decompress(data, size)
    except zlib.error as error:
        raise ValueError(str(error)) from None
    if len(rows) < size:
        raise ValueError(f"{len(rows)} bytes of pixels instead of {size}")
    return rows


def _halves(rows: bytes, passes: list[tuple[int, int]]) -> Iterator[bytes]:
    """Yield the data of two images: of the upper bytes and of the lower ones.

    Args:
        rows: the rows of all passes.
        passes: bytes per row, and in all, of each pass.
    """
    for half in (1, 2):
        at, part = 0, []
        for step, size in passes:
            block = np.frombuffer(rows, np.uint8, size, at).reshape(-1, step)
            part.append(np.hstack([block[:, :1], block[:, half::2]]).tobytes())
            at += size
        yield zlib.compress(b"".join(part), 0)
