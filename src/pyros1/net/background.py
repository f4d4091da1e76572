"""Writes lines in a separate thread: a loop must never wait for a terminal that is held, a full pipe or a disk."""

from __future__ import annotations

import contextlib
import os
import select
import sys
import threading
from collections import deque
from collections.abc import Callable
from time import monotonic
from typing import Any

from pyros1.net.bell import Bell, Event

MOST_WAITING = 1 << 20
"""Most characters that may wait; further lines are dropped and counted."""
GATHER = 0.02
"""Seconds between two writes, so that a busy loop rarely wakes the thread."""
IDLE = 0.5
"""Seconds without lines after which the thread ends."""
PATIENCE = 0.1
"""Seconds that `flush` waits for the lines to be written."""
_STEP = 0.05
_PIECE = 4096  # what a pipe that is ready takes as a whole

Item = tuple[str, str]
"""(``stdout`` or ``stderr``, text with its line break); a file ignores the first."""
GiveUp = Callable[[], bool]


class Background:
    """Writer in a thread that exists while there is something to write. Takes no locks, so signal handlers may use it.

    Args:
        name: the thread's name.
        put: ``put(items, give_up)`` writes items; it may wait, and returns when ``give_up()`` is true.
    """

    def __init__(self, name: str, put: Callable[[list[Item], GiveUp], None]) -> None:
        self._name = name
        self._put = put
        self._items: deque[Item] = deque()
        self._size = 0  # approximate: several threads count, and each write starts again from 0
        self._lost = 0
        self._flushes: deque[Event] = deque()  # events to set when everything before them is written
        self._late = False  # a flush was too short, and its lines are still not written
        self._free = [True]  # holds an item while there is no thread, see node/lane.py
        self._thread: threading.Thread | None = None  # the last one
        self._more = Bell()
        self._hurry = Bell()
        self._ended = Bell()
        self._closing = Event()
        self._deadline = 0.0

    def write(self, where: str, text: str) -> None:
        """Write a text soon, after all earlier ones. Never waits; may be called from any thread."""
        if self._size + len(text) > MOST_WAITING:
            self._lost += 1
            return
        self._size += len(text)
        self._items.append((where, text))
        self._begin()

    def flush(self, timeout: float = PATIENCE) -> None:
        """Wait a moment until all texts are written; not at all while the output has been stuck since the last wait.

        Args:
            timeout: most seconds to wait.
        """
        if self._late or not (self._items or not self._free):
            return
        done = Event()
        self._flushes.append(done)
        self._begin()
        self._hurry.ring()
        if not done.wait(timeout):
            self._late = True

    def _begin(self) -> None:
        """Make sure that a thread runs that writes what waits."""
        try:
            del self._free[0]
        except IndexError:
            self._more.ring()
            return
        thread: threading.Thread | None = None
        try:
            self._thread = thread = threading.Thread(target=self._run, name=self._name, daemon=True)
            thread.start()
        except RuntimeError:  # no thread can be started: `close` writes the rest
            self._thread = None
            self._free.append(True)
        except BaseException:  # of a signal handler
            if thread is None or thread.ident is None:
                self._thread = None
                self._free.append(True)
            raise

    def close(self, timeout: float = 1.0) -> None:
        """Write what is left, for at most ``timeout`` seconds. Later texts are tried once."""
        self._deadline = monotonic() + timeout
        self._closing.set()
        self._more.ring()
        self._hurry.ring()
        thread = self._thread
        if thread is not threading.current_thread():
            self._wait_for_end(timeout + 2 * _STEP)
            if thread is not None and self._free:
                thread.join(_STEP)  # it has nothing left to do
        left = self._take() if self._free else []
        if left:
            self._put(left, self._given_up)

    def _wait_for_end(self, timeout: float) -> None:
        until = monotonic() + timeout
        while not self._free and (left := until - monotonic()) > 0:
            self._ended.wait(lambda: self._free, left)

    def _given_up(self) -> bool:
        return self._closing.is_set() and monotonic() > self._deadline

    def _take(self) -> list[Item]:
        items: list[Item] = []
        with contextlib.suppress(IndexError):
            while True:
                items.append(self._items.popleft())
        self._size = 0
        if self._lost and items:
            items.append((items[-1][0], f"... {self._lost} lines were lost here: the output was too slow\n"))
            self._lost = 0
        return items

    def _run(self) -> None:
        if self._thread is not threading.current_thread():
            return  # the caller that started it was interrupted by a signal handler that raised
        while True:
            if not self._items and not self._closing.is_set():
                self._more.wait(lambda: self._items or self._flushes or self._closing.is_set(), IDLE)
            flushes = [
                self._flushes.popleft() for _ in range(len(self._flushes))
            ]  # before the texts that they refer to
            items = self._take()
            if items:
                with contextlib.suppress(Exception):  # nowhere left to report it
                    self._put(items, self._given_up)
                self._late = False
            for done in flushes:
                done.set()
            if items:
                self._hurry.wait(lambda: self._flushes or self._closing.is_set(), GATHER)
            elif not flushes and self._end():
                return

    def _end(self) -> bool:
        """End the thread's turn; return False if new texts have come meanwhile and no other thread took them."""
        self._free.append(True)
        if self._items or self._flushes:
            try:
                del self._free[0]
            except IndexError:
                return True  # another thread was started for it
            return False
        self._ended.ring()
        return True


def write_to_terminal(items: list[Item], give_up: GiveUp) -> None:
    """Write to this process's stdout and stderr; errors of these are ignored."""
    for where, text in items:
        stream = getattr(sys, where, None)
        stream = getattr(
            stream, "under", stream
        )  # a command's own stream, see cli/clean_output.py; log lines are clean
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
    """Write to the descriptor: a thread that waits inside Python's stream would keep its lock at the program's end."""
    descriptor = stream.fileno()
    rest = text.encode(stream.encoding, stream.errors)
    poll = select.poll()
    poll.register(descriptor, select.POLLOUT)
    while rest:
        if poll.poll(_STEP * 1e3):
            rest = rest[os.write(descriptor, rest[:_PIECE]) :]
        elif give_up():
            return
