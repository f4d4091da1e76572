"""What a client has begun."""

from __future__ import annotations

import asyncio

from pyros1.web.pending import Pending
from pyros1.web.waiting import wait_until_over


def test_it_is_over_when_all_is_done() -> None:
    woken: list[bool] = []
    pending = Pending(lambda: woken.append(bool(pending)))
    assert not pending
    one, two = pending.begin(), pending.begin()
    two()
    assert pending and not woken
    one()
    assert not pending and woken == [False]
    one()  # again does no harm


def test_what_was_given_up_is_waited_for_no_longer() -> None:
    pending = Pending(lambda: None)
    late = pending.begin()
    pending.give_up()
    assert not pending
    pending.begin()
    late()
    assert pending


def test_waiting_for_the_end_has_an_end() -> None:
    async def main() -> None:
        event = asyncio.Event()
        pending = Pending(event.set)
        await wait_until_over(pending, event, 100)
        done = pending.begin()
        asyncio.get_running_loop().call_later(0.01, done)
        await wait_until_over(pending, event, 100)
        pending.begin()
        await wait_until_over(pending, event, 0.01)
        assert not pending

    asyncio.run(main())
