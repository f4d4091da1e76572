"""Priorities, timeouts and locks of twist_mux."""

from __future__ import annotations

import random

import pytest

from pyros1.robot_nodes.shared.twist_sources import Source
from pyros1.robot_nodes.twist_mux.arbiter import Arbiter


def topics(*entries: tuple[float, int]) -> list[Source]:
    return [Source(f"n{index}", f"t{index}", timeout, priority) for index, (timeout, priority) in enumerate(entries)]


def test_a_higher_priority_takes_over_until_it_is_silent() -> None:
    mux = Arbiter(topics((0.5, 10), (0.5, 100)), [])
    assert mux.command(0, 0.0) and mux.command(1, 0.1) and not mux.command(0, 0.2)
    assert not mux.command(0, 0.6), "half a second is not over"
    assert mux.command(0, 0.61) and mux.driver == 0


def test_of_equal_priorities_the_first_one_drives() -> None:
    mux = Arbiter(topics((0.5, 10), (0.5, 10)), [])
    assert mux.command(1, 0.0) and mux.command(0, 0.1) and not mux.command(1, 0.2)


def test_priority_0_never_drives() -> None:
    assert not Arbiter(topics((0.5, 0)), []).command(0, 0.0)


def test_one_stop_when_the_driver_is_silent() -> None:
    mux = Arbiter(topics((0.5, 10)), [])
    assert not mux.must_stop(0.0) and mux.command(0, 1.0)
    assert not mux.must_stop(1.5) and mux.must_stop(1.51) and not mux.must_stop(1.52)


def test_a_topic_without_a_timeout() -> None:
    mux = Arbiter(topics((0.0, 10), (0.5, 1)), [])
    assert mux.command(1, 0.0), "what has never sent anything masks nobody"
    assert mux.command(0, 0.1) and not mux.must_stop(1e6) and not mux.command(1, 1e6)


def test_locks() -> None:
    locks = topics((0.0, 100), (1.0, 50))
    mux = Arbiter(topics((0.5, 99), (0.5, 100), (0.5, 49)), locks)
    assert mux.is_locked(1, 0.0) and not mux.is_locked(0, 0.0), "a lock with a timeout is on until it is heard of"
    assert not mux.command(2, 0.0) and mux.command(0, 0.0)
    mux.lock(1, False, 0.1)
    mux.lock(0, True, 0.1)
    assert mux.must_stop(0.1) and mux.locked_priority(0.1) == 100
    assert not mux.command(0, 0.2) and mux.command(1, 0.2), "equal priority is not locked"
    mux.lock(0, False, 0.3)
    assert not mux.is_locked(0, 1e6) and mux.is_locked(1, 1.11) and not mux.is_locked(1, 1.1)


def test_after_time_has_jumped_back_nothing_old_drives() -> None:
    mux = Arbiter(topics((0.5, 10), (0.5, 5)), [])
    assert mux.command(0, 100.0) and mux.must_stop(3.0) and mux.command(1, 3.0)


class Reference:
    """The rules of the wiki, decided anew from all messages."""

    def __init__(self, topics: list[Source], locks: list[Source]) -> None:
        self.topics, self.locks = topics, locks
        self.commands: list[tuple[int, float]] = []
        self.switches: list[tuple[int, float, bool]] = []

    def locked(self, lock: int, now: float) -> bool:
        mine = [(time, is_on) for index, time, is_on in self.switches if index == lock]
        timeout = self.locks[lock].timeout
        silent = timeout != 0 and not any(now - time <= timeout for time, _ in mine)
        return silent or bool(mine and mine[-1][1])

    def unmasked(self, now: float) -> list[int]:
        return [
            index
            for index, topic in enumerate(self.topics)
            if any(
                sent == index and (topic.timeout == 0 or now - time <= topic.timeout) for sent, time in self.commands
            )
            and all(
                topic.priority >= lock.priority or not self.locked(number, now)
                for number, lock in enumerate(self.locks)
            )
        ]

    def selected(self, now: float) -> int | None:
        candidates = [(-self.topics[index].priority, index) for index in self.unmasked(now)]
        best = min(candidates, default=(0, -1))
        return best[1] if best[0] < 0 else None


@pytest.mark.slow
def test_random_schedules() -> None:
    chance = random.Random(5)
    stops = 0
    for _ in range(300):
        inputs = topics(*((chance.choice([0.0, 2.0, 5.0]), chance.choice([0, 1, 5, 5, 9])) for _ in range(3)))
        locks = topics(*((chance.choice([0.0, 4.0]), chance.choice([0, 1, 5, 6, 255])) for _ in range(2)))
        mux, reference = Arbiter(inputs, locks), Reference(inputs, locks)
        now, driver = 0.0, None
        for _ in range(40):
            now += chance.choice([0, 1, 1, 3])
            action, index = chance.choice(["command", "command", "lock", "check"]), chance.randrange(2)
            if action == "command":
                index = chance.randrange(3)
                reference.commands.append((index, now))
                expected = reference.selected(now) == index
                assert mux.command(index, now) == expected
                driver = index if expected else driver
            elif action == "lock":
                is_on = chance.random() < 0.4
                reference.switches.append((index, now, is_on))
                mux.lock(index, is_on, now)
            else:
                expected = driver is not None and driver not in reference.unmasked(now)
                assert mux.must_stop(now) == expected
                driver, stops = (None, stops + 1) if expected else (driver, stops)
            assert [mux.is_masked(number, now) for number in range(3)] == [
                number not in reference.unmasked(now) for number in range(3)
            ]
            assert [mux.is_locked(number, now) for number in range(2)] == [
                reference.locked(number, now) for number in range(2)
            ]
    assert stops > 50
