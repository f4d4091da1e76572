"""A strand: runs jobs one at a time, in the order in which they were added, without making any thread wait.

A thread that adds a job to a free strand does the job. If the strand is busy, the thread leaves the job there and
continues; the thread that works in the strand does the job before it stops. So all links of a topic see one order,
whichever thread publishes; and a signal handler may run at any moment, even if it interrupts a function that works
here: the handler's jobs are done when that function continues.

Nothing can hang: no thread waits for a strand, and jobs do not wait, so each strand becomes free again. No job is
lost: a worker looks for jobs again after it has freed the strand, and a thread that has left a job checks
afterwards whether the strand is free.

The strand is free while its list is not empty: ``del strand.free[0]`` takes it, for one thread only, and raises
IndexError for the others. Unlike a call of ``Lock.acquire``, no signal handler can run between that instruction and the
next ``try``: a handler that raises (KeyboardInterrupt) cannot leave the strand locked. The instruction also takes only
a tenth of the time of that call.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from threading import get_ident
from typing import Any

MAX_JOBS_PER_TURN = 64
"""Maximum number of jobs done in one turn; the rest is left to a later turn, which ``schedule`` starts."""
JOBS_BEFORE_DELAY = 1000
"""Number of waiting jobs above which `Strand.post` delays each thread that adds another job."""
POLL_DELAY = 0.001
"""Duration of that delay, in seconds."""

Job = tuple[Callable[..., object], tuple[Any, ...]]


class Strand:
    """Runs one job at a time.

    Args:
        schedule: calls a function soon, on another thread, such as a loop's.
        recover: called when a job raises an exception, which also happens if a signal handler raises one in the middle
            of the job.

    Attributes:
        free: holds an item while no thread works here; see the module's docstring.
        worker: id of the thread that works here, or worked here last.
        jobs: the jobs that are waiting.
    """

    __slots__ = ("_recover", "_schedule", "free", "jobs", "worker")

    def __init__(
        self, schedule: Callable[[Callable[[], None]], object], recover: Callable[[], object] = lambda: None
    ) -> None:
        self.free = [True]
        self.worker = 0
        self.jobs: deque[Job] = deque()
        self._schedule = schedule
        self._recover = recover

    @property
    def is_mine(self) -> bool:
        """Whether the calling thread works here already: the call is then made by a job, or by a signal handler."""
        return not self.free and self.worker == get_ident()

    def do(self, job: Callable[..., object], *args: Any) -> None:
        """Do a job after all earlier ones, or leave it to the thread that works here. Never waits."""
        self.jobs.append((job, args))
        self.work()

    def post(self, job: Callable[..., object], *args: Any) -> None:
        """Leave a job for the thread that works here; if too many wait, delay the caller for a moment."""
        self.do(job, *args)
        if len(self.jobs) > JOBS_BEFORE_DELAY and not self.is_mine:
            time.sleep(POLL_DELAY)

    def spin_wait(self) -> None:
        """Wait up to about two milliseconds until no thread works here, so that the caller can do the job itself."""
        for attempt in range(40):
            if self.free or self.is_mine:
                return
            time.sleep(0 if attempt < 20 else POLL_DELAY / 20)

    def work(self) -> None:
        """Do the waiting jobs, at most `MAX_JOBS_PER_TURN`, unless another thread works here."""
        thread_id = get_ident()
        while self.jobs:
            try:
                del self.free[0]
            except IndexError:
                return
            self.worker = thread_id
            all_done = False
            try:
                all_done = self.run_pending()
            except BaseException:
                self._recover()
                raise
            finally:
                self.free.append(True)
                if not all_done:  # there were too many, and other links would have to wait; or a job raised
                    self._schedule(self.work)  # after freeing the strand: in a busy one, `work` does nothing
            if not all_done:
                return

    def run_pending(self) -> bool:
        """Do the waiting jobs, at most `MAX_JOBS_PER_TURN`; return whether none remain. Called by the worker."""
        jobs = self.jobs
        for _ in range(MAX_JOBS_PER_TURN):
            if not jobs:
                return True
            job, args = jobs.popleft()
            job(*args)
        return not jobs
