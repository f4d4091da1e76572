"""Work that is done piece by piece, in the order in which it came, though nobody ever waits for a turn.

Who comes with a job and finds the lane free does the job. Who finds it taken leaves the job and goes; who works there
does it too before he stops. So all links of a topic see one order, whoever publishes; and a signal handler may come at
any moment, even while the function that it interrupted is at work here: its jobs are done when that goes on.

Why nothing can hang: nobody waits for a lane, and a job waits for nothing, so that each is left again. Why nothing is
forgotten: who stops looks for jobs after the lane is free, and who leaves a job looks whether it is free afterwards.

The lane is free while its list holds something: ``del lane.free[0]`` takes it, for one thread only, and raises
IndexError for the others. Unlike a call of ``Lock.acquire``, no signal handler can run between that instruction and the
next ``try``: one that raises (KeyboardInterrupt) cannot leave the lane taken. It also takes a tenth of the time.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable
from threading import get_ident
from typing import Any

TURN = 64
"""Jobs of others that are done in one go; `later` goes on with the rest."""
CROWD = 1000
"""Jobs that wait before those who bring more are held up for a moment each."""
PAUSE = 0.001

Job = tuple[Callable[..., object], tuple[Any, ...]]


class Lane:
    """One piece of work at a time.

    Args:
        later: calls a function soon, on another thread, that of a loop for example.
        recover: called when a job raises, as it does if a signal handler raises in the middle of it.

    Attributes:
        free: holds something while nobody works here; see above.
        worker: the thread that works here, or worked here last.
        jobs: what was left.
    """

    __slots__ = ("_later", "_recover", "free", "jobs", "worker")

    def __init__(
        self, later: Callable[[Callable[[], None]], object], recover: Callable[[], object] = lambda: None
    ) -> None:
        self.free = [True]
        self.worker = 0
        self.jobs: deque[Job] = deque()
        self._later = later
        self._recover = recover

    @property
    def mine(self) -> bool:
        """Whether the caller's thread works here: then it is in a signal handler, or in a job."""
        return not self.free and self.worker == get_ident()

    def do(self, job: Callable[..., object], *args: Any) -> None:
        """Do a job after those that came before, or leave it to whoever works here. Never waits."""
        self.jobs.append((job, args))
        self.work()

    def leave(self, job: Callable[..., object], *args: Any) -> None:
        """Leave a job, because somebody works here. For those who may be held up for a moment if there are too many."""
        self.do(job, *args)
        if len(self.jobs) > CROWD and not self.mine:
            time.sleep(PAUSE)

    def linger(self) -> None:
        """Give who works here a moment to end, a millisecond or two at most: then the caller need not leave its job."""
        for attempt in range(40):
            if self.free or self.mine:
                return
            time.sleep(0 if attempt < 20 else PAUSE / 20)

    def work(self) -> None:
        """Do what was left, unless somebody works here; no more than a turn."""
        me = get_ident()
        while self.jobs:
            try:
                del self.free[0]
            except IndexError:
                return
            self.worker = me
            try:
                done = self.catch_up()
            except BaseException:
                self._recover()
                self._later(self.work)
                raise
            finally:
                self.free.append(True)
            if not done:  # so many that others would wait too long for this thread
                self._later(self.work)
                return

    def catch_up(self) -> bool:
        """Do what was left, no more than a turn; return whether it was all. By the worker."""
        jobs = self.jobs
        for _ in range(TURN):
            if not jobs:
                return True
            job, args = jobs.popleft()
            job(*args)
        return not jobs
