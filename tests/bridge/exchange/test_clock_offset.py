"""The greatest possible age of a message of another site."""

from __future__ import annotations

from random import Random

import pytest

from pyros1.bridge.exchange.clock_offset import DRIFT, ClockOffset


def test_unknown_at_first() -> None:
    clock = ClockOffset()
    assert not clock.is_known and clock.age(1.0, 2.0) is None and clock.round_trip is None


def test_one_round_trip() -> None:
    clock = ClockOffset()
    # Their clock is 1000 s ahead: sent at 10, there at 10.1, held for 0.5, back at 10.8.
    clock.add(10.0, 10.8, 1010.6, 0.5)
    assert clock.is_known and clock.round_trip is not None and abs(clock.round_trip - 0.3) < 1e-9
    age = clock.age(1011.0, 12.0)
    assert age is not None and 1.0 <= age <= 1.0 + 0.1 + 2 * DRIFT  # not less than it is, nor more by the way there


def test_a_message_dated_in_the_future_is_new() -> None:
    clock = ClockOffset()
    clock.add(10.0, 10.2, 10.1, 0.0)
    assert clock.age(1e9, 11.0) == 0.0


def test_the_bound_holds_whatever_the_delays_are() -> None:
    random = Random(1)
    for _ in range(200):
        clock, offset, rate = ClockOffset(), random.uniform(-1e6, 1e6), 1 + random.uniform(-DRIFT, DRIFT) / 2
        now = 100.0

        def there(time: float, offset: float = offset, rate: float = rate) -> float:
            return time * rate + offset

        least = 9.0
        for _ in range(100):
            sent = now
            way = random.expovariate(5.0)
            least = min(least, way)
            arrived = sent + way
            answered = arrived + random.uniform(0, 1)
            now = answered + random.expovariate(5.0)
            clock.add(sent, now, there(answered), there(answered) - there(arrived))
        for _ in range(20):
            received = now + random.uniform(0, 5)
            seen = received + random.uniform(0, 5)
            age = clock.age(there(received), seen)
            assert age is not None and age >= seen - received - 1e-6
            assert age <= seen - received + 1.0  # and it is of use


def test_impossible_round_trips_are_ignored() -> None:
    clock = ClockOffset()
    clock.add(10.0, 10.1, 5.0, 0.5)  # held longer than it was away
    clock.add(10.0, 10.1, 5.0, -0.5)
    clock.add(10.0, 100.0, 5.0, 0.0)
    assert not clock.is_known
    clock.add(10.0, 10.5, 5.0, 0.5)  # no time on the way: the clocks' ticks
    assert clock.is_known and clock.round_trip == 0.0


@pytest.mark.parametrize("pause", [2.0, 100.0])
def test_a_machine_that_was_paused(pause: float) -> None:
    """Its clock stood still, so messages that waited meanwhile must not look new to it."""
    for ours, theirs in ((0.0, pause), (pause, 0.0)):
        clock = ClockOffset()
        for number in range(40):
            clock.add(10.0 + number, 10.3 + number, 1010.1 + number, 0.0)
        # Of `pause` seconds, our clock has counted `ours`, and theirs `theirs`.
        sent = 100.0 + ours
        clock.add(sent, sent + 0.3, 1100.1 + theirs, 0.0)
        age = clock.age(1100.1 + theirs - 5.0, sent + 0.3)
        assert age is not None and 5.0 <= age <= 5.5


def test_a_slow_answer_is_no_pause() -> None:
    clock = ClockOffset()
    clock.add(10.0, 10.1, 1010.05, 0.0)
    clock.add(11.0, 21.0, 1021.0, 0.0)  # the way there took long
    clock.add(22.0, 32.0, 1022.05, 0.0)  # the way back took long
    age = clock.age(1032.0, 32.0)
    assert age is not None and 0.0 <= age <= 0.1


def test_the_shortest_of_the_last_round_trips() -> None:
    clock = ClockOffset()
    assert clock.shortest_round_trip == 0.0
    for number, trip in enumerate([0.1, 0.3, 0.2, *[0.4] * 6]):
        clock.add(10.0 + number, 10.0 + number + trip, 1010.05 + number, 0.0)
        if number == 2:
            assert round(clock.shortest_round_trip, 6) == 0.1
    assert round(clock.shortest_round_trip, 6) == 0.2, "the first one is forgotten"
