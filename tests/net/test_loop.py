"""net.loop: calls, timers, sockets and errors on the one thread."""

from __future__ import annotations

import select
import socket
import threading
import time
from collections.abc import Iterator
from types import SimpleNamespace

import pytest

from pyros1.ground.errors import DeadlineError
from pyros1.net.loop import READ, WRITE, Loop, LoopThread
from pyros1.net.spin_wait import MIN_PAUSE, PREEMPTION_GAP


@pytest.fixture
def errors() -> list[BaseException]:
    return []


@pytest.fixture
def loop(errors: list[BaseException]) -> Iterator[Loop]:
    loop = Loop("test", errors.append)
    loop.start()
    yield loop
    loop.stop()
    assert not loop.thread.is_alive()


def test_calls_run_in_order_on_the_thread(loop: Loop) -> None:
    order: list[int] = []
    for i in range(1000):
        loop.call_soon(order.append, i)
    assert loop.run(loop.in_loop)
    assert order == list(range(1000))
    assert not loop.in_loop()


def test_calls_made_before_the_start_are_made_after_it() -> None:
    loop = Loop("test")
    done = threading.Event()
    loop.call_soon(done.set)
    loop.call_later(0.0, done.set)
    loop.start()
    assert done.wait(5)
    loop.stop()


def test_timers_run_in_the_order_of_their_time_and_can_be_cancelled(loop: Loop) -> None:
    order: list[str] = []
    done = threading.Event()
    handles = {name: loop.call_later(delay, order.append, name) for name, delay in (("late", 0.03), ("soon", 0.01))}
    cancelled = loop.call_later(0.02, order.append, "never")
    loop.call_later(0.06, done.set)
    cancelled.cancel()
    assert cancelled.cancelled
    assert done.wait(5)
    until = time.monotonic() + 5
    while len(order) < 2 and time.monotonic() < until:  # this thread may have been slow between the calls
        loop.run(lambda: None)
    assert order == sorted(handles, key=lambda name: handles[name].when)


def test_a_timer_of_a_sleeping_loop_wakes_it(loop: Loop) -> None:
    done = threading.Event()
    loop.run(lambda: None)
    loop.call_later(0.001, done.set)
    assert done.wait(5)


def test_many_threads_wake_the_loop_without_losing_a_call(loop: Loop) -> None:
    for _ in range(300):
        done = threading.Semaphore(0)
        threads = [threading.Thread(target=loop.call_soon, args=(done.release,)) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        for _ in threads:
            assert done.acquire(timeout=20)


def test_an_error_is_reported_and_the_loop_goes_on(loop: Loop, errors: list[BaseException]) -> None:
    def fail() -> None:
        raise ValueError("x")

    done = threading.Event()
    loop.call_soon(fail)
    loop.call_later(0.0, fail)
    loop.call_later(0.01, done.set)
    assert done.wait(5)
    assert [str(error) for error in errors] == ["x", "x"]


def test_run_returns_and_raises(loop: Loop) -> None:
    assert loop.run(lambda a, b: a + b, 1, 2) == 3
    with pytest.raises(ZeroDivisionError):
        loop.run(lambda: 1 // 0)
    gate = threading.Event()
    loop.call_soon(gate.wait)
    with pytest.raises(DeadlineError):
        loop.run(lambda: None, timeout=0.05)
    gate.set()


def test_sockets(loop: Loop, errors: list[BaseException]) -> None:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        ours.setblocking(False)
        got: list[bytes] = []
        arrived = threading.Semaphore(0)

        def ready(mask: int) -> None:
            got.append(ours.recv(100) if mask & READ else b"")
            arrived.release()

        loop.run(loop.register, ours, READ, ready)
        for text in (b"a", b"b"):
            theirs.send(text)
            assert arrived.acquire(timeout=20)
        assert got == [b"a", b"b"]
        # The same callback again must still be called.
        loop.run(loop.modify, ours, READ, ready)
        theirs.send(b"c")
        assert arrived.acquire(timeout=20)
        writable = threading.Event()

        def write(mask: int) -> None:
            loop.unregister(ours)
            writable.set()

        loop.run(loop.modify, ours, READ | WRITE, write)
        assert writable.wait(20)
        loop.run(loop.unregister, ours)
    assert errors == []


def test_a_callback_unregistered_in_the_same_round_is_not_called(loop: Loop) -> None:
    pairs = [socket.socketpair() for _ in range(2)]
    called: list[int] = []
    done = threading.Event()

    def ready(index: int) -> None:
        called.append(index)
        for ours, _ in pairs:
            loop.unregister(ours)
        done.set()

    def register() -> None:
        for index, (ours, theirs) in enumerate(pairs):
            theirs.send(b"x")
            loop.register(ours, READ, lambda mask, index=index: ready(index))

    loop.call_soon(register)
    assert done.wait(5)
    loop.run(lambda: None)
    assert len(called) == 1
    for pair in pairs:
        for sock in pair:
            sock.close()


def test_stop_ends_the_thread_and_drops_later_calls() -> None:
    loop = Loop("test")
    loop.start()
    assert isinstance(loop.thread, LoopThread)
    loop.thread.owner = loop
    loop.call_soon(loop.stop)
    loop.thread.join(5)
    assert not loop.thread.is_alive()
    loop.call_soon(pytest.fail, "must not be called")
    loop.stop()
    Loop("never started").stop()


class Polls:
    """A loop that polls for 100 us of a clock that each poll advances, and how often it does so before it sleeps."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now, self.step, self._count, self._sleeps = time.monotonic(), 1e-6, 0, threading.Event()
        epoll = select.epoll()

        def poll(seconds: float) -> list[tuple[int, int]]:
            if seconds:
                self._sleeps.set()
            return epoll.poll(seconds)

        watched = SimpleNamespace(
            poll=poll, register=epoll.register, modify=epoll.modify, unregister=epoll.unregister, close=epoll.close
        )
        monkeypatch.setattr(select, "epoll", lambda: watched)
        monkeypatch.setattr("pyros1.net.loop.monotonic", lambda: self.now)
        monkeypatch.setattr("pyros1.net.loop.yield_processor", self._pass)
        self.loop = Loop("test", spin_time=100e-6)

    def _pass(self) -> None:
        self.now += self.step
        self._count += 1

    def after_an_event(self) -> int:
        assert self._sleeps.wait(20)
        self._sleeps.clear()
        self._count = 0
        self.loop.call_soon(lambda: None)
        assert self._sleeps.wait(20)
        return self._count


@pytest.mark.skipif(not hasattr(select, "epoll"), reason="this system has no epoll")
def test_a_loop_polls_in_a_series_of_events_unless_others_need_the_processor(monkeypatch: pytest.MonkeyPatch) -> None:
    polls = Polls(monkeypatch)
    polls.loop.start()
    try:
        assert polls.after_an_event() == 0
        for _ in range(3):
            assert polls.after_an_event() == pytest.approx(100, abs=1)
        polls.step = 2 * PREEMPTION_GAP
        assert polls.after_an_event() == 1
        polls.step = 1e-6
        for _ in range(2):
            assert polls.after_an_event() == 0
        polls.now += MIN_PAUSE
        assert polls.after_an_event() == 0
        assert polls.after_an_event() == pytest.approx(100, abs=1)
        for _ in range(3):  # a client that calls once per millisecond
            polls.now += 1e-3
            assert polls.after_an_event() == 0
    finally:
        polls.loop.stop()
