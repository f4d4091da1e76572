"""Waits, with a timeout, in the server's event loop: for an event, or until a client's pending operations are done."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from time import monotonic

MAX_PENDING_SECONDS = 3.0
"""Maximum number of seconds that an operation waits until the client's earlier subscriptions are established. Without a
limit, it would wait as long as the master is unreachable.
"""


class PendingOperations:
    """Operations in progress, such as subscriptions that are not registered yet.

    Args:
        wake: called, from any thread, when no operation is in progress any more.
    """

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._lock = threading.Lock()
        self._tokens: set[object] = set()  # one per operation in progress

    def __bool__(self) -> bool:
        """Return whether an operation is in progress."""
        return bool(self._tokens)

    def begin(self) -> Callable[[], None]:
        """Record that an operation has begun; return a function that must be called when the operation is done."""
        token = object()
        with self._lock:
            self._tokens.add(token)

        def done() -> None:
            with self._lock:
                self._tokens.discard(token)
                is_done = not self._tokens
            if is_done:
                self._wake()

        return done

    def abandon(self) -> None:
        """Forget the operations that are in progress."""
        with self._lock:
            self._tokens.clear()


async def wait_for_event(event: asyncio.Event, seconds: float | None) -> None:
    """Wait until an event is set, but at most for a number of seconds. If ``seconds`` is None, there is no limit.

    Before Python 3.12, `asyncio.wait_for` may swallow a cancellation that arrives together with the event, so that a
    loop around it never ends (https://github.com/python/cpython/issues/86296).
    """
    event_task = asyncio.ensure_future(event.wait())
    try:
        await asyncio.wait({event_task}, timeout=seconds)
    finally:
        event_task.cancel()


async def wait_until_done(pending: PendingOperations, wake_event: asyncio.Event, seconds: float) -> None:
    """Wait until no operation is pending. Operations still pending after a number of seconds are abandoned.

    Args:
        pending: the operations in progress.
        wake_event: the event that is set when the operations are done.
        seconds: maximum number of seconds to wait.
    """
    deadline = monotonic() + seconds
    while True:
        wake_event.clear()
        remaining = deadline - monotonic()
        if not pending or remaining <= 0:
            break
        await wait_for_event(wake_event, remaining)
    pending.abandon()
