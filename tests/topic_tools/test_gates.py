"""What drop and throttle let pass."""

from __future__ import annotations

from pyros1.msgs import AnyMsg
from pyros1.topic_tools.gates import ByteThrottle, Drop, MessageThrottle


class FakeTime:
    """A clock that the test sets, and the number of jumps that were told."""

    def __init__(self) -> None:
        self.now = 1000
        self.jumps = 0

    def __call__(self) -> int:
        return self.now

    def jumped(self) -> None:
        self.jumps += 1


def message(size: int = 1) -> AnyMsg:
    return AnyMsg(bytes(size))


def test_drop_leaves_out_the_first_of_every_few() -> None:
    gate = Drop(2, 5)
    assert [gate(message()) for _ in range(10)] == [False, False, True, True, True] * 2


def test_drop_of_all_and_of_none() -> None:
    assert not any(map(Drop(7, 3), [message()] * 6))
    assert all(map(Drop(0, 1), [message()] * 3))


def test_messages_keep_a_period_apart() -> None:
    time = FakeTime()
    gate = MessageThrottle(100, time, time.jumped)
    passed = []
    for time.now in (1000, 1050, 1100, 1101, 1200, 1300):
        passed.append(gate(message()))
    assert passed == [True, False, False, True, False, True]
    assert not time.jumps


def test_a_jump_back_in_time_begins_the_period_anew() -> None:
    time = FakeTime()
    gate = MessageThrottle(100, time, time.jumped)
    passed = []
    for time.now in (1000, 500, 550, 601):
        passed.append(gate(message()))
    assert passed == [True, False, False, True]
    assert time.jumps == 1


def test_bytes_within_a_window() -> None:
    """A message passes while less than the number has passed, so the last one may go beyond it."""
    time = FakeTime()
    gate = ByteThrottle(10, 100, time, time.jumped)
    passed = []
    for time.now, size in ((1000, 6), (1010, 6), (1020, 1), (1100, 1), (1101, 3), (1102, 1), (1103, 1)):
        passed.append(gate(message(size)))
    assert passed == [True, True, False, False, True, True, False]


def test_a_jump_back_in_time_empties_the_window() -> None:
    time = FakeTime()
    gate = ByteThrottle(5, 100, time, time.jumped)
    assert gate(message(5))
    assert not gate(message(5))
    time.now = 10
    assert gate(message(5))
    assert time.jumps == 1
