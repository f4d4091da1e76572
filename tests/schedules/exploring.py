"""Plays scenes with many plans: `python -m tests.schedules.exploring --schedules 10000`.

Random plans have seeds, and those with few deviations from the plain order are tried one after the other, all with one
deviation first. A failure names its plan, which `--seed` or `--deviations` plays again.
"""

from __future__ import annotations

import argparse
import ast
import random
import sys
import time
import traceback
from collections.abc import Iterator, Sequence
from itertools import count, islice

from .plans import Deviations, FewDeviations, RandomPlan
from .scenes.every import SHARES
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


def main(arguments: Sequence[str] | None = None) -> int:
    """Play all scenes, or some, as a program; return the exit code."""
    parser = argparse.ArgumentParser(description="Play scenes with many plans.")
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="names of scenes (default: all)")
    parser.add_argument("--schedules", type=int, default=10_000, help="of all scenes together")
    parser.add_argument("--first", type=int, default=0, metavar="SEED", help="the first seed")
    parser.add_argument("--seed", type=int, help="play only the plan with this seed")
    parser.add_argument("--deviations", type=ast.literal_eval, help="play only the plan with these deviations")
    options = parser.parse_args(arguments)
    shares = {kind: share for kind, share in SHARES.items() if not options.scenes or kind.__name__ in options.scenes}
    failures = total = 0
    for kind, share in shares.items():
        count = max(2, round(options.schedules * share / sum(shares.values())))
        begun = time.process_time()
        try:
            if options.seed is not None or options.deviations is not None:
                plan = FewDeviations(options.deviations) if options.deviations is not None else RandomPlan(options.seed)
                with stage_for(scene := kind()) as stage:
                    play(stage, scene, FewDeviations())
                    play(stage, scene, plan)
                played, kinds = 1, str(plan)
            else:
                at_random(kind(), count // 2, options.first)
                deviating, complete = with_deviations(kind(), count - count // 2)
                played = count // 2 + deviating
                kinds = f"{count // 2} at random, {deviating} with few deviations{' (all)' if complete else ''}"
        except Broken as error:
            failures += 1
            print(f"BROKEN {error}\n{''.join(traceback.format_exception(error.__cause__))}", flush=True)
        else:
            total += played
            print(f"{kind.__name__}: {kinds}, {time.process_time() - begun:.0f} s of processor", flush=True)
    print(f"{total} schedules, {failures} scenes fail", flush=True)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
