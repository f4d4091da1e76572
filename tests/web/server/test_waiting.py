"""Waiting on the server's loop."""

from __future__ import annotations

import asyncio

from pyros1.web.server.waiting import PendingOperations, wait_for_event, wait_until_done


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


def test_it_is_over_when_all_is_done() -> None:
    woken: list[bool] = []
    pending = PendingOperations(lambda: woken.append(bool(pending)))
    assert not pending
    one, two = pending.begin(), pending.begin()
    two()
    assert pending and not woken
    one()
    assert not pending and woken == [False]
    one()  # again does no harm


def test_what_was_given_up_is_waited_for_no_longer() -> None:
    pending = PendingOperations(lambda: None)
    late = pending.begin()
    pending.abandon()
    assert not pending
    pending.begin()
    late()
    assert pending


def test_waiting_for_the_end_has_an_end() -> None:
    async def main() -> None:
        event = asyncio.Event()
        pending = PendingOperations(event.set)
        await wait_until_done(pending, event, 100)
        done = pending.begin()
        asyncio.get_running_loop().call_later(0.01, done)
        await wait_until_done(pending, event, 100)
        pending.begin()
        await wait_until_done(pending, event, 0.01)
        assert not pending

    asyncio.run(main())
