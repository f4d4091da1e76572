"""The asyncio loop as driver of deliveries.

Feature: asyncio
"""

from __future__ import annotations

import asyncio
import socket
import threading
from collections.abc import Callable, Coroutine
from typing import Any

import pytest

import pyros1.aio
from pyros1.aio.driver import LoopDriver
from pyros1.aio.messages import MAX_PENDING
from pyros1.msgs import AnyMsg
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.node.subscribing.delivery_loop import DeliveryLoop
from pyros1.node.subscribing.tcp_source import TcpSource
from pyros1.node.topic_type import topic_type


def run(work: Callable[[], Coroutine[Any, Any, None]]) -> None:
    asyncio.run(asyncio.wait_for(work(), 20))


@pytest.fixture(params=["TCP", "within the process"])
def transport(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    if request.param == "TCP":
        monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)


async def connected(publisher: Any) -> None:
    assert await asyncio.to_thread(publisher.wait_for_subscribers, 1, 10.0)


async def take(stream: Any, count: int) -> list[Any]:
    return [(await stream.__anext__()).data for _ in range(count)]


def test_the_loop_itself_receives(environ: dict[str, str], make_node: Any, transport: None) -> None:
    publisher = make_node("talker").advertise("t", Float64, queue_size=0)

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", Float64)
            await connected(publisher)
            for number in range(500):
                publisher.publish(number)
            assert await take(stream, 500) == list(range(500))
            names = [thread.name for thread in threading.enumerate()]
            assert not any(name.startswith("/listener:reader") for name in names), names

    run(work)


def test_callbacks_of_the_same_topic_may_wait_without_stopping_the_loop(
    environ: dict[str, str], make_node: Any, transport: None
) -> None:
    """The topic moves to the node's threads; streams go on, and those that come later join."""
    publisher = make_node("talker").advertise("t", Float64, queue_size=0)
    waits, goes_on, done, got = threading.Event(), threading.Event(), threading.Event(), []

    def callback(message: Float64) -> None:
        if message.data == 10:
            waits.set()
            assert goes_on.wait(10)
        got.append(message.data)
        if message.data == 299:
            done.set()

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", Float64)
            await connected(publisher)
            for number in range(10):
                publisher.publish(number)
            assert await take(stream, 10) == list(range(10))
            subscriber = await asyncio.to_thread(node.sync.subscribe, "t", Float64, callback)
            other = await node.subscribe("t", Float64)
            for number in range(10, 300):
                publisher.publish(number)
            assert await asyncio.to_thread(waits.wait, 10)  # and the loop runs
            goes_on.set()
            both = await asyncio.gather(take(stream, 290), take(other, 290))
            assert both == [list(range(10, 300))] * 2
            assert await asyncio.to_thread(done.wait, 10)
            await asyncio.to_thread(subscriber.unregister)
            publisher.publish(300)
            assert await take(stream, 1) == [300]
        assert got == list(range(10, 300))

    run(work)


