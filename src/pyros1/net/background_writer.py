"""Writes lines in a separate thread, because a loop must never block on a paused terminal, a full pipe or a disk."""

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
"""Maximum number of queued characters; further lines are dropped and counted."""
WRITE_INTERVAL = 0.02
"""Seconds between two writes, so that a busy loop rarely wakes the thread."""
IDLE_TIMEOUT = 0.5
"""Seconds without lines after which the thread exits."""
FLUSH_TIMEOUT = 0.1
"""Maximum number of seconds that `flush` waits by default."""
_POLL_INTERVAL = 0.05
_MAX_WRITE = 4096  # a pipe that is ready accepts this much without blocking

Item = tuple[str, str]
"""(``stdout`` or ``stderr``, text including the line break); writers to a file ignore the stream's name."""
ShouldStop = Callable[[], bool]


class BackgroundWriter:
    """Writes in a thread that runs while there is something to write. Uses no locks, so signal handlers may call it.

    Args:
        name: the thread's name.
        write_items: ``write_items(items, should_stop)`` writes the items. It may block, but must return when
            ``should_stop()`` is true.
    """

    def __init__(self, name: str, write_items: Callable[[list[Item], ShouldStop], None]) -> None:
        self._name = name
        self._write_items = write_items
        self._items: deque[Item] = deque()
        self._size = 0  # approximate: several threads update it, and each write resets it to 0
        self._num_dropped_lines = 0
        self._flush_events: deque[Event] = deque()  # events to set as soon as all earlier items are written
        self._is_stuck = False  # whether a flush timed out, and its lines are still not written
        self._idle_token = [True]  # holds an item while no thread runs, see node/strand.py
        self._thread: threading.Thread | None = None  # the thread that was started last
        self._new_items = Condition()
        self._flush_requested = Condition()
        self._thread_finished = Condition()
        self._closing = Event()
        self._deadline = 0.0

    def write(self, stream_name: str, text: str) -> None:
        """Queue ``text`` to be written soon. Never blocks. Thread-safe."""
        if self._size + len(text) > MAX_PENDING:
            self._num_dropped_lines += 1
            return
        self._size += len(text)
        self._items.append((stream_name, text))
        self._ensure_thread()

    def flush(self, timeout: float = FLUSH_TIMEOUT) -> None:
        """Wait until all queued text is written; return immediately if the output has been stuck since the last flush.

        Args:
            timeout: maximum number of seconds to wait.
        """
        if self._is_stuck or not (self._items or not self._idle_token):
            return
        flushed = Event()
        self._flush_events.append(flushed)
        self._ensure_thread()
        self._flush_requested.notify_all()
        if not flushed.wait(timeout):
            self._is_stuck = True

    def _ensure_thread(self) -> None:
        """Wake the thread that writes the queued text, or start one."""
        try:
            del self._idle_token[0]
        except IndexError:
            self._new_items.notify_all()
            return
        thread: threading.Thread | None = None
        try:
            self._thread = thread = threading.Thread(target=self._run, name=self._name, daemon=True)
            thread.start()
        except RuntimeError:  # no thread can be started: `close` writes the remaining text
            self._thread = None
            self._idle_token.append(True)
        except BaseException:  # raised by a signal handler
            if thread is None or thread.ident is None:
                self._thread = None
                self._idle_token.append(True)
            raise

    def close(self, timeout: float = 1.0) -> None:
        """Write the remaining text, taking at most ``timeout`` seconds. Text that is queued later is only written if
        that is possible without waiting.
        """
        self._deadline = monotonic() + timeout
        self._closing.set()
        self._new_items.notify_all()
        self._flush_requested.notify_all()
        thread = self._thread
        if thread is not threading.current_thread():
            self._wait_for_end(timeout + 2 * _POLL_INTERVAL)
            if thread is not None and self._idle_token:
                thread.join(_POLL_INTERVAL)  # the thread is about to exit
        remaining = self._take_items() if self._idle_token else []
        if remaining:
            self._write_items(remaining, self._is_out_of_time)

    def _wait_for_end(self, timeout: float) -> None:
        deadline = monotonic() + timeout
        while not self._idle_token and (remaining := deadline - monotonic()) > 0:
            self._thread_finished.wait_for(lambda: self._idle_token, remaining)

    def _is_out_of_time(self) -> bool:
        return self._closing.is_set() and monotonic() > self._deadline

    def _take_items(self) -> list[Item]:
        items: list[Item] = []
        with contextlib.suppress(IndexError):
            while True:
                items.append(self._items.popleft())
        self._size = 0
        if self._num_dropped_lines and items:
            items.append(
                (items[-1][0], f"... {self._num_dropped_lines} lines were lost here: the output was too slow\n")
            )
            self._num_dropped_lines = 0
        return items

    def _run(self) -> None:
        if self._thread is not threading.current_thread():
            return  # a signal handler raised an exception while this thread was being started
        while True:
            if not self._items and not self._closing.is_set():
                self._new_items.wait_for(
                    lambda: self._items or self._flush_events or self._closing.is_set(), IDLE_TIMEOUT
                )
            # Taken before the items, so that all items that precede these flushes are among the items taken below.
            flush_events = [self._flush_events.popleft() for _ in range(len(self._flush_events))]
            items = self._take_items()
            if items:
                with contextlib.suppress(Exception):  # nowhere left to report it
                    self._write_items(items, self._is_out_of_time)
                self._is_stuck = False
            for flushed in flush_events:
                flushed.set()
            if items:
                self._flush_requested.wait_for(lambda: self._flush_events or self._closing.is_set(), WRITE_INTERVAL)
            elif not flush_events and self._finish_thread():
                return

    def _finish_thread(self) -> bool:
        """Prepare to end the thread; return False if it must continue, because more text has been queued meanwhile."""
        self._idle_token.append(True)
        if self._items or self._flush_events:
            try:
                del self._idle_token[0]
            except IndexError:
                return True  # another thread was started for this text
            return False
        self._thread_finished.notify_all()
        return True


def write_to_terminal(items: list[Item], should_stop: ShouldStop) -> None:
    """Write to this process's stdout and stderr, ignoring errors."""
    for stream_name, text in items:
        stream = getattr(sys, stream_name, None)
        # Use the stream below a command's filter (cli/clean_output.py): log lines need no filtering.
        stream = getattr(stream, "underlying", stream)
        if stream is None:
            continue
        try:
            if stream is getattr(sys, f"__{stream_name}__") and hasattr(select, "poll"):
                _write_directly(stream, text, should_stop)
            else:
                stream.write(text)
                stream.flush()
        except (OSError, ValueError, AttributeError):
            pass


def _write_directly(stream: Any, text: str, should_stop: ShouldStop) -> None:
    """Write to the descriptor: a thread blocked in Python's stream would hold that stream's lock at program exit."""
    descriptor = stream.fileno()
    remaining = text.encode(stream.encoding, stream.errors)
    poll = select.poll()
    poll.register(descriptor, select.POLLOUT)
    while remaining:
        if poll.poll(_POLL_INTERVAL * 1e3):
            remaining = remaining[os.write(descriptor, remaining[:_MAX_WRITE]) :]
        elif should_stop():
            return
