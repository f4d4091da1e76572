"""Chains of filters in nodes, and synchronized messages in asyncio programs."""

from __future__ import annotations

import asyncio
import queue
import threading
from typing import Any

import pytest

import pyros1.aio
from pyros1.filters import Cache, Filter, Subscriber, Synchronizer, synchronized
from pyros1.ground.timing import Duration, Time
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.msgs.std_msgs.msg import String


def stamped(cls: Any, stamp: Time) -> Any:
    message = cls()
    message.header.stamp = stamp
    return message


def test_a_camera_and_its_info(make_node: Any) -> None:
    node = make_node("camera")
    inputs = [Subscriber(node, "image", Image), Subscriber(node, "info", CameraInfo, queue_size=5)]
    got: queue.Queue[Any] = queue.Queue()
    Synchronizer(inputs).connect(lambda *messages: got.put(messages))
    cache = Cache(inputs[0], 10)
    kept: queue.Queue[Any] = queue.Queue()
    cache.connect(kept.put)
    image, info = node.advertise("image", Image), node.advertise("info", CameraInfo)
    assert image.wait_for_subscribers(1, 10.0) and info.wait_for_subscribers(1, 10.0)
    for number in range(1, 4):
        image.publish(stamped(Image, Time(number)))
        kept.get(timeout=10)
        if number != 2:
            info.publish(stamped(CameraInfo, Time(number)))
    pairs = [got.get(timeout=10) for _ in range(2)]
    assert [[each.header.stamp.secs for each in pair] for pair in pairs] == [[1, 1], [3, 3]]
    assert [type(each) for each in pairs[0]] == [Image, CameraInfo]
    assert (cache.oldest, cache.newest) == (Time(1), Time(3))
    assert [each.header.stamp.secs for each in cache.between(Time(2), Time(9))] == [2, 3]
    before, after = cache.before(Time(2, 5)), cache.after(Time(2, 5))
    assert (before.header.stamp.secs, after.header.stamp.secs) == (2, 3)
    inputs[0].close()


class Clock:
    """A node as far as filters need one."""

    def __init__(self) -> None:
        self.time = Time(100)

    def now(self) -> Time:
        return self.time


def test_a_jump_back_in_time_clears() -> None:
    clock: Any = Clock()
    inputs, got = [Filter(clock), Filter(clock)], []
    Synchronizer(inputs, 5, slop=1.0).connect(lambda *messages: got.append(messages))
    inputs[0].emit(stamped(Image, Time(100)))
    clock.time -= Duration(50)
    inputs[1].emit(stamped(Image, Time(100)))
    assert not got
    inputs[0].emit(stamped(Image, Time(100, 5)))
    assert len(got) == 1


def test_two_threads_at_the_same_time() -> None:
    """The thread that comes second must not seem to be earlier than the first."""
    clock: Any = Clock()
    inputs = [Filter(clock), Filter(clock)]
    got: list[Any] = []
    Synchronizer(inputs).connect(lambda *messages: got.append(messages))
    other = threading.Thread(target=lambda: inputs[1].emit(stamped(Image, Time(100))))
    other_has_asked = threading.Event()

    def now() -> Time:
        if threading.current_thread() is other:
            other_has_asked.set()
            return Time(100, 2)
        other.start()
        if other_has_asked.wait(0.05):  # then the other one goes on first
            other.join()
        return Time(100, 1)

    clock.now = now
    inputs[0].emit(stamped(Image, Time(100)))
    other.join()
    assert len(got) == 1


def test_messages_without_header() -> None:
    clock: Any = Clock()
    source, got = Filter(clock), []
    Synchronizer([source], headerless=True).connect(got.append)
    source.emit(String("a"))
    assert got == [String("a")]
    Cache(source, 5)
    with pytest.raises(TypeError, match="no header"):
        source.emit(String("a"))
    with pytest.raises(ValueError, match="at least one"):
        Synchronizer([])


def test_asyncio(environ: dict[str, str], make_node: Any) -> None:
    talker = make_node("talker")
    images, infos = talker.advertise("image", Image), talker.advertise("info", CameraInfo)

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            sets = synchronized(node, {"image": Image, "info": CameraInfo}, queue_size=20, slop=0.5)
            first = asyncio.ensure_future(sets.__anext__())
            for publisher in (images, infos):
                assert await asyncio.to_thread(publisher.wait_for_subscribers, 1, 10.0)
            for number in range(20):
                images.publish(stamped(Image, Time(number)))
                infos.publish(stamped(CameraInfo, Time(number, 1000)))
            found = [await first] + [await sets.__anext__() for _ in range(19)]
            assert [(image.header.stamp.secs, info.header.stamp.secs) for image, info in found] == [
                (number, number) for number in range(20)
            ]
            await sets.aclose()
            again = synchronized(node, {"image": Image})
            waits = asyncio.ensure_future(again.__anext__())
            await asyncio.to_thread(images.wait_for_subscribers, 1, 10.0)
            await asyncio.to_thread(node.sync.shutdown)
            with pytest.raises(StopAsyncIteration):
                await waits

    asyncio.run(asyncio.wait_for(work(), 30))


def test_asyncio_without_header(environ: dict[str, str], make_node: Any) -> None:
    texts = make_node("talker").advertise("text", String, latch=True)
    texts.publish("a")

    async def work() -> None:
        async with pyros1.aio.Node("listener", argv=[], environ=environ) as node:
            with pytest.raises(TypeError, match="no header"):
                await synchronized(node, {"text": String}).__anext__()

    asyncio.run(asyncio.wait_for(work(), 30))
