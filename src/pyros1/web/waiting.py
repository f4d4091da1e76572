"""Waiting on the server's loop."""

from __future__ import annotations

import asyncio
from time import monotonic

from pyros1.web.pending import Pending


async def wait_for_event(event: asyncio.Event, seconds: float | None) -> None:
    """Wait until an event is set, or so many seconds; None for no limit.

    Before Python 3.12, `asyncio.wait_for` may swallow a cancellation that comes together with the event, and a loop
    around it then never ends (https://github.com/python/cpython/issues/86296).
    """
    waiting = asyncio.ensure_future(event.wait())
    try:
        await asyncio.wait({waiting}, timeout=seconds)
    finally:
        waiting.cancel()


async def wait_until_over(pending: Pending, woken: asyncio.Event, seconds: float) -> None:
    """Wait until nothing is pending, or so many seconds; then give up what is.

    Args:
        pending: what is under way.
        woken: set when it is over.
        seconds: most that this takes.
    """
    until = monotonic() + seconds
    while True:
        woken.clear()
        left = until - monotonic()
        if not pending or left <= 0:
            break
        await wait_for_event(woken, left)
    pending.give_up()
