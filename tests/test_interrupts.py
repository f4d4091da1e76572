"""When a second signal counts, and that signals come though the parent blocked them."""

from __future__ import annotations

import signal

from pyros1.interrupts import DELIBERATE, Insistence, catch


def test_what_a_person_can_have_meant_counts() -> None:
    times = iter([100.0, 100.001, 100.0 + 0.9 * DELIBERATE, 100.0 + DELIBERATE, 100.1 + DELIBERATE, 200.0])
    insistence = Insistence(lambda: next(times))
    assert [insistence.again() for _ in range(6)] == [True, False, False, True, False, True]
    assert insistence.count == 3


def test_a_key_held_down_counts_twice_a_second() -> None:
    times = iter([100.0 + step / 30 for step in range(31)])
    insistence = Insistence(lambda: next(times))
    assert sum(insistence.again() for _ in range(31)) == 1 + round(1.0 / DELIBERATE)


def test_blocked_and_ignored_signals_come() -> None:
    """As fish and sh start what runs in the background."""
    former = signal.signal(signal.SIGINT, signal.SIG_IGN)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        came: list[int] = []
        restore = catch(lambda number, frame: came.append(number))
        signal.raise_signal(signal.SIGINT)
        restore()
        assert came == [signal.SIGINT]
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, mask)
        signal.signal(signal.SIGINT, former)
