"""Calls of the program's functions with news, where the node's callbacks run: never on the loop."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from pyros1.ground.errors import NodeShutdownError

if TYPE_CHECKING:
    from pyros1.node.callback_queue import CallbackQueue


MOST_WAITING = 100
"""Most news that wait for one function."""


class Log(Protocol):
    """The part of a log that is needed here."""

    def exception(self, text: object, *args: object, error: BaseException | None = None) -> None: ...


class Teller:
    """Calls functions one after the other, in the thread that spins, or else in a thread that exists while there is
    something to tell.

    Args:
        what: the news, for the thread's name and the log.
        log: for functions that raise.
        callbacks: the callback queue of a node that spins; None for a thread.
        most: most calls that wait; beyond that the oldest are dropped. None for no limit.
    """

    def __init__(
        self, what: str, log: Log, callbacks: CallbackQueue | None = None, most: int | None = MOST_WAITING
    ) -> None:
        self._what = what
        self._log = log
        self._callbacks = callbacks
        self._most = most
        self._jobs: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque(maxlen=most)
        self._queued: deque[None] = deque()  # one for each call that waits in the callback queue
        self._lock = threading.Lock()
        self._busy = False
        self._closed = False
        self._thread: threading.Thread | None = None

    def tell(self, function: Callable[..., object], *news: Any) -> None:
        """Call ``function(*news)`` soon. Any thread, but no signal handler."""
        if self._closed:
            return
        self._jobs.append((function, news))
        if self._callbacks is not None:
            if self._most is None or len(self._queued) < self._most:  # else there are no more jobs than queued calls
                self._queued.append(None)
                self._callbacks.push(self._tell_from_queue)
            return
        with self._lock:
            if self._busy:
                return
            self._busy = True
        self._thread = threading.Thread(target=self._run, name=self._what, daemon=True)
        self._thread.start()

    def close(self, timeout: float = 0.0) -> None:
        """Make no further calls; wait at most ``timeout`` seconds for one that is running, unless it calls this."""
        self._closed = True
        self._jobs.clear()
        thread = self._thread
        if thread is not None and thread is not threading.current_thread() and timeout > 0:
            thread.join(timeout)

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._jobs:
                    self._busy = False
                    return
            self._tell_next()

    def _tell_from_queue(self) -> None:
        self._queued.popleft()
        self._tell_next()

    def _tell_next(self) -> None:
        try:
            function, news = self._jobs.popleft()
        except IndexError:  # it was dropped
            return
        try:
            function(*news)
        except NodeShutdownError:
            pass  # it waited for something when the node began to shut down
        except SystemExit as error:
            if self._callbacks is not None:
                raise  # it runs in the program's own thread
            text = f"{self._what}: sys.exit() ends a program only from its main thread; call node.shutdown()"
            self._log.exception(text, error=error)
        except BaseException as error:  # the program's code: later news are still told
            if self._callbacks is not None and not isinstance(error, Exception):
                raise
            self._log.exception(f"bad function for {self._what}: {function!r}", error=error)


class Tellers:
    """The tellers of a node.

    Args:
        log, callbacks: as for each `Teller`.
    """

    def __init__(self, log: Log, callbacks: CallbackQueue | None) -> None:
        self._log = log
        self._callbacks = callbacks
        self._tellers: dict[Teller, None] = {}

    def make(self, what: str) -> Teller:
        """Return a new one."""
        teller = Teller(what, self._log, self._callbacks)
        self._tellers[teller] = None
        return teller

    def end(self, teller: Teller) -> None:
        """Make no more of its calls."""
        teller.close()
        self._tellers.pop(teller, None)

    def close(self, timeout: float) -> None:
        """Make no more calls; wait at most ``timeout`` seconds for those that are running."""
        until = time.monotonic() + timeout
        tellers = list(self._tellers)
        for teller in tellers:
            teller.close()
        for teller in tellers:
            teller.close(max(0.0, until - time.monotonic()))
