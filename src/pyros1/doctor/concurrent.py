"""Concurrent requests with one timeout for all: a host that does not answer does not delay the rest."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable, Hashable, Mapping
from time import monotonic
from typing import TypeVar

from pyros1.ground.errors import DeadlineError

_K = TypeVar("_K", bound=Hashable)
_V = TypeVar("_V")

MAX_THREADS = 256


def run_concurrently(jobs: Mapping[_K, Callable[[], _V]], seconds: float) -> dict[_K, _V | Exception]:
    """Run functions at the same time.

    Args:
        jobs: functions by any key. A function that is not done in time keeps running on its daemon thread, since a
            lookup of a host name cannot be interrupted.
        seconds: timeout for all of them, and again for each further MAX_THREADS, so that jobs that hang do not use up
            the time of the rest.

    Returns:
        For each key, in the same order, what its function returned or raised, or a DeadlineError.
    """
    pending: queue.SimpleQueue[_K] = queue.SimpleQueue()
    answers: queue.SimpleQueue[tuple[_K, _V | Exception]] = queue.SimpleQueue()
    for key in jobs:
        pending.put(key)
    seconds *= max(1, -(-len(jobs) // MAX_THREADS))
    deadline = monotonic() + seconds

    def work() -> None:
        while monotonic() < deadline:
            try:
                key = pending.get_nowait()
            except queue.Empty:
                return
            try:
                answers.put((key, jobs[key]()))
            except Exception as error:  # noqa: BLE001 - any error is this job's result
                answers.put((key, error))

    for number in range(min(len(jobs), MAX_THREADS)):
        threading.Thread(target=work, name=f"question {number}", daemon=True).start()
    results: dict[_K, _V | Exception] = {}
    while len(results) < len(jobs):
        try:
            key, answer = answers.get(timeout=max(0.0, deadline - monotonic()))
        except queue.Empty:
            break
        results[key] = answer
    timeout_error = DeadlineError(f"no answer within {seconds:g} s")
    return {key: results.get(key, timeout_error) for key in jobs}
