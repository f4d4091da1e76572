"""RVL, a fast lossless compression of depth images (A. Wilson, "Fast Lossless Depth Image Compression", 2017).

An image is a sequence of runs: the number of zeros, the number of other values, and these as differences from the value
before. Numbers are written three bits at a time, the lowest first, in groups of four bits whose highest says that more
follow; 32-bit words have eight groups, from the highest to the lowest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError

_MAX_GROUPS = 11
"""Maximum number of groups of a number: 33 bits."""
_BLOCK = 4096
"""Words that are decoded at a time: each becomes up to eight numbers of 64 bits, several times."""
_MAX_BYTES_PER_PIXEL = 4
"""A run of one pixel: two groups for its lengths, and six for the difference. What follows the image is not read."""
_SHIFTS = np.arange(28, -1, -4, dtype=np.uint32)


def encode_rvl(pixels: NDArray[np.uint16]) -> bytes:
    """Compress depths, in an array of any shape. Return whole words."""
    depths = pixels.astype(np.int64).ravel()
    is_known = depths != 0
    edges = np.flatnonzero(np.diff(is_known)) + 1
    bounds = np.concatenate([[0], edges, [depths.size]])
    if depths.size and is_known[0]:
        bounds = np.concatenate([[0], bounds])
    lengths = np.diff(bounds)
    if lengths.size % 2:
        lengths = np.append(lengths, 0)
    differences = np.diff(depths[is_known], prepend=0)
    known = lengths[1::2]
    starts = np.cumsum(known) - known
    numbers = np.insert((differences << 1) ^ (differences >> 63), np.repeat(starts, 2), lengths)
    return _pack(numbers)


def _pack(numbers: NDArray[np.int64]) -> bytes:
    counts = np.ones(numbers.size, np.int64)
    for group in range(1, _MAX_GROUPS):
        counts += (numbers >> (3 * group)) > 0
    places = _places(counts)
    groups = (np.repeat(numbers, counts) >> (3 * places)) & 7
    groups |= np.where(places + 1 < np.repeat(counts, counts), 8, 0)
    words = np.append(groups, np.zeros(-groups.size % 8, np.int64)).astype(np.uint32).reshape(-1, 8)
    return bytes(np.bitwise_or.reduce(words << _SHIFTS, axis=1).astype("<u4"))


def decode_rvl(data: bytes, size: int) -> NDArray[np.uint16]:
    """Return depths as an array of shape (size,).

    Args:
        data: the compressed depths.
        size: how many there are.

    Raises:
        MessageError: the data is damaged.
    """
    numbers = _unpack(data[: _MAX_BYTES_PER_PIXEL * size + 4])
    depths = np.zeros(size, np.uint16)
    at = place = previous = 0
    while at < size:
        if place + 2 > numbers.size:
            raise MessageError("the RVL data ends too early")
        num_unknown, num_known = int(numbers[place]), int(numbers[place + 1])
        place, at = place + 2, at + num_unknown
        end = at + num_known
        if end > size or place + num_known > numbers.size or not num_unknown + num_known:
            raise MessageError("the RVL data is damaged")
        if num_known:
            run = numbers[place : place + num_known]
            values = previous + np.cumsum((run >> 1) ^ -(run & 1))
            depths[at:end] = (values & 0xFFFF).astype(np.uint16)
            previous = int(values[-1])
        place, at = place + num_known, end
    return depths


def _unpack(data: bytes) -> NDArray[np.int64]:
    words = np.frombuffer(data, "<u4", len(data) // 4)
    parts, rest = [np.zeros(0, np.int64)], np.zeros(0, np.int64)
    for start in range(0, words.size, _BLOCK):
        block = (words[start : start + _BLOCK, None] >> _SHIFTS) & 15
        groups = np.concatenate([rest, block.ravel().astype(np.int64)])
        ends = np.flatnonzero(groups < 8)
        if not ends.size:
            break
        counts = np.diff(ends, prepend=-1)
        if counts.max() > _MAX_GROUPS:
            raise MessageError("the RVL data is damaged")
        groups, rest = np.split(groups, [ends[-1] + 1])
        parts.append(np.add.reduceat((groups & 7) << (3 * _places(counts)), ends + 1 - counts))
    return np.concatenate(parts)


def _places(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return each group's place in its number, given each number's count of groups."""
    places: NDArray[np.int64] = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return places
