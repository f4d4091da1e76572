"""callback_queue: the queue of a node that spins."""

from __future__ import annotations

import contextlib
from typing import Any

from pyros1.node.callback_queue import CallbackQueue


def test_order_of_arrival() -> None:
    queue, got = CallbackQueue(), []
    for number in range(5):
        queue.push(lambda number=number: got.append(number))  # type: ignore[misc]
    assert len(queue) == 5
    assert queue.run_available() == 5
    assert got == [0, 1, 2, 3, 4]
    assert queue.run_available() == 0


def test_what_callbacks_add_waits_for_the_next_time() -> None:
    queue, got = CallbackQueue(), []

    def again() -> None:
        got.append(1)
        queue.push(again)

    queue.push(again)
    assert queue.run_available() == 1
    assert queue.run_available() == 1
    assert len(got) == 2 and len(queue) == 1


def test_a_callback_that_raises_leaves_the_others(in_thread: Any) -> None:
    queue, got = CallbackQueue(), []

    def interrupted() -> None:
        raise KeyboardInterrupt

    queue.push(interrupted)
    queue.push(lambda: got.append(1))
    with contextlib.suppress(KeyboardInterrupt):
        queue.run_available()
    assert queue.run_available() == 1 and got == [1]


def test_waiting(in_thread: Any) -> None:
    queue = CallbackQueue()
    assert not queue.wait(0)
    assert not queue.wait(0.01)
    waiting = in_thread(queue.wait, 10.0)
    queue.push(lambda: None)
    assert waiting.join() is True
    assert queue.wait(10.0), "at once"


def test_wake_ends_a_wait(in_thread: Any) -> None:
    queue = CallbackQueue()
    waiting = in_thread(queue.wait, 30.0)
    while waiting.thread.is_alive():  # it may not have begun to wait yet
        queue.wake()
        waiting.thread.join(0.001)
    assert waiting.join() is False


def test_two_threads_may_spin(in_thread: Any) -> None:
    queue, got = CallbackQueue(), []
    for number in range(1000):
        queue.push(lambda number=number: got.append(number))  # type: ignore[misc]
    counts = [spinner.join() for spinner in [in_thread(queue.run_available) for _ in range(4)]]
    assert sum(counts) == 1000
    assert sorted(got) == list(range(1000))


def test_a_callback_that_runs_the_rest_itself() -> None:
    """As two threads that spin at once do."""
    queue, got = CallbackQueue(), []
    queue.push(lambda: got.append(("inner", queue.run_available())))
    queue.push(lambda: got.append("rest"))
    assert queue.run_available() == 1
    assert got == ["rest", ("inner", 1)] and not len(queue)
