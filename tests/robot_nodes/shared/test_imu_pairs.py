"""Pairs of IMU messages and magnetic fields, in every order of arrival."""

from __future__ import annotations

from itertools import combinations

from pyros1.ground.timing import Time
from pyros1.robot_nodes.shared.imu_pairs import ImuPairs


def pair_up(arrivals: list[tuple[int, float]], queue_size: int = 5) -> list[tuple[float, float]]:
    """Return the stamps of the pairs that are found when these (topic, stamp) arrive."""
    pairs = ImuPairs(queue_size)
    found: list[tuple[float, float]] = []
    for index, stamp in arrivals:
        found += pairs.add(index, Time.from_sec(stamp), stamp)
    return found


IMUS, FIELDS = [200.0, 300.0, 301.0, 10.0, 10.1], [200.003, 10.003, 10.103]


def test_pairs_after_time_jumped_back_in_any_order_of_arrival() -> None:
    for places in combinations(range(len(IMUS) + len(FIELDS)), len(FIELDS)):
        imus, fields = iter(IMUS), iter(FIELDS)
        arrivals = [(1, next(fields)) if place in places else (0, next(imus)) for place in range(8)]
        order = {stamp: place for place, (_, stamp) in enumerate(arrivals)}
        both_before_a_jump = order[200.0] < order[10.003] and order[200.003] < order[10.0]
        before = [(200.0, 200.003)] if both_before_a_jump else []
        assert pair_up(arrivals) == [*before, (10.0, 10.003), (10.1, 10.103)], arrivals


def test_what_waits_since_before_the_jump_is_forgotten() -> None:
    late = [(0, 300.0 + number) for number in range(5)]
    assert pair_up([*late, (0, 10.0), (1, 304.1), (1, 10.1)]) == [(10.0, 10.1)]


def test_stamps_that_are_far_apart_or_go_back_a_little() -> None:
    assert pair_up([(0, 1.0), (1, 1.6)]) == []
    assert pair_up([(0, 2.0), (0, 1.9), (1, 2.01), (1, 1.91)]) == [(2.0, 2.01), (1.9, 1.91)]
