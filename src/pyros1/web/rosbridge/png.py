"""Packs frames into PNG images, which some networks and browsers handle faster than text, and unpacks them (no I/O).

A frame's bytes become the red, green and blue values of the pixels, row by row; the remaining values are filled with
newlines, which JSON ignores.
"""

from __future__ import annotations

import base64
import binascii
import io
import math
import zlib
from importlib import import_module
from typing import Any

import numpy as np

from pyros1.observe.png16 import make_file
from pyros1.web.rosbridge.operations import BridgeError

_COMPRESSION_LEVEL = 1
"""PNG compression level: higher levels take several times as long, and save only a few percent."""
_SAMPLES = 4
_SAMPLE_BYTES = 4096
"""How many parts of a frame, of which size, are tried to find out whether it has repetitions."""


def pack(text: str) -> str:
    """Return a PNG image that contains an ASCII string; the image is encoded in base64.

    The rows are compressed as they are. Pillow would first try five filters for each row, which doubles the time and
    does not help: filters are for pictures.
    """
    data = text.encode("ascii")
    pixels = max(1, math.ceil(len(data) / 3))
    width = math.isqrt(pixels)
    height = math.ceil(pixels / width)
    rows = np.empty((height, 1 + 3 * width), np.uint8)
    rows[:, 0] = 0  # no filter
    padded = data.ljust(3 * width * height, b"\n")
    rows[:, 1:] = np.frombuffer(padded, np.uint8).reshape(height, 3 * width)
    content = rows.tobytes()
    file = make_file(width, height, 8, 3, _compress(content, _strategy(content)))
    return str(binascii.b2a_base64(file, newline=False), "ascii")


def _strategy(data: bytes) -> int:
    """Return zlib's strategy for some data: base64 of noisy images hardly has repetitions, so searching for them would
    only take five times as long.
    """
    step = max(1, len(data) // _SAMPLES)
    sample = b"".join(data[start : start + _SAMPLE_BYTES] for start in range(0, len(data), step))
    without_search = len(_compress(sample, zlib.Z_HUFFMAN_ONLY))
    is_useless = without_search <= len(_compress(sample, zlib.Z_DEFAULT_STRATEGY))
    return zlib.Z_HUFFMAN_ONLY if is_useless else zlib.Z_DEFAULT_STRATEGY


def _compress(data: bytes, strategy: int) -> bytes:
    compressor = zlib.compressobj(_COMPRESSION_LEVEL, strategy=strategy)
    return compressor.compress(data) + compressor.flush()


def unpack(data: str, limit: int) -> bytes:
    """Return the UTF-8 string that a PNG image contains.

    Args:
        data: the image, in base64.
        limit: maximum size of the string in bytes. An image whose header announces more is not decoded.

    Raises:
        BridgeError: the data is not an image of this form, or Pillow is not installed.
    """
    pillow = _pillow()
    try:
        with pillow.open(io.BytesIO(base64.b64decode(data, validate=True)), formats=["PNG"]) as image:
            if image.width * image.height * 4 > limit * 4 // 3 or image.mode not in ("RGB", "RGBA"):
                raise BridgeError(f"a PNG image must be RGB and contain at most {limit} bytes")
            text: bytes = image.convert("RGB").tobytes()
            return text
    except (binascii.Error, OSError, ValueError, SyntaxError, pillow.DecompressionBombError) as error:
        raise BridgeError(f"the image cannot be read: {error}") from None


def _pillow() -> Any:
    try:
        return import_module("PIL.Image")
    except ImportError:
        raise BridgeError("images need Pillow: pip install 'pyros1[web]'") from None
