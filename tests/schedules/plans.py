"""Plans: what decides a run of the scheduler. At random, from a seed; or with few deviations from a plain order."""

from __future__ import annotations

import random

NEVER = 1 << 60
GAPS = (2, 5, 15, 50, 200)
"""Average number of points between two preemptions; each run has one of these."""
DELAYS = (*16 * (0.0,), 40e-6, 600e-6, 3e-3, 30e-3)


class RandomPlan:
    """Preempts at random, in each run more or less often.

    Args:
        seed: decides everything.
    """

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self._random = random.Random(seed)
        self._gap = 2 * self._random.choice(GAPS)
        self._slow = self._random.random() < 0.5
        self._split = self._random.random() < 0.5

    def __str__(self) -> str:
        return f"seed {self.seed}"

    def due(self, point: int) -> int:
        """Return the next point at which another task may go on."""
        return point + 1 + int(self._random.random() * self._gap)

    def preempt(self, _point: int, others: int) -> int:
        """Let one of the others go on, or none."""
        return int(self._random.random() * (others + 1))

    def choose(self, _point: int, ready: int) -> int:
        """Choose any of those that can go on."""
        return int(self._random.random() * ready)

    def delay(self) -> float:
        """Lose the processor for a moment, in half of the runs."""
        return DELAYS[int(self._random.random() * len(DELAYS))] if self._slow else 0.0

    def part(self, size: int) -> int:
        """Receive only a part, in half of the runs."""
        if self._split and self._random.random() < 0.3:
            return 1 + int(self._random.random() * size)
        return size


Deviations = tuple[tuple[int, int], ...]
"""(point, which other task goes on there), in order."""


class FewDeviations:
    """Tasks run until they wait, those first that have waited longest; except at a few points.

    Args:
        deviations: those points.

    Attributes:
        others: for each point after the last deviation the number of other tasks that could have gone on.
    """

    def __init__(self, deviations: Deviations = ()) -> None:
        self.deviations = deviations
        self.others: dict[int, int] = {}
        self._left = dict(deviations)
        self._first_new = deviations[-1][0] + 1 if deviations else 1

    def __str__(self) -> str:
        return f"deviations {self.deviations}"

    def due(self, point: int) -> int:
        """Return the next point of interest: all of them, after the last deviation."""
        return max(point + 1, min(self._left, default=self._first_new))

    def preempt(self, point: int, others: int) -> int:
        """Deviate, if this is the point for that."""
        chosen = self._left.pop(point, 0)
        if others and point >= self._first_new:
            self.others[point] = others
        return chosen

    def choose(self, point: int, ready: int) -> int:
        """Choose the first, or another one if this is a point for that."""
        chosen = self._left.pop(point, 0)
        if ready > 1 and point >= self._first_new:
            self.others[point] = ready - 1
        return chosen

    def delay(self) -> float:
        """Return 0."""
        return 0.0

    def part(self, size: int) -> int:
        """Return all."""
        return size

    def next_ones(self) -> list[Deviations]:
        """Return all plans with one deviation more than this one, which has been run."""
        return [
            (*self.deviations, (point, other)) for point, count in self.others.items() for other in range(1, count + 1)
        ]
