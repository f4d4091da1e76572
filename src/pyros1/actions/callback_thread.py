"""Runs callbacks in a separate thread, which exists only while there are callbacks or checks to run."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from pyros1.net.signal_safe import Condition
from pyros1.node.log.logger import Log

_IDLE_TIMEOUT = 0.5
"""Seconds for which the idle thread waits for another callback before it calls the check, or exits."""


class CallbackThread:
    """Runs callbacks one after the other; a callback may wait for messages, which other threads receive.

    Args:
        name: the thread's name.
        log: the log for exceptions raised by callbacks.
        check: after a call of `keep_checking`, this is called every half second while no callback is queued, until it
            returns False.
    """

    def __init__(self, name: str, log: Log, check: Callable[[], bool] = lambda: False) -> None:
        self._name = name
        self._log = log
        self._check = check
        self._check_requested = False
        self._queue: deque[Callable[[], object]] = deque()
        self._lock = threading.RLock()
        self._callback_added = Condition()
        self._thread: threading.Thread | None = None

    def add(self, callback: Callable[[], object]) -> None:
        """Queue a callback."""
        with self._lock:
            self._queue.append(callback)
            self._start()
        self._callback_added.notify_all()

    def keep_checking(self) -> None:
        """Start calling ``check`` regularly, until it returns False."""
        with self._lock:
            self._check_requested = True
            self._start()

    def _start(self) -> None:
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name=self._name, daemon=True)
            self._thread.start()

    def _run(self) -> None:
        check_again = False
        while True:
            self._callback_added.wait_for(lambda: self._queue, _IDLE_TIMEOUT)
            if not self._queue:
                self._check_requested = False  # before the check: a request during the check causes another one
                check_again = self._check()
            with self._lock:
                if not self._queue:
                    if check_again or self._check_requested:
                        continue
                    self._thread = None
                    return
                callback = self._queue.popleft()
            try:
                callback()
            except Exception as error:  # noqa: BLE001 - callbacks may raise anything
                self._log.exception("error in a callback (%s)", self._name, error=error)
