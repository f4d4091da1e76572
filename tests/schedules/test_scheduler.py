"""scheduler: it finds races, deadlocks and waits that do not end, and plays a plan again."""

from __future__ import annotations

from collections.abc import Callable
from itertools import islice
from typing import Any

import pytest

from .exploring import Broken, at_random, main, random_plans, with_deviations
from .plans import FewDeviations, RandomPlan
from .scenes.lanes import Lanes
from .scheduler import Stuck
from .stage import Scenario, Stage, stage_for


class Toy(Scenario):
    """A scene of this test's own code, whose instructions are points."""

    def __init__(self, act: Callable[[Stage], None]) -> None:
        super().__init__()
        self.traced = frozenset({__file__})
        self.act = act

    def play(self, stage: Stage) -> None:
        """Play it."""
        self.act(stage)


def nothing() -> None:
    """Be a call, after which another thread may run."""


def counting(stage: Stage) -> None:
    """Count with two threads that read, and then write."""
    count = [0]

    def add() -> None:
        before = count[0]
        nothing()
        count[0] = before + 1

    stage.together(add, add)
    assert count == [2], "lost"


def locking(stage: Stage) -> None:
    """Take two locks in both orders."""
    one, two = stage.threading.Lock(), stage.threading.Lock()

    def there() -> None:
        with one, two:
            nothing()

    def back() -> None:
        with two, one:
            nothing()

    stage.together(there, back)


def test_a_lost_update_is_found() -> None:
    with pytest.raises(Broken, match=r"Toy with seed .*lost"):
        at_random(Toy(counting), 200)
    with pytest.raises(Broken, match=r"Toy with deviations \(\(\d+, 1\),\).*lost"):
        with_deviations(Toy(counting), 1000, bound=1)


def test_a_deadlock_is_found_and_says_who_waits_where() -> None:
    with pytest.raises(
        Broken, match=r"deadlock:.*there0: test_scheduler.py:\d+ there.*back1: test_scheduler.py:\d+ back"
    ):
        at_random(Toy(locking), 200)


def test_a_wait_that_does_not_end_is_found() -> None:
    def wait(stage: Stage) -> None:
        event = stage.threading.Event()
        while not event.wait(1.0):
            nothing()

    with pytest.raises(Broken, match="not over after 1000 s"):
        at_random(Toy(wait), 1)


def test_what_a_task_raises_ends_the_run_and_all_its_tasks() -> None:
    def fail(stage: Stage) -> None:
        raise ZeroDivisionError

    def play(stage: Stage) -> None:
        stage.together(lambda: fail(stage), lambda: stage.time.sleep(100.0))

    with stage_for(Toy(play)) as stage, pytest.raises(ZeroDivisionError):
        stage.run(Toy(play), RandomPlan(1))


def test_a_plan_is_played_again_in_the_same_way() -> None:
    scene = Lanes()
    with stage_for(scene) as stage:
        stage.run(scene, FewDeviations())
        for plan in (lambda: RandomPlan(7), lambda: FewDeviations(((40, 1),))):
            runs = [stage.run(scene, plan()) for _ in range(2)]  # type: ignore[operator]
            assert runs[0].points == runs[1].points and runs[0].now == runs[1].now


def test_all_plans_with_few_deviations_are_tried() -> None:
    def pair(stage: Stage) -> None:
        stage.together(nothing, nothing)

    played, complete = with_deviations(Toy(pair), 100_000, bound=1)
    assert complete and played > 5
    assert with_deviations(Toy(pair), 3) == (3, False)


def test_seeds_follow_each_other() -> None:
    assert [str(plan) for plan in islice(random_plans(5), 2)] == ["seed 5", "seed 6"]


def test_the_program_plays_scenes_and_single_plans(capsys: Any) -> None:
    assert main(["Lanes", "--schedules", "4"]) == 0
    assert "4 schedules, 0 scenes fail" in capsys.readouterr().out
    assert main(["Lanes", "--seed", "3"]) == 0 and main(["Lanes", "--deviations", "((3, 1),)"]) == 0


def test_a_wait_outside_of_the_scheduler_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    import threading

    from . import scheduler

    go_on = threading.Event()
    monkeypatch.setattr(scheduler, "PATIENCE", 0.2)
    try:
        with stage_for(Toy(lambda _: None)) as stage, pytest.raises(Stuck, match="outside of the scheduler"):
            stage.run(Toy(lambda _: (go_on.wait(20), None)[1]), RandomPlan(1))
    finally:
        go_on.set()
