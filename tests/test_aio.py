"""aio: the asyncio face."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

import pytest
from pyros1.msgs.std_msgs.msg import Float64

import pyros1.aio
from pyros1.errors import NodeShutdownError, ServiceError, WaitTimeoutError


def run(work: Callable[[], Coroutine[Any, Any, None]]) -> None:
    asyncio.run(asyncio.wait_for(work(), 20))


def test_messages_arrive_in_order_and_the_iteration_ends_with_the_node(environ: dict[str, str]) -> None:
    async def work() -> None:
        async with (
            pyros1.aio.Node("talker", argv=[], environ=environ) as talker,
            pyros1.aio.Node("listener", argv=[], environ=environ) as listener,
        ):
            stream = await listener.subscribe("topic1", Float64)
            publisher = await talker.advertise("topic1", Float64, queue_size=0)
            assert await asyncio.to_thread(publisher.wait_for_subscribers, 1, 5.0)
            for number in range(1000):
                publisher.publish(float(number))
            got = [(await stream.__anext__()).data for _ in range(1000)]
            assert got == [float(number) for number in range(1000)]
            quiet = await listener.subscribe("quiet", Float64)
            task = asyncio.ensure_future(collect(quiet))
            await asyncio.to_thread(listener.sync.shutdown)
            assert await task == []

    async def collect(stream: pyros1.aio.Messages[Float64]) -> list[Any]:
        return [message async for message in stream]

    run(work)


def test_queue_size_keeps_the_newest(environ: dict[str, str]) -> None:
    async def work() -> None:
        async with pyros1.aio.Node("both", argv=[], environ=environ) as node:
            stream = await node.subscribe("topic1", Float64, queue_size=1)
            probe = await node.subscribe("topic1", Float64)
            publisher = await node.advertise("topic1", Float64)
            assert await asyncio.to_thread(publisher.wait_for_subscribers, 1, 5.0)
            for number in range(100):
                publisher.publish(float(number))
            while (await probe.__anext__()).data < 99:
                pass
            assert (await stream.__anext__()).data == 99

    run(work)


def test_services_with_coroutine_handlers(environ: dict[str, str]) -> None:
    async def flip(request: Any) -> Any:
        await asyncio.sleep(0)
        if request.data:
            raise RuntimeError("not today")
        return True, "flipped"

    async def work() -> None:
        async with pyros1.aio.Node("server", argv=[], environ=environ) as node:
            await node.advertise_service("flip", "std_srvs/SetBool", flip)
            await node.wait_for_service("flip", 5.0)
            client = node.service("flip", "std_srvs/SetBool")
            assert (await node.call(client, False)).message == "flipped"
            with pytest.raises(ServiceError, match="not today"):
                await node.call(client, True)

    run(work)


def test_wait_for_message_and_parameters(environ: dict[str, str]) -> None:
    async def work() -> None:
        async with pyros1.aio.Node("waiter", argv=[], environ=environ) as node:
            with pytest.raises(WaitTimeoutError, match="nothing"):
                await node.wait_for_message("nothing", Float64, timeout=0.05)
            publisher = await node.advertise("once", Float64, latch=True)
            publisher.publish(4.0)
            assert (await node.wait_for_message("once", Float64, timeout=5.0)).data == 4.0
            await node.set_param("~gain", 2.5)
            assert await node.get_param("~gain") == 2.5
            assert await node.get_param("~other", "none") == "none"

    run(work)


def test_a_slow_coroutine_handler_answers(environ: dict[str, str]) -> None:
    async def slow(request: Any) -> Any:
        await asyncio.sleep(0.7)  # longer than the handler's thread waits at a time
        return True, "done"

    async def work() -> None:
        async with pyros1.aio.Node("server", argv=[], environ=environ) as node:
            await node.advertise_service("slow", "std_srvs/Trigger", slow)
            assert (await node.call(node.service("slow", "std_srvs/Trigger"))).message == "done"

    run(work)


def test_what_would_block_is_refused_and_nothing_is_used_before_it_is_there(environ: dict[str, str]) -> None:
    async def work() -> None:
        node = pyros1.aio.Node("early", argv=[], environ=environ)
        assert not node.ok()
        with pytest.raises(NodeShutdownError, match="async with"):
            _ = node.name
        async with node:
            assert node.ok() and node.name == "/early"
            with pytest.raises(ValueError, match="queue_size=None"):
                await node.advertise("t", Float64, queue_size=None)
        assert not node.ok()

    run(work)


def test_closing_a_stream_unsubscribes_and_ends_it(environ: dict[str, str]) -> None:
    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", Float64)
            task = asyncio.ensure_future(_all(stream))
            await asyncio.sleep(0)
            await stream.aclose()
            await stream.aclose()
            assert await task == []
            assert "/t" not in node.sync._topics.subscriptions

    async def _all(stream: Any) -> list[Any]:
        return [message async for message in stream]

    run(work)
