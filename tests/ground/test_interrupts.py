"""When a second signal counts, and that signals come though the parent blocked them."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pyros1
from pyros1.ground.interrupts import DELIBERATE, Insistence, catch


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


LOST = """
import signal, sys, time
sys.path.insert(0, sys.argv[1])
from pyros1.ground import interrupts

class Last:
    def __del__(self):
        signal.raise_signal(signal.SIGINT)

interrupts.die_quietly()
with interrupts.raised():
    last = Last()
    try:
        del last
        time.sleep(20)
    except KeyboardInterrupt:
        print("raised")
"""


def test_one_that_the_interpreter_cannot_raise_is_raised_soon_after() -> None:
    source = Path(pyros1.__file__).parent.parent
    done = subprocess.run([sys.executable, "-c", LOST, source], capture_output=True, text=True, timeout=30, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "raised\n", "")
