"""Plays scenes with many plans: `python -m tests.schedules.exploring --schedules 10000`.

Random plans have seeds, and those with few deviations from the plain order are tried one after the other, all with one
deviation first. A failure names its plan, which `--seed` or `--deviations` plays again.
"""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import count, islice

from .plans import Deviations, FewDeviations, RandomPlan
from .scheduler import Plan
from .stage import Scenario, Stage, stage_for


class Broken(AssertionError):
    """A plan with which a scene fails."""


def play(stage: Stage, scenario: Scenario, plan: Plan) -> int:
    """Play a scene with a plan; return the number of points.

    Raises:
        Broken: an invariant does not hold.
    """
    try:
        return stage.run(scenario, plan).points
    except Exception as error:
        raise Broken(f"{type(scenario).__name__} with {plan}: {error!r}") from error


def random_plans(first: int = 0) -> Iterator[Plan]:
    """Return plans with the seeds from ``first`` on."""
    return (RandomPlan(seed) for seed in count(first))


def at_random(scenario: Scenario, schedules: int, first: int = 0) -> int:
    """Play a scene with that many random plans; return the number of points.

    Raises:
        Broken: one of them fails.
    """
    with stage_for(scenario) as stage:
        play(stage, scenario, FewDeviations())  # loads what is loaded late
        return sum(play(stage, scenario, plan) for plan in islice(random_plans(first), schedules))


def with_deviations(scenario: Scenario, schedules: int, bound: int = 2) -> tuple[int, bool]:
    """Play a scene with up to ``bound`` deviations from the plain order; with a sample, if there are too many.

    Returns:
        The number of schedules, and whether these were all.

    Raises:
        Broken: one of them fails.
    """
    chance = random.Random(schedules)
    played, complete = 0, True
    with stage_for(scenario) as stage:
        play(stage, scenario, FewDeviations())
        level: list[Deviations] = [()]
        for depth in range(bound + 1):
            following: list[Deviations] = []
            if played + len(level) > schedules:
                complete = False
                level = sorted(chance.sample(level, schedules - played))
            for deviations in level:
                plan = FewDeviations(deviations)
                play(stage, scenario, plan)
                played += 1
                if depth < bound:
                    following += plan.next_ones()
            level = following
    return played, complete
