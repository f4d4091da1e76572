from __future__ import annotations

import random
import tracemalloc
from contextlib import suppress
from time import process_time

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError
from pyros1.observe.rvl import decode_rvl, encode_rvl


def reference(depths: list[int]) -> bytes:
    """Compress depths as the paper describes it, one number after the other."""
    groups: list[int] = []

    def write(number: int) -> None:
        while True:
            number, low = number >> 3, number & 7
            groups.append(low | (8 if number else 0))
            if not number:
                return

    at = previous = 0
    while at < len(depths):
        begin = at
        while at < len(depths) and not depths[at]:
            at += 1
        write(at - begin)
        begin = at
        while at < len(depths) and depths[at]:
            at += 1
        write(at - begin)
        for depth in depths[begin:at]:
            change, previous = depth - previous, depth
            write(2 * change if change >= 0 else -2 * change - 1)
    groups += [0] * (-len(groups) % 8)
    words = [groups[i : i + 8] for i in range(0, len(groups), 8)]
    return b"".join(
        sum(group << (28 - 4 * place) for place, group in enumerate(word)).to_bytes(4, "little") for word in words
    )


DEPTHS = st.lists(st.sampled_from([0, 0, 0, 1, 7, 8, 500, 501, 65535]) | st.integers(0, 65535), min_size=1, max_size=60)


@given(DEPTHS)
def test_as_the_paper_describes(depths: list[int]) -> None:
    data = encode_rvl(np.array(depths, np.uint16))
    assert data == reference(depths)
    assert decode_rvl(data, len(depths)).tolist() == depths


def test_a_picture() -> None:
    rng = np.random.default_rng(1)
    rows, columns = np.mgrid[0:480, 0:640]
    depths: NDArray[np.uint16] = (1000 + rows * 2 + columns + rng.integers(0, 4, (480, 640))).astype(np.uint16)
    depths[rng.random((480, 640)) < 0.01] = 0
    begin = process_time()
    data = encode_rvl(depths)
    assert np.array_equal(decode_rvl(data, depths.size).reshape(depths.shape), depths)
    assert process_time() - begin < 5.0 and len(data) < depths.nbytes / 1.5


@given(st.binary(max_size=64), st.integers(1, 500))
def test_any_data(data: bytes, size: int) -> None:
    with suppress(MessageError):
        assert decode_rvl(data, size).shape == (size,)


def test_damaged_data() -> None:
    data = encode_rvl(np.arange(1, 300, dtype=np.uint16))
    for end in range(0, len(data) - 4, 4):
        with pytest.raises(MessageError):
            decode_rvl(data[:end], 299)
    choose = random.Random(1)
    for _ in range(200):
        damaged = bytearray(data)
        damaged[choose.randrange(len(data))] = choose.randrange(256)
        with suppress(MessageError):
            decode_rvl(bytes(damaged), 299)
    with pytest.raises(MessageError):
        decode_rvl(bytes(1000), 299)  # runs of no length


def test_large_images_are_decoded_with_little_memory() -> None:
    depths = np.random.default_rng(3).integers(1, 65536, 100_000).astype(np.uint16)
    data = encode_rvl(depths)
    tracemalloc.start()
    try:
        assert (decode_rvl(data, depths.size) == depths).all()
        assert tracemalloc.get_traced_memory()[1] < 30 * len(data)
    finally:
        tracemalloc.stop()


def test_what_follows_an_image_takes_no_memory() -> None:
    depths = np.array([0, 65535, 0, 1, 65535, 1] * 10, np.uint16)
    data = encode_rvl(depths) + bytes(8_000_000)
    tracemalloc.start()
    try:
        assert decode_rvl(data, depths.size).tolist() == depths.tolist()
        assert tracemalloc.get_traced_memory()[1] < 1_000_000
    finally:
        tracemalloc.stop()


def test_many_short_runs() -> None:
    depths = np.zeros(1 << 16, np.uint16)
    depths[::2] = 7
    assert (decode_rvl(encode_rvl(depths), depths.size) == depths).all()
