"""Callbacks in a separate thread, which exists while there is something to call or to check."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable

from pyros1.net.signal_safe import Condition
from pyros1.node.log.logger import Log

_IDLE_TIMEOUT = 0.5
"""Seconds for which the thread waits for more calls."""


class CallbackThread:
    """Calls functions one after the other; they may wait for messages that other threads receive meanwhile.

    Args:
        name: the thread's name.
        log: for exceptions of these functions.
        check: called each half second while there is nothing to call, from `keep_checking` on until it returns False.
    """

    def __init__(self, name: str, log: Log, check: Callable[[], bool] = lambda: False) -> None:
        self._name = name
        self._log = log
        self._check = check
        self._check_requested = False
        self._calls: deque[Callable[[], object]] = deque()
        self._lock = threading.RLock()
        self._condition = Condition()
        self._thread: threading.Thread | None = None

    def add(self, call: Callable[[], object]) -> None:
        """Call a function after all earlier ones."""
        with self._lock:
            self._calls.append(call)
            self._start()
        self._condition.notify_all()

    def keep_checking(self) -> None:
        """Keep checking until it is no longer needed."""
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
            self._condition.wait_for(lambda: self._calls, _IDLE_TIMEOUT)
            if not self._calls:
                self._check_requested = False  # before the check: a request after it causes another one
                check_again = self._check()
            with self._lock:
                if not self._calls:
                    if check_again or self._check_requested:
                        continue
                    self._thread = None
                    return
                call = self._calls.popleft()
            try:
                call()
            except Exception as error:  # noqa: BLE001 - the program's code
                self._log.exception("error in a callback (%s)", self._name, error=error)
