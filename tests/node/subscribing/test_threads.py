"""threads: few threads for many subscriptions, and none that waits for another's callback.

Feature: hundreds of idle connections need no threads of their own -- two threads wait for all of them
"""

from __future__ import annotations

import queue
import sys
import threading
import time
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.msgs import load_message
from pyros1.node.subscribing import threads as readers

from ...bodies import encode_frame
from ...parts import context_of, subscription_of

Float64: Any = load_message("std_msgs/Float64")


def reader_threads(name: str) -> list[threading.Thread]:
    return [thread for thread in threading.enumerate() if thread.name.startswith(f"/{name}:reader")]


def test_idle_subscriptions_share_two_threads(
    make_node: Any, transport: str, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(readers, "IDLE_TIMEOUT", 0.01)
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    count = 60
    publishers = [talker.advertise(f"t{i}", Float64, queue_size=1) for i in range(count)]
    for i in range(count):
        listener.subscribe(f"t{i}", Float64, got)
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=20)
    for i, publisher in enumerate(publishers):
        publisher.publish(i)
        got.wait(i + 1)
    assert got.data == list(range(count))
    for thread in reader_threads("listener")[
        readers.MIN_WAITING_THREADS + 1 :
    ]:  # on a busy machine one may have been started
        thread.join(10)
    assert len(reader_threads("listener")) <= readers.MIN_WAITING_THREADS + 1


def test_as_many_callbacks_as_topics_run_at_once(make_node: Any, transport: str) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    count = 8
    together = threading.Barrier(count + 1, timeout=20)
    publishers = [talker.advertise(f"t{i}", Float64, queue_size=1) for i in range(count)]
    for i in range(count):
        listener.subscribe(f"t{i}", Float64, lambda _: together.wait())
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=20)
        publisher.publish(1)
    together.wait()  # breaks if one of them has to wait for another


