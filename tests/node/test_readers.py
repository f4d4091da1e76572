"""readers: few threads for many subscriptions, and none that waits for another's callback."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.msgs import load_message
from pyros1.node import readers

Float64: Any = load_message("std_msgs/Float64")


def reader_threads(name: str) -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith(f"/{name}:reader")]


def test_idle_subscriptions_share_two_threads(
    make_node: Any, transport: str, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(readers, "REST", 0.01)
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    count = 60
    publishers = [talker.advertise(f"t{i}", Float64, queue_size=1) for i in range(count)]
    for i in range(count):
        listener.subscribe(f"t{i}", Float64, got)
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=5)
    for i, publisher in enumerate(publishers):
        publisher.publish(i)
        got.wait(i + 1)
    assert got.data == list(range(count))
    for thread in reader_threads("listener")[readers.SPARE + 1 :]:  # on a busy machine one may have been started
        thread.join(10)
    assert len(reader_threads("listener")) <= readers.SPARE + 1


def test_as_many_callbacks_as_topics_run_at_once(make_node: Any, transport: str) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    count = 8
    together = threading.Barrier(count + 1, timeout=10)
    publishers = [talker.advertise(f"t{i}", Float64, queue_size=1) for i in range(count)]
    for i in range(count):
        listener.subscribe(f"t{i}", Float64, lambda _: together.wait())
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=5)
        publisher.publish(1)
    together.wait()  # breaks if one of them has to wait for another


def test_threads_that_are_not_needed_any_more_end(
    make_node: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(readers, "REST", 0.01)
    test_as_many_callbacks_as_topics_run_at_once(make_node, transport)
    end = time.monotonic() + 10
    while len(alive := reader_threads("listener")) > readers.SPARE + 1:
        assert time.monotonic() < end, f"{len(alive)} threads are left"
        alive[0].join(0.01)  # which of them rest is not known


class Script:
    """Stands for a Poller: answers `wait` with what the test says, and knows which threads wait for how long."""

    def __init__(self) -> None:
        self.limits: dict[threading.Thread, float] = {}
        self._answers: queue.Queue[int | None] = queue.Queue()
        self._changed = threading.Condition()

    def wait(self, limit: float) -> int | None:
        with self._changed:
            self.limits[threading.current_thread()] = limit
            self._changed.notify_all()
        answer = self._answers.get(timeout=10)
        with self._changed:
            del self.limits[threading.current_thread()]
        return answer

    def wake(self) -> None:
        self._answers.put(readers.BELL)

    def time_is_over(self) -> None:
        self._answers.put(None)

    def until(self, condition: Callable[[list[float]], bool]) -> None:
        with self._changed:
            assert self._changed.wait_for(lambda: condition(list(self.limits.values())), 10), self.limits

    def all_wait(self, pool: readers.Readers) -> list[float]:
        self.until(lambda limits: self._answers.empty() and len(limits) == len(pool._threads) == pool._waiting)
        return list(self.limits.values())

    def close(self) -> None:
        pass


class SlowLock:
    """A lock that lets other threads go first after each use."""

    def __init__(self) -> None:
        self._lock = threading.Lock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *_: object) -> None:
        self._lock.release()
        time.sleep(0.001)


class Work:
    """A channel that runs a function."""

    def __init__(self, function: Callable[[], object]) -> None:
        self._function = function

    def run(self, fd: int | None) -> None:
        self._function()


def test_threads_whose_rest_is_over_at_the_same_moment_do_not_all_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(readers, "Poller", Script)
    pool = readers.Readers("pool", lambda error: None)
    script: Any = pool._poller
    pool._lock = SlowLock()  # type: ignore[assignment]
    together = threading.Barrier(4, timeout=10)
    try:
        for _ in range(3):
            pool.wake(Work(together.wait))
        together.wait()
        limits = script.all_wait(pool)
        while min(limits) < 0:  # until all have been woken once more
            pool.wake(Work(lambda: None))
            limits = script.all_wait(pool)
        for _ in limits:
            script.time_is_over()
        script.until(lambda limits: len(limits) == readers.SPARE == pool._waiting)
    finally:
        pool.close()


def test_a_system_without_more_threads_costs_no_message(
    make_node: Any, transport: str, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    publishers = [talker.advertise(f"t{i}", Float64, queue_size=1000) for i in range(4)]
    for i in range(4):
        listener.subscribe(f"t{i}", Float64, got)
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=5)
    start = threading.Thread.start

    def none_left(thread: threading.Thread) -> None:
        if ":reader" in thread.name:
            raise RuntimeError("can't start new thread")
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", none_left)
    for number in range(200):
        for publisher in publishers:
            publisher.publish(number)
    assert sorted(item.data for item in got.wait(800)) == sorted(list(range(200)) * 4)


def test_a_fault_does_not_end_a_thread(make_node: Any, collect: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    listener, talker, got = make_node("listener"), make_node("talker"), collect()
    subscriber = listener.subscribe("t", Float64, got)
    errors: list[Exception] = []
    noticed = threading.Event()
    monkeypatch.setattr(listener._context.readers, "_on_error", lambda error: (errors.append(error), noticed.set()))

    def fail() -> None:
        raise RuntimeError("a fault")

    subscriber._subscription.reader.submit(fail)
    assert noticed.wait(5) and str(errors[0]) == "a fault"
    publisher = talker.advertise("t", Float64, queue_size=1)
    assert publisher.wait_for_subscribers(timeout=5)
    publisher.publish(1)
    got.wait(1)
