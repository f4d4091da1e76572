"""Where messages are, from the index."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable

import numpy as np
import pytest
from numpy.typing import NDArray

from pyros1.web.bags import density
from pyros1.web.bags.density import Density

Chunks = list[dict[int, list[int]]]


def made(chunks: Chunks) -> Density:
    return Density(
        (min(map(min, rows.values())), max(map(max, rows.values())), [(row, len(times)) for row, times in rows.items()])
        for rows in chunks
    )


def asked(chunks: Chunks, looked: list[int]) -> density.ReadTimes:
    def times(number: int) -> Iterable[tuple[int, NDArray[np.int64]]]:
        looked.append(number)
        return [(row, np.array(stamps, np.int64)) for row, stamps in chunks[number].items()]

    return times


def random_chunks(chance: random.Random) -> Chunks:
    chunks: Chunks = []
    for _ in range(chance.randint(1, 12)):
        start, size = chance.randint(0, 10_000), chance.choice([0, 5, 500, 5_000])
        rows = chance.sample(range(4), chance.randint(1, 4))
        chunks.append({row: [start + chance.randint(0, size) for _ in range(chance.randint(1, 30))] for row in rows})
    return chunks


def places(chunk: dict[int, list[int]], row: int, begin: int, size: float) -> list[tuple[int, float]]:
    """Return the columns of a chunk's messages, and how much of one is there."""
    every = [math.floor((time - begin) / size) for times in chunk.values() for time in times]
    own = [math.floor((time - begin) / size) for time in chunk.get(row, ())]
    if max(every) - min(every) != 1:
        return [(column, 1.0) for column in own]
    return [(column, 0.5) for _ in own for column in (min(every), max(every))]


@pytest.mark.slow
def test_random_bags_are_counted() -> None:
    chance = random.Random(1)
    for _ in range(300):
        chunks = random_chunks(chance)
        begin = chance.randint(-2_000, 9_000)
        end = begin + chance.randint(50, 15_000)
        columns = chance.randint(1, 50)
        rows = chance.sample(range(5), chance.randint(1, 5))
        counts, exact = made(chunks).histogram(begin, end, columns, rows, asked(chunks, []))
        assert exact
        for index, row in enumerate(rows):
            expected = np.zeros(columns)
            for chunk in chunks:
                for column, share in places(chunk, row, begin, (end - begin) / columns):
                    if 0 <= column < columns:
                        expected[column] += share
            assert np.allclose(counts[index], expected, atol=1e-3)


def test_chunks_within_a_column_are_not_read() -> None:
    chunks = [{0: [number * 100 + 10, number * 100 + 20]} for number in range(50)]
    looked: list[int] = []
    counts, exact = made(chunks).histogram(0, 5_000, 50, [0], asked(chunks, looked))
    assert exact and looked == []
    assert counts.tolist() == [[2.0] * 50]


def test_too_many_messages_are_spread(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(density, "MAX_EXACT_MESSAGES", 10)
    chunks: Chunks = [{0: list(range(0, 1_000, 10))}]
    looked: list[int] = []
    whole, exact = made(chunks).histogram(0, 1_000, 10, [0], asked(chunks, looked))
    assert not exact and looked == []
    assert whole.tolist() == [[10.0] * 10]
    part, _ = made(chunks).histogram(400, 600, 2, [0], asked(chunks, looked))
    assert part.tolist() == [[10.0, 10.0]]  # only the share of what is in sight


def test_of_several_the_small_chunks_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(density, "MAX_EXACT_MESSAGES", 10)
    chunks: Chunks = [{0: list(range(100))}, {1: [5, 95]}]
    looked: list[int] = []
    counts, exact = made(chunks).histogram(0, 100, 10, [0, 1], asked(chunks, looked))
    assert looked == [1] and not exact
    assert counts[1].tolist() == [1, 0, 0, 0, 0, 0, 0, 0, 0, 1]


def test_an_empty_bag_has_no_messages() -> None:
    counts, exact = Density([]).histogram(0, 100, 5, [0, 1], lambda number: [])
    assert exact
    assert counts.shape == (2, 5) and not counts.any()


@pytest.mark.parametrize("rows", [[(-1, 7)], [(-1, 7), (0, 3)]])
def test_messages_of_no_row_are_not_those_of_the_last(rows: list[tuple[int, int]]) -> None:
    found, exact = Density([(5, 5, rows)]).histogram(0, 10, 2, [0], asked([], []))
    assert (found.tolist(), exact) == ([[0.0, float(dict(rows).get(0, 0))]], True)
