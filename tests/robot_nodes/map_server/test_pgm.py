from __future__ import annotations

from contextlib import suppress
from io import BytesIO
from tracemalloc import get_traced_memory, stop
from tracemalloc import start as start_tracing

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.robot_nodes.map_server.errors import MapDataError
from pyros1.robot_nodes.map_server.pgm import is_pgm, read_pgm, write_pgm

SHAPES = st.tuples(st.integers(1, 7), st.integers(1, 7))


@given(SHAPES, st.integers(1, 65535), st.integers(0, 2**32 - 1), st.booleans(), st.booleans())
def test_any_file(shape: tuple[int, int], maximum: int, seed: int, is_text: bool, has_comments: bool) -> None:
    height, width = shape
    values = np.random.default_rng(seed).integers(0, maximum, shape, endpoint=True)
    comment = "# 1 2 P5 \u00e9\n" if has_comments else ""
    header = f"{'P2' if is_text else 'P5'}\n{comment}{width} {comment}{height}\n{comment}{maximum}\n".encode()
    if is_text:
        data = header + comment.encode() + " ".join(map(str, values.ravel())).encode() + b"\n"
    else:
        data = header + values.astype(">u2" if maximum > 255 else "u1").tobytes()
    expected = [[int(value) * 255 // maximum for value in row] for row in values]
    assert read_pgm(data).tolist() == expected
    # Text that ends within the last number is read.
    for end in range(data.rstrip().rfind(b" ") + 1 if is_text else len(data)):
        with pytest.raises(MapDataError):
            read_pgm(data[:end])


@given(SHAPES, st.integers(0, 2**32 - 1))
def test_what_is_written_is_read_by_others(shape: tuple[int, int], seed: int) -> None:
    image = pytest.importorskip("PIL.Image")
    pixels = np.random.default_rng(seed).integers(0, 256, shape).astype(np.uint8)
    data = write_pgm(pixels, "CREATOR: test")
    assert is_pgm(data) and data.startswith(b"P5\n# CREATOR: test\n")
    assert np.array_equal(np.asarray(image.open(BytesIO(data))), pixels)
    assert np.array_equal(read_pgm(data), pixels)


@given(st.binary(max_size=60))
def test_garbage(data: bytes) -> None:
    for start in (b"", b"P2\n2 2\n255\n", b"P5 2 1 300 "):
        with suppress(MapDataError):
            assert read_pgm(start + data).dtype == np.uint8


@pytest.mark.parametrize(
    ("data", "problem"),
    [
        (b"", "damaged"),
        (b"P6\n1 1\n255\n\0\0\0", "damaged"),
        (b"P5\n1 1\n", "damaged"),
        (b"P5\n99999 99999\n255\n\0", "99999 x 99999 pixels"),
        (b"P5\n0 1\n255\n", "0 x 1 pixels"),
        (b"P5\n1 1\n65536\n\0\0", "up to 65536"),
        (b"P5\n3 1\n255\n\0\0", "cut off: it has 2 of 3 pixels"),
        (b"P5\n2 1\n256\n\0\0\0", "cut off: it has 1 of 2 pixels"),
        (b"P2\n2 1\n9\n1 x\n", "not numbers"),
        (b"P2\n2 1\n9\n1 -2\n", "not numbers"),
        (b"P2\n2 1\n9\n\xff\n", "not numbers"),
        (b"P2\n2 1\n9\n" + b"1 " * (1 << 25) + b"1", "more than 64 MiB must be binary"),
    ],
)
def test_damaged_files(data: bytes, problem: str) -> None:
    with pytest.raises(MapDataError, match=problem):
        read_pgm(data)


def test_values_above_the_maximum_are_white() -> None:
    assert read_pgm(b"P2 3 1 9 0 9 12").tolist() == [[0, 255, 255]]


@pytest.mark.parametrize("gap", [b" ", b"#\n"])
def test_an_endless_header_takes_little_memory(gap: bytes) -> None:
    data = b"P5" + gap * 300_000
    start_tracing()
    try:
        with pytest.raises(MapDataError, match="damaged"):
            read_pgm(data)
        assert get_traced_memory()[1] < 20_000_000
    finally:
        stop()
