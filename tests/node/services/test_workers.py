"""workers: threads for calls, reused, and no more than allowed."""

from __future__ import annotations

import threading
import time
from typing import Any

import pytest

from pyros1.node.services.workers import Workers


@pytest.fixture
def workers() -> Any:
    workers = Workers("test", max_threads=3)
    yield workers
    workers.close()


def threads() -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith("test-")]


def test_threads_are_reused(workers: Workers, until: Any) -> None:
    seen: list[threading.Thread] = []
    for count in range(1, 21):
        until(lambda: workers.submit(lambda: seen.append(threading.current_thread())))
        until(lambda: len(seen) == count)  # noqa: B023
    assert len(set(seen)) <= 3


def test_jobs_run_at_the_same_time_up_to_the_limit(workers: Workers) -> None:
    together, leave = threading.Barrier(4), threading.Event()

    def job() -> None:
        together.wait(5)
        leave.wait(5)

    assert all(workers.submit(job) for _ in range(3))
    together.wait(5)
    assert not workers.submit(job), "all threads are busy and no more are allowed"
    leave.set()


def test_idle_threads_end(monkeypatch: pytest.MonkeyPatch, workers: Workers) -> None:
    monkeypatch.setattr("pyros1.node.services.workers.IDLE_TIMEOUT", 0.01)
    done = threading.Event()
    workers.submit(done.set)
    assert done.wait(20)
    for thread in threads():
        thread.join(5)
        assert not thread.is_alive()
    assert workers.submit(lambda: None), "a new one is made"


def test_close_waits_for_jobs_and_refuses_more(workers: Workers) -> None:
    entered, leave, left = threading.Event(), threading.Event(), threading.Event()

    def job() -> None:
        entered.set()
        leave.wait(5)
        left.set()

    workers.submit(job)
    assert entered.wait(20)
    threading.Timer(0.01, leave.set).start()
    workers.close()
    assert left.is_set()
    assert not workers.submit(job)


def test_a_job_may_close(workers: Workers) -> None:
    done = threading.Event()
    workers.submit(lambda: (workers.close(), done.set()))
    assert done.wait(20)


def test_close_waits_no_longer_for_many() -> None:
    workers, started, leave = Workers("test"), threading.Barrier(31), threading.Event()
    for _ in range(30):
        workers.submit(lambda: (started.wait(20), leave.wait(60)))
    started.wait(20)
    begun = time.monotonic()
    workers.close(timeout=0.5)
    took = time.monotonic() - begun
    leave.set()
    for thread in threads():
        thread.join(20)
    assert took < 10, "each for that long would be 15 s"


def test_a_system_without_more_threads(workers: Workers, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_thread: threading.Thread) -> None:
        raise RuntimeError("can't start new thread")

    done = threading.Event()
    with monkeypatch.context() as patch:
        patch.setattr(threading.Thread, "start", refuse)
        assert not workers.submit(done.set)
    assert workers.submit(done.set)
    assert done.wait(20)
