"""Image files with all their bits. Beside OpenCV: interop/modules/test_image_files.py."""

from __future__ import annotations

import io
import random
import struct
import tracemalloc
import warnings
import zlib

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from pyros1.ground.errors import MessageError

pytest.importorskip("PIL", reason="the extra `images` brings it")

from PIL import Image as Pictures

from pyros1.observe import png16
from pyros1.observe.compressed_depth import decode_depth
from pyros1.observe.image_files import Pixels, UnsupportedFileError, decode, encode, to_uint8

SHAPES = st.tuples(st.integers(1, 9), st.integers(1, 9), st.sampled_from([1, 2, 3, 4]))


def a_file(picture: Pictures.Image, form: str) -> bytes:
    file = io.BytesIO()
    picture.save(file, form)
    return file.getvalue()


@given(SHAPES.flatmap(lambda shape: arrays(np.uint16, shape)))
def test_sixteen_bits_per_channel(pixels: Pixels) -> None:
    data = png16.write(pixels, 1)
    assert np.array_equal(png16.read(data, Pictures), pixels)
    with Pictures.open(io.BytesIO(data)) as picture:  # it reads the upper bytes of colours
        if pixels.shape[2] > 2:
            assert np.array_equal(np.asarray(picture), pixels >> 8)


@given(st.sampled_from(["u1", "u2"]), SHAPES.filter(lambda shape: shape[2] != 2), st.randoms())
def test_png_keeps_everything(kind: str, shape: tuple[int, int, int], dice: random.Random) -> None:
    pixels = np.frombuffer(dice.randbytes(int(np.prod(shape)) * int(kind[1])), kind).reshape(shape)
    found = decode(encode(pixels, "png"))
    assert found.dtype == kind and np.array_equal(found, pixels if shape[2] > 1 else pixels[:, :, 0])


def test_depths_in_millimetres() -> None:
    depths = np.array([[0, 2500], [40000, 65535]], np.uint16)
    assert decode(encode(depths, "png")).tolist() == depths.tolist()
    assert decode(encode(depths.astype(">u2"), "png")).tolist() == depths.tolist()


def test_few_bits_palettes_and_opacity() -> None:
    grey = Pictures.fromarray(np.array([[0, 100], [200, 255]], np.uint8))
    assert decode(a_file(grey.convert("1"), "PNG")).tolist() == np.asarray(grey.convert("1").convert("L")).tolist()
    assert decode(a_file(grey.convert("LA"), "PNG")).shape == (2, 2, 4)
    palette = grey.convert("RGB").convert("P", palette=Pictures.Palette.ADAPTIVE)
    assert decode(a_file(palette, "PNG"))[1, 1].tolist() == [255, 255, 255]


def test_a_jpeg_file_that_is_cut_off_is_read_as_far_as_it_goes() -> None:
    data = encode(np.full((64, 64, 3), 200, np.uint8), "jpg", quality=95)
    whole, cut = decode(data), decode(data[: len(data) - 12])
    assert cut.shape == whole.shape and np.array_equal(cut[:8], whole[:8])


def test_damaged_files() -> None:
    whole = png16.write(np.full((5, 4, 3), 513, np.uint16))
    bomb = whole[:16] + struct.pack(">II", 60_000, 60_000) + whole[24:29]
    bomb += struct.pack(">I", zlib.crc32(bomb[12:29])) + whole[33:]
    for data in (b"", b"nothing", whole[:-13], whole[:40], whole[:45] + b"x" + whole[46:], bomb):
        with pytest.raises(MessageError):
            decode(data)
    with pytest.raises(MessageError, match="too large"):
        decode(whole, max_pixels=79)
    with pytest.raises(MessageError, match="too large"):  # Pillow takes the second header
        decode(bomb[:33] + whole[8:])


def blank(width: int, height: int) -> bytes:
    """Return a PNG file without pixels."""
    head = b"IHDR" + struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    chunks = [head, b"IDAT"]
    packed = [struct.pack(">I", len(chunk) - 4) + chunk + struct.pack(">I", zlib.crc32(chunk)) for chunk in chunks]
    return b"\x89PNG\r\n\x1a\n" + b"".join(packed)


@pytest.mark.parametrize(("width", "height"), [(12_000, 10_000), (50_000, 50_000)])
def test_our_limit_is_named_and_pillow_prints_nothing(width: int, height: int) -> None:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(2):
            with pytest.raises(MessageError, match=r"image.* is too large: at most 100000000 pixels can be read"):
                decode(blank(width, height), max_pixels=100_000_000)
    assert not caught


@pytest.mark.parametrize("form", ["JPEG", "TIFF"])
def test_pictures_for_printers_take_little_memory(form: str) -> None:
    pixels = np.random.default_rng(1).integers(0, 256, (600, 700, 4), np.uint8)
    data = a_file(Pictures.fromarray(pixels, "CMYK"), form)
    tracemalloc.start()
    try:
        found = decode(data)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert found.shape[:2] == (600, 700)
    assert peak / (600 * 700) < 20  # bytes per pixel


def test_tiff_with_opacity() -> None:
    """As OpenCV reads it: colours are multiplied by the opacity; of grey, only the grey is read."""
    pixels = np.array([[[200, 100, 50, 128], [255, 255, 255, 0]]], np.uint8)
    assert decode(a_file(Pictures.fromarray(pixels), "TIFF")).tolist() == [[[100, 50, 25, 128], [0, 0, 0, 0]]]
    grey = Pictures.fromarray(pixels).convert("LA")
    assert decode(a_file(grey, "TIFF")).tolist() == np.asarray(grey)[:, :, 0].tolist()
    black = Pictures.fromarray(np.array([[[0, 100, 255, 51]]], np.uint8), "CMYK")
    assert decode(a_file(black, "TIFF")).tolist() == [[[204, 124, 0, 255]]]


def test_what_pillow_would_cut_is_refused() -> None:
    with pytest.raises(UnsupportedFileError, match=r"colour PPM file with more than 8 bits .* send PNG instead"):
        decode(b"P6\n1 1\n65535\n\1\2\3\4\5\6")
    with pytest.raises(MessageError, match=r"uint16 .* cannot be written as tiff"):
        encode(np.zeros((1, 1, 3), np.uint16), "tiff")
    for shape in ((0, 3), (2, 2, 2), (2, 2, 5)):
        with pytest.raises(MessageError, match="shape"):
            encode(np.zeros(shape, np.uint8), "png")
    with pytest.raises(MessageError, match="nope"):
        encode(np.zeros((2, 2), np.uint8), "nope")


def test_other_numbers_become_the_nearest_bytes() -> None:
    assert to_uint8(np.array([-1, 1.5, 2.5, 300, np.nan, 1e20])).tolist() == [0, 2, 2, 255, 0, 0]
    assert to_uint8(np.array([-7, 8, 70000], np.int32)).tolist() == [0, 8, 255]


def test_compressed_depths() -> None:
    file = encode(np.array([[300, 0]], np.uint16), "png")
    assert decode_depth("16UC1; compressedDepth png", bytes(12) + file).tolist() == [[300, 0]]
    metres = decode_depth("32FC1; compressedDepth", struct.pack("<iff", 0, 100.0, 50.0) + file)
    assert metres[0, 0] == np.float32(0.4) and np.isnan(metres[0, 1])
    for form, data in (
        ("16UC1; png", file),
        ("8UC1; compressedDepth", file),
        ("16UC1; compressedDepth rvl", bytes(30)),
    ):
        with pytest.raises(MessageError):
            decode_depth(form, data)
