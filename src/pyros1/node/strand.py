"""A strand: runs jobs one at a time, in the order in which they were added, without making any thread wait.

A thread that adds a job to a free strand runs the job. If the strand is busy, the thread leaves the job in its queue
and continues. The *worker*, which is the thread that is running jobs, also runs that job before it stops. So all links
of a topic see one order, whichever thread publishes. A signal handler may add jobs at any moment, even if it has
interrupted the worker: the handler's jobs are run when the interrupted function continues.

Nothing can hang: no thread waits for a strand, and jobs do not wait, so each strand becomes free again. No job is
lost: a worker looks for jobs again after it has freed the strand, and a thread that has queued a job checks
afterwards whether the strand is free.

The strand is free while the list ``free`` has an item: ``del strand.free[0]`` takes the strand, for one thread only,
and raises IndexError for the others. Unlike a call of ``Lock.acquire``, no signal handler can run between that
instruction and the next ``try``: a handler that raises (KeyboardInterrupt) cannot leave the strand locked. The
instruction also takes only a tenth of the time of that call.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from threading import get_ident
from typing import Any

MAX_JOBS_PER_TURN = 64
"""Maximum number of jobs run in one turn; the others are run in a later turn, which ``schedule`` starts."""
JOBS_BEFORE_DELAY = 1000
"""Number of waiting jobs above which `Strand.post` delays each thread that adds another job."""
POLL_DELAY = 0.001
"""Duration in seconds of the delay in `Strand.post`."""

Job = tuple[Callable[..., object], tuple[Any, ...]]


class Strand:
    """Runs one job at a time.

    Args:
        schedule: calls a function soon, on another thread, such as a loop's.
        recover: called when a job raises an exception, which also happens if a signal handler raises one in the middle
            of the job.

    Attributes:
        free: has an item while no thread is running jobs; see the module's docstring.
        worker: id of the thread that is running jobs, or was the last to do so.
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
    def runs_in_this_thread(self) -> bool:
        """Whether the calling thread is already running jobs: the caller is then a job, or a signal handler."""
        return not self.free and self.worker == get_ident()

    def do(self, job: Callable[..., object], *args: Any) -> None:
        """Run a job after all earlier ones, or leave it to the thread that is running jobs. Never waits."""
        self.jobs.append((job, args))
        self.work()

    def post(self, job: Callable[..., object], *args: Any) -> None:
        """Like `do`, but if very many jobs are waiting, delay the caller by POLL_DELAY seconds."""
        self.do(job, *args)
        if len(self.jobs) > JOBS_BEFORE_DELAY and not self.runs_in_this_thread:
            time.sleep(POLL_DELAY)

    def spin_wait(self) -> None:
        """Wait at most about two milliseconds until no thread is running jobs, so that the caller can run its own."""
        for attempt in range(40):
            if self.free or self.runs_in_this_thread:
                return
            time.sleep(0 if attempt < 20 else POLL_DELAY / 20)

    def work(self) -> None:
        """Run the waiting jobs, at most `MAX_JOBS_PER_TURN`, unless another thread is running them."""
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
        """Run the waiting jobs, at most `MAX_JOBS_PER_TURN`; return whether none remain. Called by the worker."""
        jobs = self.jobs
        for _ in range(MAX_JOBS_PER_TURN):
            if not jobs:
                return True
            job, args = jobs.popleft()
            job(*args)
        return not jobs
