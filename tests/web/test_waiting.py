"""Waiting on the server's loop."""

from __future__ import annotations

import asyncio

from pyros1.web.waiting import wait_for_event


def test_the_event_or_the_time_ends_it() -> None:
    async def main() -> None:
        event = asyncio.Event()
        await wait_for_event(event, 0.001)
        event.set()
        await wait_for_event(event, None)

    asyncio.run(main())


def test_a_cancellation_counts_whenever_it_comes() -> None:
    async def loop(event: asyncio.Event, turns: list[int]) -> None:
        while True:
            event.clear()
            await wait_for_event(event, 100)
            turns.append(1)

    async def main() -> None:
        for steps in range(8):  # of the loop between the event and the cancellation
            event, turns = asyncio.Event(), list[int]()
            task = asyncio.create_task(loop(event, turns))
            for _ in range(5):
                await asyncio.sleep(0)
            event.set()
            for _ in range(steps):
                await asyncio.sleep(0)
            task.cancel()
            done, _ = await asyncio.wait({task}, timeout=10)
            assert task in done and task.cancelled()

    asyncio.run(main())
