"""Nodelets that limit the rate of a topic.

Feature: nodelets named NodeletThrottleImage and the like run as a node that limits the rate of any topic
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from contextlib import closing
from queue import Queue
from types import SimpleNamespace
from typing import Any

import pytest

from pyros1.ground.timing import Time
from pyros1.msgs import AnyMsg
from pyros1.msgs.std_msgs.msg import Int32
from pyros1.node import Node
from pyros1.reconfigure import Client
from pyros1.robot_nodes.nodelet.throttle import Throttle

PATIENCE = 20.0


def test_messages_pass_at_a_limited_rate(
    make_node: Callable[..., Node], until: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    user, source = make_node("user"), make_node("source")
    user.params["/throttle/update_rate"] = 2.0
    node = make_node("throttle", argv=["topic_in:=numbers", "topic_out:=slow_numbers"])
    times: list[float] = []  # when the messages arrive, and how many have
    arrived: list[float] = []

    def now() -> Time:
        arrived.append(times[-1])
        return Time.from_sec(times[-1])

    monkeypatch.setattr(node, "now", now)
    running = Throttle(node)
    numbers = source.advertise("numbers", Int32)
    assert numbers.wait_for_subscribers(1, PATIENCE)
    numbers.publish(-1)  # tells the type
    passed: Queue[int] = Queue()
    until(lambda: "/slow_numbers" in dict(node.master.get_system_state()[0]))
    until(lambda: not numbers.num_connections)  # nobody wants them
    subscriber = user.subscribe("slow_numbers", Int32, lambda number: passed.put(number.data))
    assert numbers.wait_for_subscribers(1, PATIENCE)

    def send(number: int, seconds: float) -> None:
        times.append(seconds)
        numbers.publish(number)
        until(lambda: len(arrived) == len(times))

    for number, seconds in enumerate([100.0, 100.25, 100.5, 100.75, 90.0, 90.25, 90.5]):
        send(number, seconds)
    assert [passed.get(timeout=PATIENCE) for _ in range(4)] == [0, 2, 4, 6]
    with closing(Client(user, "throttle")) as client:
        client.update({"update_rate": 0.0})
    send(7, 90.5)
    send(8, 90.5)
    assert [passed.get(timeout=PATIENCE) for _ in range(2)] == [7, 8]
    subscriber.unregister()
    until(lambda: not numbers.num_connections)
    del running


def test_the_first_message_may_come_at_once(make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch) -> None:
    node, ended, threads = make_node("throttle"), threading.Event(), []
    message = AnyMsg()
    message._connection_header = {"type": "std_msgs/Int32", "md5sum": Int32._md5sum}

    def subscribe(topic: str, cls: Any, callback: Callable[[Any], None], **options: Any) -> Any:
        threads.append(threading.Thread(target=callback, args=[message]))
        threads[0].start()
        threads[0].join(0.1)  # the message is there before the subscription is returned
        return SimpleNamespace(unregister=ended.set)

    monkeypatch.setattr(node, "subscribe", subscribe)
    running = Throttle(node)
    assert ended.wait(PATIENCE), "the subscription remains"
    threads[0].join(PATIENCE)
    del running
