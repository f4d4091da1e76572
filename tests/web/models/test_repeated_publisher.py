"""Publishing at a rate."""

from __future__ import annotations

import threading

from pyros1.ground.errors import Error
from pyros1.web.models.repeated_publisher import RepeatedPublisher

PATIENCE = 20.0


class Counter:
    """Something to publish: says when it was done some times."""

    def __init__(self, most: int, problem: str = "") -> None:
        self.done = threading.Event()
        self.count = 0
        self._most = most
        self._problem = problem

    def __call__(self) -> int:
        self.count += 1
        if self.count == self._most:
            self.done.set()
        if self._problem:
            raise Error(self._problem)
        return 3


def test_it_goes_on_until_it_is_closed() -> None:
    counter = Counter(5)
    repeating = RepeatedPublisher(counter, 1000)
    assert counter.done.wait(PATIENCE)
    repeating.close()
    assert repeating.sent == counter.count >= 5 and repeating.subscribers == 3 and not repeating.problem


def test_a_change_counts_at_once_at_any_rate() -> None:
    first, second = Counter(1), Counter(1)
    repeating = RepeatedPublisher(first, 0.001)
    assert first.done.wait(PATIENCE)
    repeating.change(second, 0.001)
    assert second.done.wait(PATIENCE)
    repeating.close()


def test_failures_are_told_and_tried_again() -> None:
    counter = Counter(3, "no master")
    repeating = RepeatedPublisher(counter, 1000)
    assert counter.done.wait(PATIENCE)
    repeating.close()
    assert repeating.problem == "no master" and repeating.sent == 0
