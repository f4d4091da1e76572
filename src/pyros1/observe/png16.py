"""Reads and writes PNG files with 16 bits per channel (https://www.w3.org/TR/png), since Pillow reads only the upper
byte of each channel of colour images.

PNG filters process each byte of a pixel separately. Therefore, the upper bytes of all channels form an 8-bit image, as
do the lower bytes, and Pillow can read both. This module has no side effects.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_HEADER = struct.Struct(">IIBBBBB")
_MODES = {0: "L", 2: "RGB", 4: "LA", 6: "RGBA"}
"""Pillow's mode for each colour type."""
_COLOUR_TYPES = {1: 0, 2: 4, 3: 2, 4: 6}
"""The colour type for each number of channels."""
_NOT_INTERLACED = ((0, 0, 1, 1),)
_INTERLACED = ((0, 0, 8, 8), (4, 0, 8, 8), (0, 4, 4, 8), (2, 0, 4, 4), (0, 2, 2, 4), (1, 0, 2, 2), (0, 1, 1, 2))
"""The first column and row of each pass, and the steps between columns and rows."""


class Header(NamedTuple):
    """The fields of the header chunk of a PNG file."""

    width: int
    height: int
    bits: int
    colour_type: int
    compression: int
    filter: int
    interlace: int


def parse_header(data: bytes) -> Header | None:
    """Parse the header of a PNG file; return None if the data is not a PNG file."""
    if not data.startswith(_SIGNATURE) or data[12:16] != b"IHDR" or len(data) < 29:
        return None
    return Header(*_HEADER.unpack_from(data, 16))


def read(data: bytes, pillow: Any) -> NDArray[np.uint16]:
    """Decode a PNG file with 16 bits per channel.

    Args:
        data: the contents of the file.
        pillow: the module PIL.Image.

    Returns:
        An array of shape (height, width, channels). The channels are grey or red, green and blue, and optionally alpha.

    Raises:
        ValueError: the file is damaged.
    """
    png_header = parse_header(data)
    if (
        png_header is None
        or png_header.bits != 16
        or png_header.colour_type not in _MODES
        or png_header.interlace > 1
        or png_header.compression
        or png_header.filter
    ):
        raise ValueError("not a PNG file with 16 bits per channel")
    mode = _MODES[png_header.colour_type]
    chunks = list(_read_chunks(data))
    passes = [
        (max(0, -(-(png_header.width - x) // column_step)), max(0, -(-(png_header.height - y) // row_step)))
        for x, y, column_step, row_step in (_INTERLACED if png_header.interlace else _NOT_INTERLACED)
    ]
    sizes = [(1 + 2 * len(mode) * width) * height if width else 0 for width, height in passes]
    rows = _decompress(b"".join(body for chunk_type, body in chunks if chunk_type == b"IDAT"), sum(sizes))
    upper, lower = (
        np.asarray(
            pillow.frombytes(mode, (png_header.width, png_header.height), part, "zip", mode, png_header.interlace)
        )
        for part in _split_bytes(
            rows, [(1 + 2 * len(mode) * width, size) for (width, _), size in zip(passes, sizes, strict=True)]
        )
    )
    pixels: NDArray[np.uint16] = (upper.astype(np.uint16) << 8 | lower).reshape(
        png_header.height, png_header.width, len(mode)
    )
    transparent_colours = [body for chunk_type, body in chunks if chunk_type == b"tRNS"]
    if transparent_colours and png_header.colour_type == 2 and len(transparent_colours[0]) >= 6:
        alpha = np.where((pixels == struct.unpack_from(">3H", transparent_colours[0])).all(axis=2), 0, 0xFFFF)
        pixels = np.dstack([pixels, alpha.astype(np.uint16)])
    return pixels


def write(pixels: NDArray[np.uint16], level: int = 6) -> bytes:
    """Return the contents of a PNG file with 16 bits per channel.

    Args:
        pixels: an array of shape (height, width, channels), see `read`.
        level: the compression level from 0 to 9.
    """
    height, width, channels = pixels.shape
    big_endian = pixels.astype(">u2", order="C").view(np.uint8).reshape(height, width, 2 * channels)
    rows = np.empty((height, 1 + width * 2 * channels), np.uint8)
    rows[:, 0] = 1  # filter type 1: each byte is the difference from the previous pixel's byte
    rows[:, 1:] = np.diff(big_endian, axis=1, prepend=np.uint8(0)).reshape(height, -1)
    return make_file(width, height, 16, channels, zlib.compress(rows.tobytes(), level))


def make_file(width: int, height: int, bits: int, channels: int, compressed_rows: bytes) -> bytes:
    """Return the contents of a PNG file.

    Args:
        width, height: the size in pixels.
        bits: bits per channel.
        channels: number of channels, see `read`.
        compressed_rows: the rows from top to bottom, each with its filter type before it, compressed with zlib.
    """
    header_body = _HEADER.pack(width, height, bits, _COLOUR_TYPES[channels], 0, 0, 0)
    return (
        _SIGNATURE
        + _make_chunk(b"IHDR", header_body)
        + _make_chunk(b"IDAT", compressed_rows)
        + _make_chunk(b"IEND", b"")
    )


def _make_chunk(chunk_type: bytes, body: bytes) -> bytes:
    return struct.pack(">I", len(body)) + chunk_type + body + struct.pack(">I", zlib.crc32(chunk_type + body))


def _read_chunks(data: bytes) -> Iterator[tuple[bytes, bytes]]:
    offset, chunk_type = len(_SIGNATURE), b""
    while chunk_type != b"IEND":
        if offset + 12 > len(data):
            raise ValueError("the file is truncated")
        (size,) = struct.unpack_from(">I", data, offset)
        chunk_type, body = data[offset + 4 : offset + 8], data[offset + 8 : offset + 8 + size]
        if data[offset + 8 + size : offset + 12 + size] != struct.pack(">I", zlib.crc32(chunk_type + body)):
            raise ValueError(f"invalid checksum at byte {offset}")
        yield chunk_type, body
        offset += 12 + size


def _decompress(data: bytes, size: int) -> bytes:
    """Decompress the rows of all passes, each of which is preceded by its filter type."""
    try:
        rows = zlib.decompressobj().decompress(data, size)
    except zlib.error as error:
        raise ValueError(str(error)) from None
    if len(rows) < size:
        raise ValueError(f"{len(rows)} bytes of pixels instead of {size}")
    return rows


def _split_bytes(rows: bytes, passes: list[tuple[int, int]]) -> Iterator[bytes]:
    """Yield the compressed data of two images: one of the upper bytes, one of the lower bytes.

    Args:
        rows: the rows of all passes.
        passes: the number of bytes per row and the total number of bytes of each pass.
    """
    for first_byte in (1, 2):
        offset, parts = 0, []
        for row_size, size in passes:
            block = np.frombuffer(rows, np.uint8, size, offset).reshape(-1, row_size)
            parts.append(np.hstack([block[:, :1], block[:, first_byte::2]]).tobytes())
            offset += size
        yield zlib.compress(b"".join(parts), 0)