def test_a_limited_stream_has_the_newest_messages_after_the_loop_was_busy(
    environ: dict[str, str], make_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
    publisher = make_node("talker").advertise("t", String, queue_size=None)
    count, size = 200, 1 << 17  # more than fits between the two, so the publisher waits while nobody receives

    def publish() -> None:
        for number in range(count):
            publisher.publish(f"{number:{size}}")

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", String, queue_size=1)
            await connected(publisher)
            publishing = threading.Thread(target=publish)
            publishing.start()
            publishing.join(10)  # on the loop's thread
            assert not publishing.is_alive()
            while int((await stream.__anext__()).data) < count - 1:
                pass
            assert stream.dropped > count // 2

    run(work)


def test_a_busy_loop_loses_nothing_of_a_publisher_with_a_short_queue_in_the_process(
    environ: dict[str, str], make_node: Any
) -> None:
    publisher = make_node("talker").advertise("t", Float64, queue_size=1)

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", Float64)
            await connected(publisher)
            for number in range(MAX_PENDING):
                publisher.publish(number)
            assert await take(stream, MAX_PENDING) == list(range(MAX_PENDING))

    run(work)


def test_a_stream_joins_a_topic_that_has_a_callback(environ: dict[str, str], make_node: Any, transport: None) -> None:
    publisher = make_node("talker").advertise("t", Float64, queue_size=0)
    got: list[float] = []

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            await asyncio.to_thread(lambda: node.sync.subscribe("t", Float64, lambda m: got.append(m.data)))
            stream = await node.subscribe("t", Float64)
            await connected(publisher)
            for number in range(500):
                publisher.publish(number)
            assert await take(stream, 500) == list(range(500))
        assert got == list(range(500))

    run(work)


def test_a_loop_that_cannot_wait_for_sockets(environ: dict[str, str], make_node: Any, transport: None) -> None:
    """As the usual one on Windows: the node's threads receive."""

    class Loop(asyncio.SelectorEventLoop):
        def add_reader(self, fd: Any, callback: Any, *args: Any) -> Any:
            raise NotImplementedError

    publisher = make_node("talker").advertise("t", Float64, queue_size=0)

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", Float64)
            await connected(publisher)
            for number in range(500):
                publisher.publish(number)
            assert await take(stream, 500) == list(range(500))

    loop = Loop()
    try:
        loop.run_until_complete(asyncio.wait_for(work(), 20))
        loop.run_until_complete(loop.shutdown_default_executor())
    finally:
        loop.close()


def test_other_tasks_run_during_a_flood(environ: dict[str, str], make_node: Any, transport: None) -> None:
    publisher = make_node("talker").advertise("t", Float64, queue_size=None)
    enough = threading.Event()

    def talk() -> None:
        while not enough.is_set():
            publisher.publish(1.0)

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            streams = [await node.subscribe("t", Float64, queue_size=size) for size in (None, 1, 1000)]
            await connected(publisher)
            talking = asyncio.ensure_future(asyncio.to_thread(talk))
            reading = [asyncio.ensure_future(take(stream, 10**9)) for stream in streams]
            for _ in range(300):
                await asyncio.sleep(0)
            enough.set()
            await talking
            for task in reading:
                task.cancel()
            await asyncio.gather(*reading, return_exceptions=True)

    run(work)


def test_messages_that_cannot_be_decoded_are_logged_and_cost_only_themselves(
    environ: dict[str, str], make_node: Any, transport: None, capfd: pytest.CaptureFixture[str]
) -> None:
    publisher = make_node("talker").advertise("t", AnyMsg, queue_size=0, raw_type=topic_type(String))

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", String)
            await connected(publisher)
            for body in (b"\1\0\0\0a", b"\2\0\0", b"", b"\1\0\0\0b"):
                publisher.publish(AnyMsg(body))
            assert await take(stream, 2) == ["a", "b"]

    run(work)
    err = capfd.readouterr().err
    assert err.count("(message dropped)") == 2 and "/t from /talker" in err


def test_a_latched_message_reaches_streams_that_come_later(
    environ: dict[str, str], make_node: Any, transport: None
) -> None:
    publisher = make_node("talker").advertise("t", Float64, latch=True)
    publisher.publish(7)

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            first = await node.subscribe("t", Float64)
            assert await take(first, 1) == [7]
            later = await node.subscribe("t", Float64, queue_size=1)
            assert await take(later, 1) == [7]
            assert await node.wait_for_message("t", Float64, timeout=10) == Float64(7)

    run(work)


def test_large_messages(environ: dict[str, str], make_node: Any, transport: None) -> None:
    publisher = make_node("talker").advertise("t", String, queue_size=0)

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", String)
            await connected(publisher)
            for number in range(10):
                publisher.publish(str(number) * 3_000_000)
            got = await take(stream, 10)
            assert [(text[0], len(text)) for text in got] == [(str(number), 3_000_000) for number in range(10)]
            assert (await stream.__anext__() if stream.waiting else None) is None

    run(work)


def test_publishers_come_and_go(environ: dict[str, str], make_node: Any, transport: None) -> None:
    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            stream = await node.subscribe("t", Float64)
            for number in range(5):
                async with pyros1.aio.Node(f"talker{number}", argv=[], environ=environ) as talker:
                    publisher = await talker.advertise("t", Float64, queue_size=0)
                    await connected(publisher)
                    publisher.publish(number)
                    assert await take(stream, 1) == [number]

    run(work)


def test_a_subscribe_that_is_cancelled_leaves_nothing_that_holds_publishers_back(
    environ: dict[str, str], make_node: Any, transport: None
) -> None:
    publisher = make_node("talker").advertise("t", Float64)

    async def talk() -> None:
        while True:
            publisher.publish(0)
            await asyncio.sleep(0)

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            for _ in range(5):
                subscribing = asyncio.ensure_future(node.subscribe("t", Float64))
                await asyncio.sleep(0)
                subscribing.cancel()
                await asyncio.wait([subscribing])
                assert subscribing.cancelled()
            stream = await node.subscribe("t", Float64)
            talking = asyncio.ensure_future(talk())
            await take(stream, 10 * MAX_PENDING)
            talking.cancel()

    run(work)


def test_a_node_whose_loop_was_stopped_ends_from_another_thread(
    environ: dict[str, str], make_node: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.node.subscribing.connector.find_local_context", lambda uri: None)
    publisher = make_node("talker").advertise("t", Float64)

    async def begin() -> pyros1.aio.Node:
        node = pyros1.aio.Node("listener", argv=[], environ=environ)
        await node.__aenter__()
        await node.subscribe("t", Float64)
        await connected(publisher)
        return node

    loop = asyncio.new_event_loop()
    node = loop.run_until_complete(begin())
    ending = threading.Thread(target=node.sync.shutdown)
    ending.start()
    ending.join(4)
    late = ending.is_alive()
    ending.join()
    loop.run_until_complete(node.__aexit__(None, None, None))
    loop.run_until_complete(loop.shutdown_default_executor())
    loop.close()
    assert not late


def test_closing_without_waiting_does_not_wait_for_a_busy_loop() -> None:
    """The thread of a node's sockets closes links, too, and must never wait for a coroutine."""
    busy = threading.Event()
    sender, receiver = socket.socketpair()
    dispatcher: Any = Discarding()

    def close(delivery: DeliveryLoop) -> None:
        assert busy.wait(10)
        delivery.close(timeout=60, wait=False)

    async def work() -> None:
        driver = LoopDriver(asyncio.get_running_loop(), pytest.fail)
        delivery = DeliveryLoop(dispatcher, driver, None, lambda *_: None)
        delivery.links.open(TcpSource(receiver, "http://x:1/", {}, b""))
        closing = threading.Thread(target=close, args=(delivery,))
        closing.start()
        busy.set()
        closing.join(15)  # meanwhile, the loop does nothing
        waits = closing.is_alive()
        closing.join()
        assert not waits and len(delivery.links) == 1
        while delivery.links:
            await asyncio.sleep(0)
        assert sender.recv(1) == b""

    with sender:
        run(work)


class Discarding:
    """Stands in for the dispatcher of a topic."""

    is_held_back = False

    def forget(self, source: Any) -> None: ...
