"""Threads for work that may take long."""

from __future__ import annotations

import subprocess
import sys
import threading
import time
from concurrent.futures import CancelledError, wait

import pytest

from pyros1.web.server.threads import ThreadPool

PATIENCE = 20.0


def test_results_and_errors() -> None:
    threads = ThreadPool(2, "test")
    assert threads.submit(pow, 2, 10).result(PATIENCE) == 1024
    with pytest.raises(ZeroDivisionError):
        threads.submit(lambda: 1 / 0).result(PATIENCE)
    threads.shutdown()


def test_no_more_at_once_than_there_may_be() -> None:
    threads = ThreadPool(3, "test")
    together = threading.Barrier(3)
    first = [threads.submit(together.wait, PATIENCE) for _ in range(3)]
    wait(first, PATIENCE)
    running, max_threads, lock = 0, 0, threading.Lock()

    def count() -> None:
        nonlocal running, max_threads
        with lock:
            running += 1
            max_threads = max(max_threads, running)
        with lock:
            running -= 1

    wait([threads.submit(count) for _ in range(200)], PATIENCE)
    assert 1 <= max_threads <= 3
    threads.shutdown()


def test_the_work_of_a_lane_is_done_in_order() -> None:
    threads = ThreadPool(1, "test")
    go_on, done = threading.Event(), []
    threads.submit(go_on.wait, PATIENCE)
    queue = threads.queue()
    futures = [queue.submit(done.append, number) for number in range(10)]
    go_on.set()
    wait(futures, PATIENCE)
    assert done == list(range(10))
    threads.shutdown()


def test_what_has_not_begun_is_left_out_at_the_end() -> None:
    threads = ThreadPool(1, "test")
    begun, go_on = threading.Event(), threading.Event()
    first = threads.submit(lambda: (begun.set(), go_on.wait(PATIENCE)))
    assert begun.wait(PATIENCE)
    second = threads.submit(pow, 2, 2)
    threads.shutdown(wait=False, cancel_futures=True)
    with pytest.raises(CancelledError):
        second.result(PATIENCE)
    with pytest.raises(RuntimeError, match="shutting down"):
        threads.submit(pow, 2, 2)
    go_on.set()
    assert first.result(PATIENCE)
    threads.shutdown()


def test_a_program_ends_though_work_goes_on() -> None:
    code = "import time; from pyros1.web.server.threads import ThreadPool; "
    code += "ThreadPool(1, 'x').submit(time.sleep, 1000); print('end')"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE, check=True)
    assert done.stdout == "end\n"


def test_lanes_take_turns() -> None:
    threads = ThreadPool(1, "test")
    begun, go_on = threading.Event(), threading.Event()
    threads.submit(lambda: (begun.set(), go_on.wait(PATIENCE)))
    assert begun.wait(PATIENCE)
    done: list[str] = []
    busy, other = threads.queue(), threads.queue()
    work = [busy.submit(done.append, "busy") for _ in range(100)]
    work += [other.submit(done.append, "other") for _ in range(2)]
    go_on.set()
    wait(work, PATIENCE)
    assert done[:4] == ["busy", "other", "busy", "other"] and len(done) == 102
    threads.shutdown()


def test_threads_without_work_end_and_others_are_made() -> None:
    threads = ThreadPool(5, "idle test", idle_timeout=0.01)

    def count() -> int:
        return sum(thread.name.startswith("idle test") for thread in threading.enumerate())

    for _ in range(3):
        together = threading.Barrier(5)
        wait([threads.submit(together.wait, PATIENCE) for _ in range(5)], PATIENCE)
        deadline = time.monotonic() + PATIENCE
        while count():
            assert time.monotonic() < deadline
            time.sleep(0.01)
    assert threads.submit(pow, 2, 3).result(PATIENCE) == 8
    threads.shutdown()


def test_work_that_waits_is_done_before_the_end() -> None:
    threads = ThreadPool(1, "test")
    done: list[int] = []
    work = [threads.queue().submit(done.append, number) for number in range(50)]
    threads.shutdown()
    assert done == list(range(50)) and all(each.done() for each in work)
