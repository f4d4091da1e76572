"""Sizes that pictures claim to have."""

from __future__ import annotations

import struct
from io import BytesIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from pyros1.web.transforms.image_size import MAX_PIXELS, image_size

_BEGINS = [b"", b"\x89PNG\r\n\x1a\n", b"\xff\xd8", b"\xff\xd8\xff\xe0", b"GIF89a", b"BM", b"RIFF....WEBP"]


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("PNG", {}),
        ("JPEG", {}),
        ("JPEG", {"progressive": True, "comment": b"x" * 60_000}),
        ("WEBP", {}),
        ("WEBP", {"lossless": True}),
        ("GIF", {}),
        ("BMP", {}),
    ],
)
def test_sizes_of_files(kind: str, options: dict[str, object]) -> None:
    file = BytesIO()
    Image.new("RGB", (123, 45)).save(file, kind, **options)
    assert image_size(file.getvalue()) == (123, 45)
    assert image_size(file.getvalue()[:8]) is None


def bomb(width: int, height: int) -> bytes:
    """Return the head of a PNG file."""
    return b"\x89PNG\r\n\x1a\n" + struct.pack(">I4sII", 13, b"IHDR", width, height) + bytes(9)


def test_bombs() -> None:
    assert image_size(bomb(100_000, 100_000)) == (100_000, 100_000)
    jpeg = b"\xff\xd8\xff\xe0\x00\x10" + bytes(14) + b"\xff\xff\xc2\x00\x11\x08" + struct.pack(">HH", 65_535, 65_535)
    assert image_size(jpeg) == (65_535, 65_535)
    assert MAX_PIXELS < 65_535**2


@given(st.sampled_from(_BEGINS), st.binary(max_size=200))
def test_any_bytes(begin: bytes, rest: bytes) -> None:
    size = image_size(begin + rest)
    assert size is None or (len(size) == 2 and min(size) >= 0)


def test_many_segments_are_not_read() -> None:
    assert image_size(b"\xff\xd8" + b"\xff\xe0\x00\x02" * 100_000) is None
    assert image_size(b"\xff\xd8" + b"\xff" * 1_000_000) is None
