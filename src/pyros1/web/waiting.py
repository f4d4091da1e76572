"""Waiting on the server's loop."""

from __future__ import annotations

import asyncio


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
