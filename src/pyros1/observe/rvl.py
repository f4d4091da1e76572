"""RVL, a fast lossless compression of depth images (A. Wilson, "Fast Lossless Depth Image Compression", 2017).

An image is a sequence of runs: the number of zeros, the number of other values, and these values, each as the
difference from the one before. Numbers are written in groups of four bits, the lowest group first: three bits of the
number, and a highest bit that says whether more groups follow. A 32-bit word holds eight groups, the first in its
highest bits.
"""

from __future__ import annotations

from array import array

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError

_MAX_GROUPS = 11
"""Maximum number of groups of a number: 33 bits."""
_BLOCK = 4096
"""Number of words to decode at a time: each takes several copies of up to eight 64-bit numbers."""
_MAX_BYTES_PER_PIXEL = 4
"""The size of a run of one pixel: two groups for its lengths, and six for the difference. Further data is not read."""
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
        size: the number of depths.

    Raises:
        MessageError: the data is damaged.
    """
    if not size:
        return np.zeros(0, np.uint16)
    numbers = _unpack(data[: _MAX_BYTES_PER_PIXEL * size + 4])
    places, unknown, known = _find_runs(numbers, size)
    is_value = np.ones(int(places[-1] + 2 + known[-1]), np.bool_)
    is_value[places] = is_value[places + 1] = False
    differences = numbers[: is_value.size][is_value]
    depths = np.zeros(size, np.uint16)
    starts = np.cumsum(unknown + known) - known
    at = np.repeat(starts - (np.cumsum(known) - known), known)
    at += np.arange(at.size)
    depths[at] = (np.cumsum((differences >> 1) ^ -(differences & 1)) & 0xFFFF).astype(np.uint16)
    return depths


def _find_runs(numbers: NDArray[np.int64], size: int) -> tuple[NDArray[np.int64], ...]:
    """Return, for each run, the index of its first number, its number of zeros, and its number of other values."""
    following = np.arange(2, numbers.size + 1)  # for each number: start of the next run if a run starts there
    following += numbers[1:]
    # A noisy image has a run for every other pixel, and this loop is faster with a memoryview than with an array.
    view, places, place = following.data, array("q"), 0
    while place < len(view):
        places.append(place)
        place = view[place]
    begins = np.array(places, np.int64)
    unknown, known = numbers[begins], numbers[begins + 1]
    lengths = unknown + known
    ends = np.cumsum(lengths)
    num_runs = int(np.searchsorted(ends, size)) + 1
    if num_runs > ends.size:
        raise MessageError("the RVL data ends too early")
    is_cut_off = begins[num_runs - 1] + 2 + known[num_runs - 1] > numbers.size
    if ends[num_runs - 1] > size or is_cut_off or not lengths[:num_runs].all():
        raise MessageError("the RVL data is damaged")
    return begins[:num_runs], unknown[:num_runs], known[:num_runs]


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
    """Return each group's place in its number, given the number of groups of each number."""
    places: NDArray[np.int64] = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    return places
