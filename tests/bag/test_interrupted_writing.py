"""Bags whose writing is interrupted by signals: Ctrl-C, and handlers that write and close bags themselves."""

from __future__ import annotations

import gc
import random
import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

import pyros1.bag
from pyros1.msgs.std_msgs.msg import String

pytestmark = pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="no timers that send signals here")


class Interruption(BaseException):
    """As KeyboardInterrupt, which would end the tests if it came too late."""


@pytest.fixture
def soon() -> Iterator[Callable[[Callable[[], object]], None]]:
    """Return a function that lets another one be called soon, by a signal handler."""
    former = signal.getsignal(signal.SIGALRM)
    gc.disable()  # an exception that a handler raises within one of its callbacks is lost

    def arm(action: Callable[[], object]) -> None:
        signal.signal(signal.SIGALRM, lambda *_: action())
        signal.setitimer(signal.ITIMER_REAL, random.uniform(100e-6, 3e-3))

    yield arm
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, former)
    gc.enable()


def numbers(path: Path) -> list[int]:
    with pyros1.bag.open(path, unindexed=False) as bag:
        found = [int(item.message.data.rpartition(" ")[2]) for item in bag.messages()]
        assert len(bag) == len(found)
    return found


@pytest.mark.slow
@pytest.mark.parametrize("compression", ["none", "lz4"])
@pytest.mark.parametrize("size", [10, 5000])
def test_a_bag_is_whole_after_ctrl_c(tmp_path: Path, soon: Any, compression: str, size: int) -> None:
    rung = 0

    def interrupt() -> None:
        nonlocal rung
        rung += 1
        raise Interruption

    count = 0

    def write(bag: Any) -> None:
        """A function: in Python 3.13 the exception of a signal handler may pass by a ``try`` around a loop."""
        nonlocal count
        soon(interrupt)
        before = rung
        while rung == before:
            bag.write("t", String("x" * size + f" {count}"), float(count))
            count += 1
        raise AssertionError("the exception of the handler was lost")

    for run in range(60):
        path, count = tmp_path / f"{run}.bag", 0
        with pyros1.bag.open(path, "w", compression=compression, chunk_threshold=3 * size) as bag:
            with pytest.raises(Interruption):
                write(bag)
            written = len(bag)
            bag.write("t", String("after 1000000"), 1_000_000.0)
        found = numbers(path)
        assert found in ([*range(count), 1_000_000], [*range(count + 1), 1_000_000])
        assert written == len(found) - 1


def test_a_handler_closes_the_bag(tmp_path: Path, soon: Any) -> None:
    for run in range(60):
        path, count = tmp_path / f"{run}.bag", 0
        bag = pyros1.bag.open(path, "w", chunk_threshold=300)
        soon(bag.close)
        with pytest.raises(ValueError, match="closed"):
            while True:
                bag.write("t", String(f"x {count}"), float(count))
                count += 1
        assert numbers(path) == list(range(count))


@pytest.mark.slow
def test_a_handler_writes_into_the_bag(tmp_path: Path, soon: Any) -> None:
    path, count, more = tmp_path / "x.bag", 0, 200
    with pyros1.bag.open(path, "w", chunk_threshold=300) as bag:

        def write() -> None:
            nonlocal more
            more -= 1
            bag.write("u", String(f"y {more}"), 0.0)
            bag.flush()
            if more:
                soon(write)

        soon(write)
        while more:
            bag.write("t", String(f"x {count}"), float(count + 1))
            count += 1
    assert numbers(path) == [*reversed(range(200)), *range(count)]
