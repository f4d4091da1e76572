"""telling: the program's functions are called in order, away from the caller, and never held up for good."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from pyros1.ground.errors import NodeShutdownError
from pyros1.node.callback_queue import CallbackQueue
from pyros1.node.watching.notifiers import MAX_PENDING, Notifier


class Log:
    def __init__(self) -> None:
        self.texts: list[str] = []

    def exception(self, text: object, *args: object, error: BaseException | None = None) -> None:
        self.texts.append(f"{text}: {error}")


def test_in_order_and_after_one_that_raises() -> None:
    log, told, done = Log(), [], threading.Event()
    notifier = Notifier("tests", log)

    def notify(number: int) -> None:
        told.append((number, threading.current_thread().name))
        if number == 3:
            raise ValueError("three")
        if number == 9:
            done.set()

    for number in range(10):
        notifier.notify(notify, number)
    assert done.wait(10)
    assert told == [(number, "tests") for number in range(10)]
    assert len(log.texts) == 1 and "bad function for tests" in log.texts[0] and log.texts[0].endswith("three")


def test_what_waits_is_bounded_and_can_be_forgotten() -> None:
    begun, go_on, done = threading.Event(), threading.Event(), threading.Event()
    told: list[Any] = []
    notifier = Notifier("tests", Log())
    notifier.notify(lambda: (begun.set(), go_on.wait(10)))
    assert begun.wait(10)
    for number in range(MAX_PENDING + 5):
        notifier.notify(told.append, number)
    go_on.set()
    notifier.notify(done.set)
    assert done.wait(10)
    assert told == list(range(6, MAX_PENDING + 5)), "the oldest are dropped"
    begun.clear(), go_on.clear()
    notifier.notify(lambda: (begun.set(), go_on.wait(10)))
    assert begun.wait(10)
    notifier.notify(told.append, "never")
    go_on.set()
    notifier.close(10)
    notifier.notify(told.append, "never")
    assert "never" not in told


@pytest.mark.parametrize(
    ("error", "logged"),
    [
        (NodeShutdownError("ending"), None),
        (SystemExit(1), "tests: sys.exit() ends a program only from its main thread; call node.shutdown()"),
        (KeyboardInterrupt(), "bad function for tests"),
        (ValueError("bad"), "bad function for tests"),
    ],
    ids=repr,
)
@pytest.mark.parametrize("spins", [False, True])
def test_what_functions_raise(error: BaseException, logged: str | None, spins: bool) -> None:
    """In a node that spins, what ends a program is raised in the program's own thread."""
    log, done = Log(), threading.Event()
    queue = CallbackQueue() if spins else None
    notifier = Notifier("tests", log, queue)

    def fail() -> None:
        raise error

    notifier.notify(fail)
    notifier.notify(done.set)
    if queue is not None:
        if isinstance(error, (SystemExit, KeyboardInterrupt)):
            with pytest.raises(type(error)):
                queue.run_available()
            logged = None
        queue.run_available()
    assert done.wait(10)
    assert [logged in text for text in log.texts] == ([] if logged is None else [True])  # type: ignore[operator]
