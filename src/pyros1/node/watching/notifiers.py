"""Notifies the program by calling its functions where the node's callbacks run, never on the loop."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Protocol

from pyros1.ground.errors import NodeShutdownError

if TYPE_CHECKING:
    from pyros1.node.callback_queue import CallbackQueue


MAX_PENDING = 100
"""Maximum number of pending calls of one notifier."""


class Log(Protocol):
    """The part of a log's interface that this module uses."""

    def exception(self, text: object, *args: object, error: BaseException | None = None) -> None: ...


class Notifier:
    """Calls functions one at a time, in the thread that spins, or else in a thread that runs while calls are pending.

    Args:
        subject: the subject of the notifications, for the thread's name and the log.
        log: logs exceptions raised by the functions.
        callback_queue: the callback queue of a node that spins; None to use a thread.
        max_pending: maximum number of pending calls; beyond that, the oldest are dropped. None for no limit.
    """

    def __init__(
        self, subject: str, log: Log, callback_queue: CallbackQueue | None = None, max_pending: int | None = MAX_PENDING
    ) -> None:
        self._subject = subject
        self._log = log
        self._callback_queue = callback_queue
        self._max_pending = max_pending
        self._jobs: deque[tuple[Callable[..., object], tuple[Any, ...]]] = deque(maxlen=max_pending)
        self._queued_calls: deque[None] = deque()  # one for each call that waits in the callback queue
        self._lock = threading.Lock()
        self._is_running = False
        self._closed = False
        self._thread: threading.Thread | None = None

    def notify(self, function: Callable[..., object], *args: Any) -> None:
        """Call ``function(*args)`` soon. Thread-safe, but not allowed in signal handlers."""
        if self._closed:
            return
        self._jobs.append((function, args))
        if self._callback_queue is not None:
            # At the limit, the oldest job was dropped, so there are enough queued calls.
            if self._max_pending is None or len(self._queued_calls) < self._max_pending:
                self._queued_calls.append(None)
                self._callback_queue.push(self._notify_from_queue)
            return
        with self._lock:
            if self._is_running:
                return
            self._is_running = True
        self._thread = threading.Thread(target=self._run, name=self._subject, daemon=True)
        self._thread.start()

    def close(self, timeout: float = 0.0) -> None:
        """Make no more calls; wait at most ``timeout`` seconds for a running call, unless that call is the caller."""
        self._closed = True
        self._jobs.clear()
        thread = self._thread
        if thread is not None and thread is not threading.current_thread() and timeout > 0:
            thread.join(timeout)

    def _run(self) -> None:
        while True:
            with self._lock:
                if not self._jobs:
                    self._is_running = False
                    return
            self._notify_next()

    def _notify_from_queue(self) -> None:
        self._queued_calls.popleft()
        self._notify_next()

    def _notify_next(self) -> None:
        try:
            function, args = self._jobs.popleft()
        except IndexError:  # the job was dropped
            return
        try:
            function(*args)
        except NodeShutdownError:
            pass  # the function was waiting when the node started to shut down
        except SystemExit as error:
            if self._callback_queue is not None:
                raise  # the function runs in the program's own thread
            text = f"{self._subject}: sys.exit() ends a program only from its main thread; call node.shutdown()"
            self._log.exception(text, error=error)
        except BaseException as error:  # raised by user code: later notifications must still be made
            if self._callback_queue is not None and not isinstance(error, Exception):
                raise
            self._log.exception(f"bad function for {self._subject}: {function!r}", error=error)


class Notifiers:
    """A node's notifiers.

    Args:
        log, callback_queue: passed to each `Notifier`.
    """

    def __init__(self, log: Log, callback_queue: CallbackQueue | None) -> None:
        self._log = log
        self._callback_queue = callback_queue
        self._notifiers: dict[Notifier, None] = {}

    def make(self, subject: str) -> Notifier:
        """Create and return a notifier for a subject, which is stopped by `end` or `close`; see `Notifier`."""
        notifier = Notifier(subject, self._log, self._callback_queue)
        self._notifiers[notifier] = None
        return notifier

    def end(self, notifier: Notifier) -> None:
        """Stop and forget a notifier; pending calls are not made."""
        notifier.close()
        self._notifiers.pop(notifier, None)

    def close(self, timeout: float) -> None:
        """Make no more calls; wait at most ``timeout`` seconds for running ones."""
        deadline = time.monotonic() + timeout
        notifiers = list(self._notifiers)
        for notifier in notifiers:
            notifier.close()
        for notifier in notifiers:
            notifier.close(max(0.0, deadline - time.monotonic()))
