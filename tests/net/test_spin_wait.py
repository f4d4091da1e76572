"""Waiting for what comes at once: when it looks first, and when it sleeps."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from pyros1.net import spin_wait
from pyros1.net.spin_wait import (
    CHECKED_PAUSE,
    MAX_PAUSE,
    MAX_SERIES_GAP,
    MIN_PAUSE,
    PREEMPTION_GAP,
    SPIN_TIME,
    PollGuard,
    SpinWait,
)


class Peer:
    """What comes after a time each, on a clock of its own that goes on with each look at it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        self.comes = 0.0
        self.calls: list[str] = []
        self.step = 1e-6
        monkeypatch.setattr(spin_wait, "perf_counter", lambda: self.now)
        monkeypatch.setattr(spin_wait, "DONTWAIT", 64)
        self.idle_processors = 1.0
        monkeypatch.setattr(spin_wait, "idle_time", lambda: self.idle_processors * self.now)

    def receive(self, flags: int) -> str:
        self.now += self.step
        if flags:
            if not self.calls or self.calls[-1] != "look":
                self.calls.append("look")
            if self.now < self.comes:
                raise BlockingIOError
        else:
            self.calls.append("sleep")
            self.now = max(self.now, self.comes)
        return "data"

    def how(self, waiting: SpinWait, seconds: float) -> list[str]:
        """Return how it waits for data that come in so many seconds."""
        self.calls = []
        self.comes = self.now + seconds
        assert waiting.wait(self.receive) == "data"
        return self.calls

    def ready(self) -> SpinWait:
        """Return one that has made sure that a processor is idle, and looks at its next wait."""
        waiting = SpinWait()
        for _ in range(2):
            assert self.how(waiting, SPIN_TIME / 2) == ["sleep"]
        self.now += CHECKED_PAUSE
        assert self.how(waiting, SPIN_TIME / 2) == ["sleep"]
        return waiting


@pytest.fixture
def peer(monkeypatch: pytest.MonkeyPatch) -> Peer:
    return Peer(monkeypatch)


@pytest.mark.parametrize(("idle_processors", "looks"), [(0.0, False), (0.4, False), (0.6, True), (3.0, True)])
def test_a_series_sleeps_until_it_is_known_that_a_processor_is_idle(
    peer: Peer, idle_processors: float, looks: bool
) -> None:
    peer.idle_processors = idle_processors
    waiting, start, found = SpinWait(), peer.now, []
    while peer.now < start + 3 * MAX_PAUSE:
        found.append((peer.now - start, peer.how(waiting, SPIN_TIME / 2) == ["look"]))
        peer.now += MAX_SERIES_GAP / 2
    assert not any(look for when, look in found if when < CHECKED_PAUSE)
    assert all(look is looks for when, look in found if when > CHECKED_PAUSE + 2 * MAX_SERIES_GAP)


def test_a_series_of_short_waits_looks(peer: Peer) -> None:
    waiting = peer.ready()
    for _ in range(3):
        assert peer.how(waiting, SPIN_TIME / 2) == ["look"]
        peer.now += MAX_SERIES_GAP / 2


def test_who_looked_in_vain_sleeps_until_waits_are_short_again(peer: Peer) -> None:
    waiting = peer.ready()
    start = peer.now
    assert peer.how(waiting, 1.0) == ["look", "sleep"]
    assert peer.now == pytest.approx(start + 1.0)
    assert peer.how(waiting, SPIN_TIME / 2) == ["sleep"]
    assert peer.how(waiting, SPIN_TIME / 2) == ["look"]


def test_calls_now_and_then_sleep(peer: Peer) -> None:
    waiting = SpinWait()
    for _ in range(3):
        assert peer.how(waiting, SPIN_TIME / 2) == ["sleep"]
        peer.now += MAX_SERIES_GAP


