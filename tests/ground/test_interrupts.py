"""When a second signal counts, and that signals come though the parent blocked them."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import pyros1
from pyros1.ground.interrupts import MIN_REPEAT_INTERVAL, InterruptCounter, install_handler


def test_what_a_person_can_have_meant_counts() -> None:
    times = iter(
        [
            100.0,
            100.001,
            100.0 + 0.9 * MIN_REPEAT_INTERVAL,
            100.0 + MIN_REPEAT_INTERVAL,
            100.1 + MIN_REPEAT_INTERVAL,
            200.0,
        ]
    )
    interrupts = InterruptCounter(lambda: next(times))
    assert [interrupts.count_signal() for _ in range(6)] == [True, False, False, True, False, True]
    assert interrupts.count == 3


def test_a_key_held_down_counts_twice_a_second() -> None:
    times = iter([100.0 + step / 30 for step in range(31)])
    interrupts = InterruptCounter(lambda: next(times))
    assert sum(interrupts.count_signal() for _ in range(31)) == 1 + round(1.0 / MIN_REPEAT_INTERVAL)


def test_blocked_and_ignored_signals_come() -> None:
    """As fish and sh start what runs in the background."""
    former = signal.signal(signal.SIGINT, signal.SIG_IGN)
    mask = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        came: list[int] = []
        restore = install_handler(lambda number, frame: came.append(number))
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

signal.signal(signal.SIGINT, signal.SIG_DFL)
with interrupts.raise_keyboard_interrupts():
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