def test_threads_that_are_not_needed_any_more_end(
    make_node: Any, transport: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(readers, "IDLE_TIMEOUT", 0.01)
    test_as_many_callbacks_as_topics_run_at_once(make_node, transport)
    end = time.monotonic() + 20
    while len(alive := reader_threads("listener")) > readers.MIN_WAITING_THREADS + 1:
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
        answer = self._answers.get(timeout=20)
        with self._changed:
            del self.limits[threading.current_thread()]
        return answer

    def wake(self) -> None:
        self._answers.put(readers.WAKE)

    def time_is_over(self) -> None:
        self._answers.put(None)

    def until(self, condition: Callable[[list[float]], bool]) -> None:
        end = time.monotonic() + 20
        with self._changed:
            while not condition(list(self.limits.values())):
                assert time.monotonic() < end, self.limits
                self._changed.wait(0.01)  # the end of a thread is not told

    def all_wait(self) -> list[float]:
        """Wait until all threads do, and return for how long each does."""
        self.until(lambda limits: self._answers.empty() and len(limits) == len(reader_threads("pool")))
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
    script = Script()
    with monkeypatch.context() as patch:
        patch.setattr(readers, "Poller", lambda: script)
        patch.setattr(threading, "RLock", SlowLock)
        pool = readers.DeliveryThreads("/pool", lambda error: None)
    together = threading.Barrier(4, timeout=20)
    try:
        for _ in range(3):
            pool.wake(Work(together.wait))
        together.wait()
        limits = script.all_wait()
        while min(limits) < 0:  # until all have been woken once more
            pool.wake(Work(lambda: None))
            limits = script.all_wait()
        for _ in limits:
            script.time_is_over()
        script.until(lambda limits: len(limits) == 2 == len(reader_threads("pool")))
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
        assert publisher.wait_for_subscribers(timeout=20)
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


@pytest.fixture
def no_more_threads(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """While names are in the list, no reader thread is started but the first; the refused ones' names come into it."""
    start, refused = threading.Thread.start, ["none yet"]

    def refuse(thread: threading.Thread) -> None:
        if refused and ":reader" in thread.name and not thread.name.endswith("reader1"):
            refused.append(thread.name)
            raise RuntimeError("can't start new thread")
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", refuse)
    return refused


def test_a_busy_topic_does_not_starve_others_without_more_threads(
    make_node: Any, fake_node: Any, collect: Any, watch_log: Any, in_thread: Any, no_more_threads: list[str]
) -> None:
    fake, listener, busy, rare = fake_node("/fake"), make_node("listener"), collect(), collect()
    log, ended = watch_log(listener), threading.Event()
    fake.publish("/busy")
    listener.subscribe("busy", Float64, busy)
    first = fake.accept_subscriber()

    def publish() -> None:
        while not ended.wait(0.002):
            first.sendall(encode_frame(Float64(1)))

    running = in_thread(publish)
    busy.wait(20)
    fake.publish("/rare")
    listener.subscribe("rare", Float64, rare)
    second = fake.accept_subscriber()
    for number in range(5):
        second.sendall(encode_frame(Float64(number)))
        rare.wait(number + 1)
    assert len(no_more_threads) > 2
    no_more_threads.clear()  # there are some again
    second.sendall(encode_frame(Float64(5)))
    rare.wait(6)
    ended.set()
    running.join()
    told = [text for text in log.texts if "callbacks of several topics share one" in text]
    assert len(told) in (1, 2), "once, or twice if the last one that was refused was late to say so"


def test_when_the_program_ends_no_thread_is_missed(
    make_node: Any,
    collect: Any,
    watch_log: Any,
    no_more_threads: list[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    log = watch_log(listener)
    over = threading.Thread(target=lambda: None)
    monkeypatch.setattr(threading, "main_thread", lambda: over)  # Python 3.12 starts no threads after its end
    listener.subscribe("t", Float64, got)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    for number in range(3):
        publisher.publish(number)
    got.wait(3)
    assert len(no_more_threads) > 1
    assert not [text for text in log.texts if "share one" in text]


def test_a_subscription_for_which_there_is_no_thread_leaves_nothing(
    make_node: Any, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    with monkeypatch.context() as patch:
        patch.setattr(
            readers.DeliveryThreads, "wake", lambda *_: (_ for _ in ()).throw(RuntimeError("can't start new thread"))
        )
        with pytest.raises(RuntimeError, match="new thread"):
            listener.subscribe("t", Float64, got)
    listener.subscribe("t", Float64, got)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    got.wait(1)


def test_an_error_that_cannot_be_told_ends_no_thread(
    make_node: Any, collect: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As when the system opens no more files: what tells of errors loads modules."""
    talker, listener, got = make_node("talker"), make_node("listener"), collect()
    listener.subscribe("t", Float64, got)

    def fail(*_: object, **__: object) -> None:
        raise OSError(24, "Too many open files")

    written: queue.Queue[str] = queue.Queue()
    text = "OSError(24, 'Too many open files'); reporting this also failed: OSError(24, 'Too many open files')"
    with monkeypatch.context() as patch:
        patch.setattr(type(listener.log), "exception", fail)
        patch.setattr(sys, "stderr", SimpleNamespace(write=written.put, flush=lambda: None))
        for _ in range(4):  # more than there are threads
            subscription_of(listener).delivery.submit(fail)
        context_of(listener).loop.call_soon(fail)
        for _ in range(4):
            while text not in written.get(timeout=20):
                pass
    publisher = talker.advertise("t", Float64, queue_size=10)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    got.wait(1)


def test_a_fault_does_not_end_a_thread(make_node: Any, collect: Any, watch_log: Any) -> None:
    listener, talker, got = make_node("listener"), make_node("talker"), collect()
    listener.subscribe("t", Float64, got)
    log = watch_log(listener)

    def fail() -> None:
        raise RuntimeError("a fault")

    subscription_of(listener).delivery.submit(fail)
    log.saw("internal error in a subscription", "RuntimeError: a fault")
    publisher = talker.advertise("t", Float64, queue_size=1)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    got.wait(1)
