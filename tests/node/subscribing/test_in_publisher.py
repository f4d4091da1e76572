"""Callbacks in the thread of a publisher of the same process: `subscribe(..., in_publisher=True)`.

Feature: callbacks run in the publisher's thread within a process -- `subscribe(..., in_publisher=True)`
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from threading import get_ident
from typing import Any

import pytest

from pyros1.msgs.std_msgs.msg import Float64, Header, String
from pyros1.net.loop import LoopThread
from pyros1.node import Node

Make = Callable[..., Node]


def linked(node: Node, topic: str, kind: Any = Float64, **options: Any) -> Any:
    publisher = node.advertise(topic, kind, **options)
    assert publisher.wait_for_subscribers(timeout=20)
    return publisher


def settle(publisher: Any, kept: Kept) -> None:
    """Publish until messages come in this thread: another one may still be at work for the link that is new."""
    pause = threading.Event()
    for _ in range(1000):
        publisher.publish(Float64(0))
        if kept.threads[-1:] == [get_ident()]:
            break
        pause.wait(0.005)
    kept.numbers.clear()
    kept.threads.clear()


class Kept:
    """Keeps numbers and the threads in which they came."""

    def __init__(self) -> None:
        self.numbers: list[float] = []
        self.threads: list[int] = []

    def __call__(self, message: Any) -> None:
        self.numbers.append(message.data)
        self.threads.append(get_ident())


@pytest.mark.parametrize("callbacks", ["inline", "spin"])
def test_the_callback_has_run_when_publish_returns(make_node: Make, callbacks: str) -> None:
    node, other, kept = make_node("a", callbacks=callbacks), make_node("b"), Kept()
    node.subscribe("t", Float64, kept, queue_size=10, in_publisher=True)
    for publisher in (linked(node, "t"), linked(other, "t")):
        settle(publisher, kept)
        for number in range(200):
            publisher.publish(Float64(number))
            assert kept.numbers[-1:] == [number]
    assert set(kept.threads) == {get_ident()}


def test_latched_messages_and_those_of_other_processes_come_as_usual(make_node: Make, transport: str) -> None:
    """A link that is not within the process, and the last message of a latched topic."""
    latching = make_node("latching").advertise("t", Float64, latch=True)
    latching.publish(Float64(1))
    came, kept = threading.Event(), Kept()

    def heard(message: Any) -> None:
        kept(message)
        came.set()

    make_node("a").subscribe("t", Float64, heard, in_publisher=True)
    assert came.wait(20)
    assert latching.wait_for_subscribers(timeout=20)
    came.clear()
    latching.publish(Float64(2))
    assert came.wait(20)
    assert kept.numbers == [1, 2]


def test_all_subscribers_must_want_it(make_node: Make) -> None:
    node, kept, usual = make_node("a"), Kept(), Kept()
    node.subscribe("t", Float64, kept, in_publisher=True)
    here = threading.Event()
    other = node.subscribe("t", Float64, lambda message: (usual(message), here.set()))
    publisher = linked(node, "t")
    publisher.publish(Float64(1))
    assert here.wait(20)
    assert get_ident() not in kept.threads + usual.threads
    other.unregister()
    deadline = threading.Event()
    for number in range(2, 500):  # the first may still come after one that was under way
        publisher.publish(Float64(number))
        if kept.threads[-1:] == [get_ident()]:
            break
        deadline.wait(0.01)
    assert kept.threads[-1] == get_ident()
    assert kept.numbers == sorted(kept.numbers)


def test_in_a_node_that_spins_others_wait(make_node: Make) -> None:
    node, kept, usual = make_node("a", callbacks="spin"), Kept(), Kept()
    node.subscribe("t", Float64, kept, in_publisher=True)
    node.subscribe("t", Float64, usual)
    publisher = linked(node, "t")
    settle(publisher, kept)
    while node.spin_once(0.0):
        pass
    usual.numbers.clear()
    publisher.publish(Float64(5))
    assert kept.numbers == [5] and usual.numbers == []
    assert node.spin_once(1.0) == 1
    assert usual.numbers == [5]


def test_a_callback_that_publishes_on_its_own_topic_gets_that_afterwards(make_node: Make) -> None:
    node, inside, done = make_node("a"), [], threading.Event()
    numbers: list[float] = []

    def heard(message: Any) -> None:
        inside.append(1)
        assert len(inside) == 1
        numbers.append(message.data)
        if message.data:
            publisher.publish(Float64(message.data - 1))
        else:
            done.set()
        inside.pop()

    node.subscribe("t", Float64, heard, in_publisher=True)
    publisher = linked(node, "t")
    publisher.publish(Float64(2000))  # far more than the interpreter's stack would take
    assert done.wait(10)  # the thread that publishes does some of it, the node's loop the rest
    assert numbers == list(range(2000, -1, -1))


def test_topics_that_call_each_other(make_node: Make) -> None:
    node, seen, done = make_node("a"), [], threading.Event()
    pong = node.advertise("pong", Float64)
    node.subscribe("ping", Float64, pong.publish, in_publisher=True)

    def back(message: Any) -> None:
        seen.append(message.data)
        if message.data < 500:
            ping.publish(Float64(message.data + 1))
        else:
            done.set()

    node.subscribe("pong", Float64, back, in_publisher=True)
    assert pong.wait_for_subscribers(timeout=20)
    ping = linked(node, "ping")
    ping.publish(Float64(0))
    assert done.wait(10)
    assert seen == list(range(501))


def test_errors_and_interrupts(make_node: Make) -> None:
    """An exception of a callback is logged, and one that means an end passes through publish; the topic goes on."""
    node, kept = make_node("a"), Kept()
    errors: list[BaseException] = []

    def heard(message: Any) -> None:
        kept(message)
        if message.data == 1:
            raise ValueError("no good")
        if message.data == 2:
            raise KeyboardInterrupt

    node.subscribe("t", Float64, heard, in_publisher=True)
    publisher = linked(node, "t")
    settle(publisher, kept)
    for number in range(5):
        try:
            publisher.publish(Float64(number))
        except KeyboardInterrupt as error:
            errors.append(error)
    assert len(errors) == 1
    assert kept.numbers == [0, 1, 2, 3, 4] and set(kept.threads) == {get_ident()}


def test_threads_that_publish_at_once(make_node: Make) -> None:
    """Calls never overlap, and each thread's messages come in order; none is lost."""
    node, inside, came = make_node("a"), [], threading.Event()
    numbers: list[int] = []

    def heard(message: Any) -> None:
        inside.append(1)
        assert len(inside) == 1
        numbers.append(int(message.data))
        if len(numbers) == 4000:
            came.set()
        inside.pop()

    node.subscribe("t", Float64, heard, in_publisher=True)
    publisher, begin = linked(node, "t", queue_size=0), threading.Barrier(4)

    def publish(first: int) -> None:
        begin.wait(5)
        for number in range(1000):
            publisher.publish(Float64(first + number))

    threads = [threading.Thread(target=publish, args=(10_000 * each,)) for each in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(20)
    assert came.wait(10)
    for each in range(4):
        assert [n % 10_000 for n in numbers if n // 10_000 == each] == list(range(1000))


def test_a_callback_may_end_all(make_node: Make) -> None:
    node, other, numbers = make_node("a"), make_node("b"), []

    ended = threading.Event()

    def heard(message: Any) -> None:
        numbers.append(message.data)
        subscriber.unregister()
        publisher.unregister()
        node.shutdown("done")
        ended.set()

    subscriber = node.subscribe("t", Float64, heard, in_publisher=True)
    publisher = linked(other, "t")
    publisher.publish(Float64(1))
    assert ended.wait(10)
    assert numbers == [1] and not node.ok()


@pytest.mark.slow
@pytest.mark.parametrize("own", [True, False])
def test_a_node_that_ends_during_a_callback_closes_its_links(make_node: Make, fake_node: Any, own: bool) -> None:
    """Also those to other processes, although the threads that receive have ended before the callback has."""
    node, kept, far = make_node("a"), Kept(), fake_node("/far")

    def heard(message: Any) -> None:
        kept(message)
        if message.data == 1 and own:
            node.shutdown("done")
        elif message.data == 1:
            other = threading.Thread(target=node.shutdown)
            other.start()
            other.join(20)

    node.subscribe("t", Float64, heard, in_publisher=True)
    far.publish("/t")
    publisher = linked(make_node("b"), "t")
    sock = far.accept_subscriber()
    settle(publisher, kept)
    publisher.publish(Float64(1))
    assert kept.numbers == [1]
    sock.settimeout(20)
    assert sock.recv(10) == b""


def test_other_kinds_of_messages(make_node: Make, collect: Any) -> None:
    """Messages with a header get their number, numpy views and messages of another class are made for the callback."""
    node, seen = make_node("a"), collect()
    node.subscribe("header", Header, seen, in_publisher=True)
    node.subscribe("text", "std_msgs/String", seen, arrays="memoryview", in_publisher=True)
    header, text = linked(node, "header", Header), linked(node, "text", String)
    header.publish(Header(frame_id="map"))
    seen.wait(1)
    text.publish(String("hello"))
    seen.wait(2)
    assert [seen.items[0].frame_id, seen.items[1].data] == ["map", "hello"]
    assert seen.items[0]._connection_header["callerid"] == "/a"


def test_no_callback_holds_up_a_loop(make_node: Make) -> None:
    """A latched message comes when the link is made, by a loop: a callback may wait there for what the loop does."""
    make_node("latching").advertise("t", Float64, latch=True).publish(Float64(1))
    node, threads, came = make_node("a"), [], threading.Event()

    def heard(message: Any) -> None:
        threads.append(threading.current_thread())
        came.set()

    node.subscribe("t", Float64, heard, in_publisher=True)
    assert came.wait(20)
    assert not isinstance(threads[0], LoopThread)