def test_on_a_busy_machine_waits_sleep(peer: Peer) -> None:
    waiting = peer.ready()
    peer.step = 2 * PREEMPTION_GAP  # others have the processor between two looks
    assert peer.how(waiting, 5 * PREEMPTION_GAP) == ["look", "sleep"]
    peer.step = 1e-6
    busy = peer.now
    while peer.now < busy + MIN_PAUSE - 4 * PREEMPTION_GAP - MAX_SERIES_GAP:  # since the interruption
        assert peer.how(waiting, SPIN_TIME / 2) == ["sleep"]
        peer.now += MAX_SERIES_GAP / 2
    peer.now = busy + MIN_PAUSE
    peer.how(waiting, SPIN_TIME / 2)
    assert peer.how(waiting, SPIN_TIME / 2) == ["look"]


def test_systems_without_such_a_look(peer: Peer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spin_wait, "DONTWAIT", 0)
    waiting = SpinWait()
    for _ in range(3):
        assert peer.how(waiting, SPIN_TIME / 2) == ["sleep"]


def test_the_end_of_a_wait_that_sleeps(peer: Peer) -> None:
    def late(flags: int) -> str:
        raise BlockingIOError

    waiting = peer.ready()
    peer.now += MAX_SERIES_GAP
    with pytest.raises(BlockingIOError):
        waiting.wait(late)


def busy_guard(pause: float) -> tuple[PollGuard, float]:
    """Return a guard whose last pause was of that length, and the time at which it ends."""
    guard, now = PollGuard(assume_idle=True), 100.0
    while guard.paused_until - now < pause:
        now = guard.paused_until + 0.003 if guard.paused_until else now
        assert guard.note_poll(now - 2 * PREEMPTION_GAP, now)
    return guard, guard.paused_until


@pytest.mark.parametrize("idle", [0.0, 0.1])
def test_a_pause_is_extended_while_no_processor_is_idle(monkeypatch: pytest.MonkeyPatch, idle: float) -> None:
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 500.0)
    guard, now = busy_guard(0.6)
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 500.0 + idle)
    for _ in range(3):
        assert not guard.may_poll(now) and not guard.may_poll(now + 0.9 * MAX_PAUSE)
        now += MAX_PAUSE
        idle *= 2


def test_polling_resumes_when_processors_were_idle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 500.0)
    guard, now = busy_guard(0.6)
    assert not guard.may_poll(now - 0.01)
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 500.7)
    assert guard.may_poll(now)
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 500.0)
    assert guard.may_poll(now + 0.5)  # it is not asked again while nothing interrupts
    assert guard.note_poll(now, now + 0.5)
    assert guard.paused_until == pytest.approx(now + 0.5 + MIN_PAUSE), "a processor was idle: it was a rare one"


def test_an_interruption_after_an_extended_pause_is_a_rare_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 500.0)
    guard, now = busy_guard(0.6)
    for _ in range(9):
        assert not guard.may_poll(now)
        now += MAX_PAUSE
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 509.0)
    assert guard.may_poll(now) and guard.note_poll(now, now + 0.01)
    assert guard.paused_until == pytest.approx(now + 0.01 + MIN_PAUSE)


def test_a_machine_counts_as_busy_as_long_as_checks_fail(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 500.0)
    guard = PollGuard()
    assert not guard.may_poll(100.0) and not guard.is_busy
    assert not guard.may_poll(100.0 + CHECKED_PAUSE) and guard.is_busy
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 502.0)
    assert guard.may_poll(101.0 + CHECKED_PAUSE) and not guard.is_busy


def test_threads_that_share_a_guard_check_at_the_same_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 500.0)
    guard = PollGuard()
    guard.may_poll(100.0)

    def check_in_another_thread() -> float:
        monkeypatch.setattr(spin_wait, "idle_time", lambda: 501.0)
        assert guard.may_poll(101.0)
        return 501.0

    monkeypatch.setattr(spin_wait, "idle_time", check_in_another_thread)
    assert guard.may_poll(101.0)


def test_threads_with_a_realtime_priority_poll_at_once_however_busy_the_machine_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(spin_wait, "idle_time", lambda: 500.0)
    monkeypatch.setattr(spin_wait, "has_realtime_priority", lambda: True)
    assert PollGuard().may_poll(100.0)
    guard, now = busy_guard(0.6)
    assert guard.may_poll(now)


