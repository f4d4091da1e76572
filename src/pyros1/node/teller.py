"""Calls functions of the program that tell it something, away from the loop, on which no code of a program runs."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import Any, Final, Protocol

MOST_WAITING: Final = 1000
"""Most calls that wait while a function does not return; the oldest are dropped."""


class _Log(Protocol):
    def exception(self, text: object, *args: object, error: BaseException | None = None) -> None: ...


class Teller:
    """Makes calls one after the other, in a thread that exists while there is something to tell.

    Args:
        name: of the thread.
        what: what the functions are for, for the log if one raises.
        log: for functions that raise.
    """

    def __init__(self, name: str, what: str, log: _Log) -> None:
        self._name = name
        self._what = what
        self._log = log
        self._jobs: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque(maxlen=MOST_WAITING)
        self._lock = threading.Lock()
        self._busy = False

    def tell(self, function: Callable[..., object], *args: Any) -> None:
        """Call ``function(*args)`` soon. Never waits for it."""
        with self._lock:
            self._jobs.append((function, args))
            if self._busy:
                return
            self._busy = True
        threading.Thread(target=self._run, name=self._name, daemon=True).start()

    def clear(self) -> None:
        """Forget the calls that wait."""
        self._jobs.clear()

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._jobs:
                    self._busy = False
                    return
                function, args = self._jobs.popleft()
            try:
                function(*args)
            except Exception as error:  # noqa: BLE001 - the program's code: others are still told
                self._log.exception(f"bad function for {self._what}: {function!r}", error=error)
