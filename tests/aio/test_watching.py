"""watching: news of another node, and messages that must come in time, for asyncio."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from types import SimpleNamespace
from typing import Any

import pytest

import pyros1.aio
from pyros1.aio.watching import Sightings
from pyros1.ground.errors import InvalidNameError, NodeShutdownError
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node.watching.notifiers import MAX_PENDING


def run(work: Callable[[pyros1.aio.Node], Coroutine[Any, Any, None]], environ: dict[str, str]) -> None:
    async def main() -> None:
        async with pyros1.aio.Node("watcher", argv=[], environ=environ) as node:
            await work(node)

    asyncio.run(asyncio.wait_for(main(), 20))


def test_a_node_that_comes_and_goes(environ: dict[str, str], make_node: Any) -> None:
    async def work(node: pyros1.aio.Node) -> None:
        with node.watch("x", period=0.02, limit=5.0) as sightings:
            for _ in range(2):
                watched = await asyncio.to_thread(make_node, "x")
                assert (await anext(sightings)).alive and sightings.alive
                await asyncio.to_thread(watched.shutdown)
                lost = await anext(sightings)
                assert not lost.alive and sightings.last is lost and sightings.state.name == "LOST"

    run(work, environ)


def test_the_iteration_ends_with_the_node_and_when_it_is_closed(environ: dict[str, str]) -> None:
    async def work(node: pyros1.aio.Node) -> None:
        async def all_of(sightings: pyros1.aio.Sightings) -> list[bool]:
            return [sighting.alive async for sighting in sightings]

        first, second = (node.watch("watcher", period=0.02, limit=5.0) for _ in range(2))
        tasks = [asyncio.ensure_future(all_of(each)) for each in (first, second)]
        while not (first.last and second.last):
            await asyncio.sleep(0.001)
        first.close()
        assert await tasks[0] == [True]
        await asyncio.to_thread(node.sync.shutdown)
        assert await tasks[1] == [True]
        with pytest.raises(NodeShutdownError):
            node.watch("x")

    run(work, environ)


def test_wrong_arguments(environ: dict[str, str]) -> None:
    async def work(node: pyros1.aio.Node) -> None:
        with pytest.raises(InvalidNameError):
            node.watch("")
        with pytest.raises(ValueError, match="watch: period must be above 0"):
            node.watch("x", period=-1.0)

    run(work, environ)


def test_a_message_that_is_late_is_not_lost(environ: dict[str, str]) -> None:
    async def work(node: pyros1.aio.Node) -> None:
        publisher = await node.advertise("t", Float64)
        async with await node.subscribe("t", Float64) as messages:
            assert await asyncio.to_thread(publisher.wait_for_subscribers, 1, 10.0)
            for number in range(50):
                with pytest.raises((TimeoutError, asyncio.TimeoutError)):
                    await asyncio.wait_for(anext(messages), 0.0005)
                publisher.publish(number)
                assert (await anext(messages)).data == number

    run(work, environ)


def test_of_news_that_wait_the_newest_come_in_order() -> None:
    """An iteration that is slow misses the oldest."""

    async def main() -> None:
        told: list[Callable[[Any], None]] = []

        def begin(tell: Callable[[Any], None]) -> Any:
            told.append(tell)
            return SimpleNamespace(close=lambda: None)

        sightings = Sightings(asyncio.get_running_loop(), begin)
        news = [object() for _ in range(MAX_PENDING + 20)]
        for each in news:
            told[0](each)
        sightings.close()
        assert [each async for each in sightings] == news[20:]

    asyncio.run(main())
