"""Waiting on the server's loop, and for what a client has begun."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from time import monotonic

MAX_PENDING_SECONDS = 3.0
"""Seconds for which a client's next operation waits for its subscriptions: the master may be away."""


class Pending:
    """Things that are under way, such as subscriptions that the master does not know yet.

    Args:
        wake: called, from any thread, when nothing is under way any more.
    """

    def __init__(self, wake: Callable[[], object]) -> None:
        self._wake = wake
        self._lock = threading.Lock()
        self._pending: set[object] = set()

    def __bool__(self) -> bool:
        """Whether something is under way."""
        return bool(self._pending)

    def begin(self) -> Callable[[], None]:
        """Note that something is under way; return what is to be called when it is done."""
        token = object()
        with self._lock:
            self._pending.add(token)

        def done() -> None:
            with self._lock:
                self._pending.discard(token)
                is_done = not self._pending
            if is_done:
                self._wake()

        return done

    def abandon(self) -> None:
        """Wait no longer for what is under way now."""
        with self._lock:
            self._pending.clear()


async def wait_for_event(event: asyncio.Event, seconds: float | None) -> None:
    """Wait until an event is set, or so many seconds; None for no limit.

    Before Python 3.12, `asyncio.wait_for` may swallow a cancellation that comes together with the event, and a loop
    around it then never ends (https://github.com/python/cpython/issues/86296).
    """
    event_task = asyncio.ensure_future(event.wait())
    try:
        await asyncio.wait({event_task}, timeout=seconds)
    finally:
        event_task.cancel()


async def wait_until_done(pending: Pending, woken: asyncio.Event, seconds: float) -> None:
    """Wait until nothing is pending, or so many seconds; then give up what is.

    Args:
        pending: what is under way.
        woken: set when it is over.
        seconds: most that this takes.
    """
    deadline = monotonic() + seconds
    while True:
        woken.clear()
        remaining = deadline - monotonic()
        if not pending or remaining <= 0:
            break
        await wait_for_event(woken, remaining)
    pending.abandon()
