"""Waiting for what comes at once: when it looks first, and when it sleeps."""

from __future__ import annotations

import pytest

from pyros1.net import spin_wait
from pyros1.net.processors import ProcessorTimes
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
        monkeypatch.setattr(spin_wait, "read_processor_times", self.processor_times)

    def processor_times(self) -> ProcessorTimes:
        return ProcessorTimes(self.now, self.idle_processors * self.now, {})

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


class Machine:
    """What the system reports about its processors.

    Attributes:
        at: the time in seconds.
        idle: the idle time so far; None if the system does not report it.
    """

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.at = 100.0
        self.idle: float | None = 500.0
        monkeypatch.setattr(spin_wait, "read_processor_times", lambda: ProcessorTimes(self.at, self.idle, {}))

    def goes_on(self, seconds: float, idle_processors: float) -> float:
        """Let time pass; return the time."""
        assert self.idle is not None
        self.at += seconds
        self.idle += idle_processors * seconds
        return self.at


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> Machine:
    return Machine(monkeypatch)


def busy_guard(machine: Machine) -> PollGuard:
    """Return a guard in a pause of more than half a second, which has just begun."""
    guard = PollGuard(assume_idle=True)
    while guard.paused_until - machine.at < 0.6:
        machine.at = max(machine.at, guard.paused_until + 0.003)
        assert guard.note_poll(machine.at - 2 * PREEMPTION_GAP, machine.at)
    return guard


@pytest.mark.parametrize("idle_processors", [0.0, 0.1])
def test_a_pause_is_extended_while_no_processor_is_idle(machine: Machine, idle_processors: float) -> None:
    guard = busy_guard(machine)
    for _ in range(3):
        now = machine.goes_on(guard.paused_until - machine.at, idle_processors)
        assert not guard.may_poll(now)
        assert guard.paused_until == pytest.approx(now + MAX_PAUSE)


def test_polling_resumes_when_processors_were_idle(machine: Machine) -> None:
    guard = busy_guard(machine)
    assert not guard.may_poll(guard.paused_until - 0.01)
    now = machine.goes_on(guard.paused_until - machine.at, 1.0)
    assert guard.may_poll(now)
    assert guard.may_poll(machine.goes_on(0.5, 0.0)), "it is not checked again while nothing interrupts"
    now = machine.at
    assert guard.note_poll(now - 0.01, now)
    assert guard.paused_until == pytest.approx(now + MIN_PAUSE), "a processor was idle: it was a rare one"


def test_an_interruption_after_an_extended_pause_is_a_rare_one(machine: Machine) -> None:
    guard = busy_guard(machine)
    for _ in range(9):
        assert not guard.may_poll(machine.goes_on(MAX_PAUSE, 0.0))
    now = machine.goes_on(MAX_PAUSE, 1.0)
    assert guard.may_poll(now) and guard.note_poll(now, now + 0.01)
    assert guard.paused_until == pytest.approx(now + 0.01 + MIN_PAUSE)


def test_a_machine_counts_as_busy_as_long_as_checks_fail(machine: Machine) -> None:
    guard = PollGuard()
    assert not guard.may_poll(machine.at) and not guard.is_busy
    assert not guard.may_poll(machine.goes_on(CHECKED_PAUSE, 0.0)) and guard.is_busy
    assert guard.may_poll(machine.goes_on(MAX_PAUSE, 1.0)) and not guard.is_busy


def test_threads_that_share_a_guard_check_at_the_same_time(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    guard = PollGuard()
    guard.may_poll(machine.at)
    now = machine.goes_on(1.0, 1.0)
    read = spin_wait.read_processor_times

    def check_in_another_thread() -> ProcessorTimes:
        monkeypatch.setattr(spin_wait, "read_processor_times", read)
        assert guard.may_poll(now)
        return read()

    monkeypatch.setattr(spin_wait, "read_processor_times", check_in_another_thread)
    assert guard.may_poll(now)


def test_threads_that_share_a_new_guard_all_begin_with_a_pause(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard, read = PollGuard(), spin_wait.read_processor_times

    def check_in_another_thread() -> ProcessorTimes:
        monkeypatch.setattr(spin_wait, "read_processor_times", read)
        assert not guard.may_poll(machine.at)
        return read()

    monkeypatch.setattr(spin_wait, "read_processor_times", check_in_another_thread)
    assert not guard.may_poll(machine.at) and not guard.may_poll(machine.at)


def test_threads_with_a_realtime_priority_poll_at_once_however_busy_the_machine_is(
    machine: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    guard = busy_guard(machine)
    monkeypatch.setattr(spin_wait, "has_realtime_priority", lambda: True)
    assert PollGuard().may_poll(machine.at)
    assert guard.may_poll(machine.goes_on(MAX_PAUSE, 0.0))


def test_systems_that_do_not_tell_whether_they_are_idle(machine: Machine) -> None:
    machine.idle = None
    guard = busy_guard(machine)
    assert not guard.may_poll(guard.paused_until - 0.01) and guard.may_poll(guard.paused_until)


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
