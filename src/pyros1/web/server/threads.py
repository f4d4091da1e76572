"""A thread pool for work that may take a long time. A pool from `concurrent.futures` would delay the program's exit."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor, Future
from typing import Any, NamedTuple, TypeVar

_T = TypeVar("_T")
_IDLE_TIMEOUT = 10.0


class _Job(NamedTuple):
    future: Future[Any]
    function: Callable[..., Any]
    args: tuple[Any, ...]
    kwargs: dict[str, Any]


class ThreadPool(Executor):
    """A pool of daemon threads, which are started on demand, and end when they have been idle for a while.

    Args:
        max_threads: maximum number of threads; further work is queued.
        name: the threads' name, to which a number is added.
        idle_timeout: seconds without work after which a thread ends.
    """

    def __init__(self, max_threads: int, name: str, idle_timeout: float = _IDLE_TIMEOUT) -> None:
        self._max_threads = max_threads
        self._name = name
        self._idle_timeout = idle_timeout
        self._changed = threading.Condition()
        self._queues: dict[object, deque[_Job]] = {}  # only queues with jobs, in the order of their turns
        self._num_queued = 0
        self._num_idle = 0
        self._threads: set[threading.Thread] = set()
        self._num_started = 0
        self._ended = False

    def queue(self) -> Executor:
        """Return an executor that uses the same threads, and whose jobs take turns with those of other queues.

        A busy queue thus delays the other queues by only one job at a time.
        """
        return _QueueExecutor(self)

    def submit(self, fn: Callable[..., _T], /, *args: Any, **kwargs: Any) -> Future[_T]:
        """Submit a job to the pool's own queue; see `concurrent.futures.Executor.submit`."""
        return self.submit_to(self, fn, *args, **kwargs)

    def submit_to(self, queue: object, fn: Callable[..., _T], /, *args: Any, **kwargs: Any) -> Future[_T]:
        """Submit a job to a queue; return the future of its result.

        Raises:
            RuntimeError: the pool has been shut down.
        """
        future: Future[_T] = Future()
        with self._changed:
            if self._ended:
                raise RuntimeError("the server is shutting down")
            self._queues.setdefault(queue, deque()).append(_Job(future, fn, args, kwargs))
            self._num_queued += 1
            if self._num_queued > self._num_idle and len(self._threads) < self._max_threads:
                self._num_started += 1
                thread = threading.Thread(target=self._run_jobs, name=f"{self._name} {self._num_started}", daemon=True)
                self._threads.add(thread)
                thread.start()
            else:
                self._changed.notify()
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Stop accepting jobs, and let the threads end when all accepted jobs are done.

        Args:
            wait: whether to wait until the threads have ended.
            cancel_futures: whether to cancel jobs that have not been started.
        """
        with self._changed:
            self._ended = True
            if cancel_futures:
                for jobs in self._queues.values():
                    for job in jobs:
                        job.future.cancel()
                self._queues.clear()
                self._num_queued = 0
            threads = list(self._threads)
            self._changed.notify_all()
        if wait:
            for thread in threads:
                thread.join()

    def _run_jobs(self) -> None:
        while (job := self._next_job()) is not None:
            if job.future.set_running_or_notify_cancel():
                try:
                    job.future.set_result(job.function(*job.args, **job.kwargs))
                except BaseException as error:  # noqa: BLE001 - passed on to the caller
                    job.future.set_exception(error)
            del job  # so that no objects are kept alive while the thread waits

    def _next_job(self) -> _Job | None:
        """Wait for a job and return it; None if the thread should end."""
        with self._changed:
            while not self._queues:
                self._num_idle += 1
                has_work = not self._ended and self._changed.wait(self._idle_timeout)
                self._num_idle -= 1
                if not has_work and not self._queues:
                    self._threads.discard(threading.current_thread())
                    return None
            queue = next(iter(self._queues))
            jobs = self._queues.pop(queue)
            job = jobs.popleft()
            if jobs:
                self._queues[queue] = jobs  # after the other queues
            self._num_queued -= 1
            return job


class _QueueExecutor(Executor):
    def __init__(self, threads: ThreadPool) -> None:
        self._threads = threads

    def submit(self, fn: Callable[..., _T], /, *args: Any, **kwargs: Any) -> Future[_T]:
        return self._threads.submit_to(self, fn, *args, **kwargs)