@pytest.mark.parametrize(
    ("policy", "found"), [("SCHED_OTHER", False), ("SCHED_BATCH", False), ("SCHED_FIFO", True), ("SCHED_RR", True)]
)
@pytest.mark.skipif(not hasattr(os, "SCHED_RESET_ON_FORK"), reason="needs Linux")
def test_realtime_priorities(monkeypatch: pytest.MonkeyPatch, policy: str, found: bool) -> None:
    assert not spin_wait.has_realtime_priority()
    for flag in (0, os.SCHED_RESET_ON_FORK):
        monkeypatch.setattr(os, "sched_getscheduler", lambda pid, flag=flag: getattr(os, policy) | flag)
        assert spin_wait.has_realtime_priority() is found


def test_systems_that_do_not_tell_whether_they_are_idle(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(spin_wait, "idle_time", lambda: None)
    guard, now = busy_guard(0.6)
    assert not guard.may_poll(now - 0.01) and guard.may_poll(now)


@pytest.mark.skipif(not Path("/proc/stat").exists(), reason="needs Linux")
def test_the_idle_time_grows_no_faster_than_all_processors_together() -> None:
    start, first = time.monotonic(), spin_wait.idle_time()
    assert first is not None and first > 0.0
    while (later := spin_wait.idle_time()) == first and time.monotonic() < start + 0.1:
        pass
    assert later is not None and 0.0 <= later - first <= (time.monotonic() - start + 0.03) * (os.cpu_count() or 1)


@pytest.mark.parametrize(("processors", "ticks"), [({0}, 4005), ({1, 10}, 77), ({0, 1, 10, 11}, 4082), (set(), 0)])
def test_the_idle_time_of_some_processors(processors: set[int], ticks: int) -> None:
    """Idle processors and those that wait for disks count; those that are switched off have no line."""
    text = b"""cpu  9 9 9 999999 9 9 9 9 0 0
cpu0 1 2 3 4000 5 6 7 8 0 0
cpu1 1 2 3 70 0 6 7 8 0 0
cpu10 1 2 3 0 7 6 7 8 0 0
intr 123456 0 1
cpu11 0 0 0 1 1
"""
    assert spin_wait.sum_idle_ticks(text.splitlines(keepends=True), processors) == ticks


@pytest.mark.parametrize("line", [b"cpu0 1 2 3\n", b"cpu0 1 2 3 four 5\n", b"cpus 1 2 3 4 5\n", b"\n"])
def test_odd_lines_of_processors(line: bytes) -> None:
    with pytest.raises((ValueError, IndexError)):
        spin_wait.sum_idle_ticks([line], {0})


def test_pauses_double_while_the_machine_is_busy() -> None:
    guard, now = PollGuard(assume_idle=True), 100.0
    pauses = []
    for _ in range(9):
        assert guard.note_poll(now - 2 * PREEMPTION_GAP, now)
        pauses.append(guard.paused_until - now)
        now = guard.paused_until + 0.003  # the next poll is interrupted at once
    assert pauses == pytest.approx([*(MIN_PAUSE * 2**n for n in range(7)), MAX_PAUSE, MAX_PAUSE])


def test_rare_interruptions_pause_briefly() -> None:
    guard, now = PollGuard(assume_idle=True), 100.0
    for _ in range(5):
        assert guard.note_poll(now - 2 * PREEMPTION_GAP, now)
        assert guard.paused_until - now == pytest.approx(MIN_PAUSE)
        assert not guard.note_poll(now + 0.02, now + 0.02 + PREEMPTION_GAP / 2)
        now += 4 * MIN_PAUSE


def test_after_a_busy_time_the_first_interruption_is_a_rare_one_again() -> None:
    guard, now = PollGuard(assume_idle=True), 100.0
    for _ in range(9):
        guard.note_poll(now - 2 * PREEMPTION_GAP, now)
        now = guard.paused_until
    now += 2.1 * MAX_PAUSE
    assert guard.note_poll(now - 2 * PREEMPTION_GAP, now)
    assert guard.paused_until - now == pytest.approx(MIN_PAUSE)
