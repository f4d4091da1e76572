"""Writes lines in a separate thread: a loop must never wait for a paused terminal, a full pipe or a disk."""

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

from pyros1.net.signal_safe import Condition, Event

MAX_PENDING = 1 << 20
"""Maximum number of characters that may wait; further lines are dropped and counted."""
WRITE_INTERVAL = 0.02
"""Seconds between two writes, so that a busy loop rarely wakes the thread."""
IDLE_TIMEOUT = 0.5
"""Seconds without lines after which the thread ends."""
FLUSH_TIMEOUT = 0.1
"""Seconds that `flush` waits for the lines to be written."""
_POLL_INTERVAL = 0.05
_MAX_WRITE = 4096  # what a pipe that is ready takes as a whole

Item = tuple[str, str]
"""(``stdout`` or ``stderr``, text with its line break); a file ignores the first."""
ShouldStop = Callable[[], bool]


class BackgroundWriter:
    """Writer in a thread that exists while there is something to write. Takes no locks, so signal handlers may use it.

    Args:
        name: the thread's name.
        write_items: ``write_items(items, should_stop)`` writes items; it may wait, and returns when ``should_stop()``
            is true.
    """

    def __init__(self, name: str, write_items: Callable[[list[Item], ShouldStop], None]) -> None:
        self._name = name
        self._write_items = write_items
        self._items: deque[Item] = deque()
        self._size = 0  # approximate: several threads count, and each write starts again from 0
        self._lost_lines = 0
        self._flushes: deque[Event] = deque()  # events to set when everything before them is written
        self._is_stuck = False  # a flush was too short, and its lines are still not written
        self._free = [True]  # holds an item while there is no thread, see node/strand.py
        self._thread: threading.Thread | None = None  # the last one
        self._new_items = Condition()
        self._flush_requested = Condition()
        self._ended = Condition()
        self._closing = Event()
        self._deadline = 0.0

    def write(self, where: str, text: str) -> None:
        """Write a text soon, after all earlier ones. Never waits; may be called from any thread."""
        if self._size + len(text) > MAX_PENDING:
            self._lost_lines += 1
            return
        self._size += len(text)
        self._items.append((where, text))
        self._begin()

    def flush(self, timeout: float = FLUSH_TIMEOUT) -> None:
        """Wait a moment until all texts are written; not at all while the output has been stuck since the last wait.

        Args:
            timeout: maximum seconds to wait.
        """
        if self._is_stuck or not (self._items or not self._free):
            return
        done = Event()
        self._flushes.append(done)
        self._begin()
        self._flush_requested.notify_all()
        if not done.wait(timeout):
            self._is_stuck = True

    def _begin(self) -> None:
        """Make sure that a thread runs that writes the waiting texts."""
        try:
            del self._free[0]
        except IndexError:
            self._new_items.notify_all()
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
        """Write the remaining texts, for at most ``timeout`` seconds. Later texts are tried once."""
        self._deadline = monotonic() + timeout
        self._closing.set()
        self._new_items.notify_all()
        self._flush_requested.notify_all()
        thread = self._thread
        if thread is not threading.current_thread():
            self._wait_for_end(timeout + 2 * _POLL_INTERVAL)
            if thread is not None and self._free:
                thread.join(_POLL_INTERVAL)  # it has nothing left to do
        remaining = self._take() if self._free else []
        if remaining:
            self._write_items(remaining, self._is_out_of_time)

    def _wait_for_end(self, timeout: float) -> None:
        deadline = monotonic() + timeout
        while not self._free and (remaining := deadline - monotonic()) > 0:
            self._ended.wait_for(lambda: self._free, remaining)

    def _is_out_of_time(self) -> bool:
        return self._closing.is_set() and monotonic() > self._deadline

    def _take(self) -> list[Item]:
        items: list[Item] = []
        with contextlib.suppress(IndexError):
            while True:
                items.append(self._items.popleft())
        self._size = 0
        if self._lost_lines and items:
            items.append((items[-1][0], f"... {self._lost_lines} lines were lost here: the output was too slow\n"))
            self._lost_lines = 0
        return items

    def _run(self) -> None:
        if self._thread is not threading.current_thread():
            return  # the caller that started it was interrupted by a signal handler that raised
        while True:
            if not self._items and not self._closing.is_set():
                self._new_items.wait_for(lambda: self._items or self._flushes or self._closing.is_set(), IDLE_TIMEOUT)
            flushes = [
                self._flushes.popleft() for _ in range(len(self._flushes))
            ]  # before the texts that they refer to
            items = self._take()
            if items:
                with contextlib.suppress(Exception):  # nowhere left to report it
                    self._write_items(items, self._is_out_of_time)
                self._is_stuck = False
            for done in flushes:
                done.set()
            if items:
                self._flush_requested.wait_for(lambda: self._flushes or self._closing.is_set(), WRITE_INTERVAL)
            elif not flushes and self._end():
                return

    def _end(self) -> bool:
        """End the thread's turn; return False if new texts have arrived meanwhile and no other thread writes them."""
        self._free.append(True)
        if self._items or self._flushes:
            try:
                del self._free[0]
            except IndexError:
                return True  # another thread was started for it
            return False
        self._ended.notify_all()
        return True


def write_to_terminal(items: list[Item], should_stop: ShouldStop) -> None:
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
                _write_directly(stream, text, should_stop)
            else:
                stream.write(text)
                stream.flush()
        except (OSError, ValueError, AttributeError):
            pass


def _write_directly(stream: Any, text: str, should_stop: ShouldStop) -> None:
    """Write to the descriptor: a thread that waits inside Python's stream would keep its lock at the program's end."""
    descriptor = stream.fileno()
    rest = text.encode(stream.encoding, stream.errors)
    poll = select.poll()
    poll.register(descriptor, select.POLLOUT)
    while rest:
        if poll.poll(_POLL_INTERVAL * 1e3):
            rest = rest[os.write(descriptor, rest[:_MAX_WRITE]) :]
        elif should_stop():
            return
