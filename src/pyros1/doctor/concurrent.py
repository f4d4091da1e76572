"""Runs requests concurrently with a common timeout, so that a host that does not respond does not delay the others."""

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


def run_concurrently(jobs: Mapping[_K, Callable[[], _V]], timeout: float) -> dict[_K, _V | Exception]:
    """Run functions concurrently.

    Args:
        jobs: the functions to run, by any key. A function that has not returned in time keeps running in its daemon
            thread, since host name lookups cannot be interrupted.
        timeout: the number of seconds for all functions together. It is extended by the same amount for every further
            MAX_THREADS jobs, so that jobs that hang do not use up the time of the others.

    Returns:
        The result of each function, or the exception it raised, or a DeadlineError, by key and in the same order.
    """
    pending: queue.SimpleQueue[_K] = queue.SimpleQueue()
    finished: queue.SimpleQueue[tuple[_K, _V | Exception]] = queue.SimpleQueue()
    for key in jobs:
        pending.put(key)
    timeout *= max(1, -(-len(jobs) // MAX_THREADS))
    deadline = monotonic() + timeout

    def run_jobs() -> None:
        while monotonic() < deadline:
            try:
                key = pending.get_nowait()
            except queue.Empty:
                return
            try:
                finished.put((key, jobs[key]()))
            except Exception as error:  # noqa: BLE001 - any error is this job's result
                finished.put((key, error))

    for number in range(min(len(jobs), MAX_THREADS)):
        threading.Thread(target=run_jobs, name=f"request {number}", daemon=True).start()
    results: dict[_K, _V | Exception] = {}
    while len(results) < len(jobs):
        try:
            key, result = finished.get(timeout=max(0.0, deadline - monotonic()))
        except queue.Empty:
            break
        results[key] = result
    timeout_error = DeadlineError(f"no response within {timeout:g} s")
    return {key: results.get(key, timeout_error) for key in jobs}
