"""Lines written by a thread of their own: a loop must never wait for a terminal that is held, a full pipe or a disk."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import threading
from collections.abc import Callable
from time import monotonic
from typing import Any

MOST_WAITING = 1 << 20
"""Characters that wait at most; beyond that, lines are lost and counted."""
GATHER = 0.02
"""Seconds between two writes, so that a busy loop wakes the thread rarely."""
IDLE = 0.5
"""Seconds without lines after which the thread ends."""
_STEP = 0.05
_PIECE = 4096  # what a pipe takes whole when it says that there is room

Item = tuple[str, str]
"""What to write to, ``stdout`` or ``stderr`` (of no meaning in files), and the text with its line break."""
GiveUp = Callable[[], bool]


class Background:
    """Writes in a thread, which exists while there is something to write.

    Args:
        name: the thread's.
        put: ``put(items, give_up)`` writes some; it may wait, and looks at ``give_up()`` now and then.
    """

    def __init__(self, name: str, put: Callable[[list[Item], GiveUp], None]) -> None:
        self._name = name
        self._put = put
        self._items: list[Item] = []
        self._size = 0
        self._lost = 0
        self._changed = threading.Condition()  # held for a few instructions only, never while something is written
        self._thread: threading.Thread | None = None
        self._closing = threading.Event()
        self._deadline = 0.0

    def write(self, where: str, text: str) -> None:
        """Write a text soon, after what was given before. Any thread; never waits."""
        with self._changed:
            if self._size + len(text) > MOST_WAITING:
                self._lost += 1
                return
            self._items.append((where, text))
            self._size += len(text)
            if self._thread is not None:
                self._changed.notify()
                return
            thread = threading.Thread(target=self._run, name=self._name, daemon=True)
            try:
                thread.start()  # with the lock: who closes must not find a thread that cannot be joined yet
            except RuntimeError:
                return  # no more threads, or the interpreter ends: `close` writes it
            self._thread = thread

    def close(self, timeout: float = 1.0) -> None:
        """Write what is left, for at most ``timeout`` seconds. What comes later is tried once."""
        with self._changed:
            self._deadline = monotonic() + timeout
            self._closing.set()
            self._changed.notify()
            thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(timeout + 2 * _STEP)
        with self._changed:
            left = self._take() if self._thread is None else []
        if left:
            self._put(left, self._given_up)

    def _given_up(self) -> bool:
        return self._closing.is_set() and monotonic() > self._deadline

    def _take(self) -> list[Item]:
        items, self._items, self._size = self._items, [], 0
        if self._lost and items:
            items.append((items[-1][0], f"... {self._lost} lines were lost here: they were not taken in time\n"))
            self._lost = 0
        return items

    def _run(self) -> None:
        while True:
            with self._changed:
                if not self._items and not self._closing.is_set():
                    self._changed.wait(IDLE)
                items = self._take()
                if not items:
                    self._thread = None
                    return
            with contextlib.suppress(Exception):  # there is no place left to say it
                self._put(items, self._given_up)
            self._closing.wait(GATHER)


def write_to_terminal(items: list[Item], give_up: GiveUp) -> None:
    """Write to this process's stdout and stderr; trouble with them is nobody's business."""
    for where, text in items:
        stream = getattr(sys, where, None)
        stream = getattr(stream, "under", stream)  # a command's, see cli/clean_output.py; log lines are clean
        if stream is None:
            continue
        try:
            if stream is getattr(sys, f"__{where}__") and hasattr(select, "poll"):
                _write_directly(stream, text, give_up)
            else:
                stream.write(text)
                stream.flush()
        except (OSError, ValueError, AttributeError):
            pass


def _write_directly(stream: Any, text: str, give_up: GiveUp) -> None:
    """Write to the descriptor: who waits inside of Python's stream would keep its lock at the program's end."""
    descriptor = stream.fileno()
    rest = text.encode(stream.encoding, stream.errors)
    poll = select.poll()
    poll.register(descriptor, select.POLLOUT)
    while rest:
        if poll.poll(_STEP * 1e3):
            rest = rest[os.write(descriptor, rest[:_PIECE]) :]
        elif give_up():
            return
