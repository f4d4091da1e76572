"""Streams by themselves: what waits, what is dropped, who is held back."""

from __future__ import annotations

import asyncio
import gc
import random
import threading
import weakref
from collections.abc import Callable, Coroutine
from concurrent.futures import ThreadPoolExecutor
from time import perf_counter
from typing import Any

import pytest

from pyros1.aio.messages import MAX_PENDING, Messages


class Link:
    """A source of messages."""

    def __init__(self) -> None:
        self.header: dict[str, str] = {}
        self.connected = True


class Handle:
    """A subscriber's handle whose messages are what was put; 13 cannot be decoded."""

    def __init__(self) -> None:
        self.released = 0
        self.unregistered = 0

    def decode_for_stream(self, source: Any, item: Any) -> Any:
        return None if item == 13 else item

    def resume_publishers(self) -> None:
        self.released += 1

    def unregister(self) -> None:
        self.unregistered += 1


def run(work: Callable[[], Coroutine[Any, Any, None]]) -> None:
    asyncio.run(asyncio.wait_for(work(), 20))


def make(limit: int | None, urgent: bool = False) -> tuple[Any, Handle]:
    stream, handle = Messages[Any](asyncio.get_running_loop(), limit, urgent), Handle()
    stream.attach(handle)  # type: ignore[arg-type]
    return stream, handle


async def rest(stream: Any) -> list[Any]:
    stream.end()
    return [message async for message in stream]


def test_a_limit_keeps_the_newest_of_each_publisher_and_they_take_turns() -> None:
    async def work() -> None:
        stream, _ = make(2)
        one, other = Link(), Link()
        for number in range(5):
            stream.put(one, f"one {number}")
        stream.put(other, "other")
        assert (stream.waiting, stream.dropped, stream.full) == (3, 3, False)
        assert await rest(stream) == ["one 3", "other", "one 4"]

    run(work)


def test_without_a_limit_a_publisher_with_too_many_is_held_back_until_half_are_taken() -> None:
    async def work() -> None:
        stream, handle = make(None)
        one, other = Link(), Link()
        for number in range(MAX_PENDING - 1):
            stream.put(one, number + 100)
        assert not stream.full
        stream.put(other, 1)
        assert not stream.full
        stream.put(one, 2)
        assert stream.full
        released = handle.released
        while handle.released == released:
            assert await stream.__anext__() is not None
        assert stream.waiting == MAX_PENDING // 2 - 1
        assert not stream.full and not stream.dropped

    run(work)


def test_random_puts_and_takes_lose_nothing_and_never_leave_a_publisher_held_back() -> None:
    async def work() -> None:
        for seed in range(30):
            rng = random.Random(seed)
            stream, handle = make(None)
            links = [Link() for _ in range(3)]
            put: dict[Link, list[Any]] = {link: [] for link in links}
            got: list[Any] = []
            for step in range(2000):
                if rng.random() < rng.choice([0.3, 0.7]) and not stream.full:
                    link = rng.choice(links)
                    put[link].append((id(link), step))
                    stream.put(link, put[link][-1])
                    held, released = stream.full, handle.released
                elif stream.waiting:
                    got.append(await stream.__anext__())
                    if held and not stream.waiting:
                        assert handle.released > released
            got += await rest(stream)
            for link in links:
                assert [item for item in got if item[0] == id(link)] == put[link]

    run(work)


def test_what_cannot_be_decoded_is_passed_over() -> None:
    async def work() -> None:
        stream, _ = make(None)
        for item in (13, 1, 13, 13, 2, 13):
            stream.put(LINK, item)
        assert await rest(stream) == [1, 2]

    run(work)


LINK = Link()


def test_a_wait_is_urgent_until_it_has_its_message_or_ends() -> None:
    async def work() -> None:
        stream, _ = make(1, urgent=True)
        assert stream.urgent
        stream.put(LINK, 1)
        assert not stream.urgent
        assert await stream.__anext__() == 1
        assert stream.urgent
        stream.end()
        assert not stream.urgent

    run(work)


@pytest.mark.slow
def test_publishers_that_come_and_go_leave_nothing_behind() -> None:
    async def work() -> None:
        stream, _ = make(1)
        kept: weakref.WeakSet[Link] = weakref.WeakSet()
        for number in range(100):
            link = Link()
            kept.add(link)
            stream.put(link, number - 1)
            stream.put(link, number)
            link.connected = False
            if number != 13:
                assert await stream.__anext__() == number
        assert stream.dropped == 100
        gc.collect()
        assert len(kept) <= 3

    run(work)


@pytest.mark.parametrize("wait_first", [True, False])
def test_what_another_thread_puts_wakes_the_iteration(wait_first: bool) -> None:
    async def work() -> None:
        stream, _ = make(None)
        task = asyncio.ensure_future(stream.__anext__())
        if wait_first:
            await asyncio.sleep(0)
        await asyncio.to_thread(stream.put, LINK, 1)
        assert await task == 1

    run(work)


def test_an_end_from_another_thread_holds_nobody_back() -> None:
    async def work() -> None:
        stream, handle = make(None)
        for number in range(MAX_PENDING):
            stream.put(LINK, number)
        await asyncio.to_thread(stream.end)
        assert not stream.full and handle.released
        await stream.aclose()
        assert handle.unregistered
        assert len([1 async for _ in stream]) == MAX_PENDING - 1  # without 13

    run(work)


def test_who_no_longer_waits_for_the_handle_unsubscribes_all_the_same() -> None:
    async def work() -> None:
        early, handle = Messages[Any](asyncio.get_running_loop(), None), Handle()
        early.abandon()
        early.attach(handle)  # type: ignore[arg-type]
        assert handle.unregistered
        stream, handle = make(None)
        stream.abandon()
        while not handle.unregistered:
            await asyncio.sleep(0)

    run(work)


def test_a_cancelled_close_unsubscribes_all_the_same() -> None:
    async def work() -> None:
        asyncio.get_running_loop().set_default_executor(ThreadPoolExecutor(1))
        free = threading.Event()
        busy = asyncio.ensure_future(asyncio.to_thread(free.wait, 10))
        stream, handle = make(None)
        closing = asyncio.ensure_future(stream.aclose())
        await asyncio.sleep(0)  # it waits for the thread
        closing.cancel()
        await asyncio.wait([closing])
        free.set()
        assert await busy
        await asyncio.to_thread(int)  # what came before has been done
        assert closing.cancelled() and handle.unregistered

    run(work)


def test_thousands_of_publishers_cost_little_for_each() -> None:
    class Counted(Link):
        looks = 0

        @property
        def connected(self) -> bool:
            Counted.looks += 1
            return True

        @connected.setter
        def connected(self, value: bool) -> None: ...

    async def work() -> None:
        stream, _ = make(None)
        count = 3000
        for _ in range(count):
            stream.put(Counted(), 0)
        assert Counted.looks < 4 * count
        times = []
        for number in (1, count):
            stream, _ = make(None)
            for _ in range(number):
                stream.put(Link(), 0)
            rounds = []
            for _ in range(10):
                begun = perf_counter()
                assert not any(stream.full for _ in range(100))
                rounds.append(perf_counter() - begun)
            times.append(min(rounds))
        assert times[1] < 20 * times[0]

    run(work)
