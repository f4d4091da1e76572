"""Reads an image's size from the file's header, since a small file may decode to more than fits in memory (no I/O)."""

from __future__ import annotations

import struct

MAX_PIXELS = 60_000_000
"""Maximum number of pixels of an image that the server or a page decodes."""
_MAX_SEGMENTS = 1_000
_STANDALONE_MARKERS = {0x01, *range(0xD0, 0xD9)}
"""JPEG markers that are not followed by a segment."""
_SIZE_MARKERS = {*range(0xC0, 0xD0)} - {0xC4, 0xC8, 0xCC}
"""JPEG markers whose segments contain the image's size."""


def image_size(data: bytes) -> tuple[int, int] | None:
    """Return the claimed width and height of a PNG, JPEG, WebP, GIF or BMP file; None for other files."""
    try:
        if data[:8] == b"\x89PNG\r\n\x1a\n":
            return struct.unpack_from(">II", data, 16)
        if data[:2] == b"\xff\xd8":
            return _jpeg_size(data)
        if data[:4] == b"RIFF" and data[8:12] == b"WEBP":
            return _webp_size(data)
        if data[:3] == b"GIF":
            return struct.unpack_from("<HH", data, 6)
        if data[:2] == b"BM":
            width, height = struct.unpack_from("<ii", data, 18)
            return abs(width), abs(height)
    except struct.error:
        pass  # the file is cut off
    return None


def _jpeg_size(data: bytes) -> tuple[int, int] | None:
    position = 2
    for _ in range(_MAX_SEGMENTS):
        position = data.find(b"\xff", position)
        while position >= 0 and data[position + 1 : position + 2] == b"\xff":
            position += 1
        marker = data[position + 1] if 0 <= position < len(data) - 1 else 0
        if not marker:
            return None
        position += 2
        if marker in _SIZE_MARKERS:
            height, width = struct.unpack_from(">HH", data, position + 3)
            return width, height
        if marker not in _STANDALONE_MARKERS:
            position += struct.unpack_from(">H", data, position)[0]
    return None


def _webp_size(data: bytes) -> tuple[int, int] | None:
    match data[12:16]:
        case b"VP8 ":
            width, height = struct.unpack_from("<HH", data, 26)
            return width & 0x3FFF, height & 0x3FFF
        case b"VP8L":
            bits = struct.unpack_from("<I", data, 21)[0]
            return (bits & 0x3FFF) + 1, (bits >> 14 & 0x3FFF) + 1
        case b"VP8X":
            width, height = struct.unpack("<II", data[24:27] + b"\0" + data[27:30] + b"\0")
            return width + 1, height + 1
    return None
