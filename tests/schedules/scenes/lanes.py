"""A strand, with threads that bring jobs: each job is done once, none beside another, each thread's in order."""

from __future__ import annotations

import contextlib
from collections.abc import Callable

from pyros1.node.strand import Strand

from ..stage import Scenario, Stage

THREADS, JOBS = 3, 3


class Interrupted(Exception):
    """As a signal handler raises, in the middle of a job."""


def suppressing(function: Callable[[], object]) -> Callable[[], None]:
    """Return a function that goes on after such an interruption."""

    def call() -> None:
        with contextlib.suppress(Interrupted):
            function()

    return call


class Lanes(Scenario):
    """Threads do and leave jobs; the rest of long turns is done later, by another thread."""

    modules = ("pyros1.node.strand",)
    limits = (("pyros1.node.strand", "MAX_JOBS_PER_TURN", 2), ("pyros1.node.strand", "JOBS_BEFORE_DELAY", 2))
    raises = False

    def play(self, stage: Stage) -> None:
        """Play it."""
        strand = Strand(lambda work: stage.spawn(suppressing(work)), lambda: recovered.append(True))
        done: list[tuple[int, int]] = []
        inside: list[int] = []
        recovered: list[bool] = []

        def job(thread: int, number: int) -> None:
            assert not inside, "two jobs at the same time"
            inside.append(thread)
            stage.scheduler.point()
            inside.pop()
            done.append((thread, number))
            if self.raises and (thread, number) == (1, 1):
                raise Interrupted

        def bring(thread: int) -> None:
            for number in range(JOBS):
                suppressing(lambda number=number: (strand.do if number % 2 else strand.post)(job, thread, number))()

        def thread(number: int) -> object:
            return lambda: bring(number)

        stage.together(*(thread(number) for number in range(THREADS)))  # type: ignore[arg-type]
        stage.until(lambda: all(task.ended for task in stage.scheduler.tasks[1:]))
        check_order(done, THREADS, JOBS)
        assert strand.free == [True], "the lane is free once"
        assert bool(recovered) is self.raises


class RaisingLanes(Lanes):
    """The same, with a job that raises."""

    raises = True


def check_order(done: list[tuple[int, int]], threads: int, jobs: int) -> None:
    """Check that all came, once, each thread's in order."""
    for thread in range(threads):
        came = [number for who, number in done if who == thread]
        assert came == list(range(jobs)), f"of thread {thread}: {came}"
