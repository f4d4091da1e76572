"""dispatcher: which subscribers get a latched message, and when; in a node that spins, some without a spin."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from pyros1.ground.errors import WaitTimeoutError
from pyros1.msgs.std_msgs.msg import Float64

from ...parts import subscription_of

SHORT = 0.1


def test_a_latched_message_is_there_again_and_again_until_its_publisher_leaves(
    make_node: Any, collect: Any, until: Any
) -> None:
    node, talker, got = make_node("listener", callbacks="spin"), make_node("talker"), collect()
    subscriber = node.subscribe("t", Float64, got)
    publisher = talker.advertise("t", Float64, latch=True)
    publisher.publish(1)
    for _ in range(3):
        assert node.wait_for_message("t", Float64, timeout=20).data == 1
    publisher.publish(2)
    until(lambda: node.wait_for_message("t", Float64, timeout=20).data == 2)
    assert got.items == []
    publisher.unregister()
    until(lambda: subscriber.num_connections == 0)
    with pytest.raises(WaitTimeoutError):
        node.wait_for_message("t", Float64, timeout=SHORT)


def test_another_message_is_there_once(make_node: Any, collect: Any, until: Any) -> None:
    node, talker, got = make_node("listener", callbacks="spin"), make_node("talker"), collect()
    node.subscribe("t", Float64, got)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    until(lambda: node.spin_once(0.01) >= 0 and got.items)
    with pytest.raises(WaitTimeoutError):
        node.wait_for_message("t", Float64, timeout=SHORT)


def test_a_latched_message_comes_once_to_a_subscriber_that_spins(make_node: Any, collect: Any, until: Any) -> None:
    """It has arrived, but waits for the spin when the subscriber is made: then it is not latched for it yet."""
    node, talker, got, later = make_node("listener", callbacks="spin"), make_node("talker"), collect(), collect()
    node.subscribe("t", Float64, got)
    publisher = talker.advertise("t", Float64, latch=True)
    publisher.publish(1)
    assert node.wait_for_message("t", Float64, timeout=20).data == 1
    node.subscribe("t", Float64, later)
    until(lambda: node.spin_once(0.01) >= 0 and got.items and later.items)
    publisher.publish(2)
    until(lambda: node.spin_once(0.01) >= 0 and got.data[-1] == later.data[-1] == 2)
    assert got.data == later.data == [1, 2]


@pytest.mark.parametrize("callbacks", ["inline", "spin"])
def test_what_is_delivered_after_its_publisher_left_is_not_latched(
    make_node: Any, collect: Any, until: Any, callbacks: str
) -> None:
    node, talker, got, later = make_node("listener", callbacks=callbacks), make_node("talker"), collect(), collect()
    held, go_on = threading.Event(), threading.Event()

    def hold() -> None:
        held.set()
        go_on.wait(20)

    subscriber = node.subscribe("t", Float64, got)
    publisher = talker.advertise("t", Float64, latch=True)
    assert publisher.wait_for_subscribers(timeout=20)
    subscription_of(node).delivery.submit(hold)
    assert held.wait(20)
    publisher.publish(1)
    publisher.unregister()
    until(lambda: subscriber.num_connections == 0)
    go_on.set()
    until(lambda: (callbacks == "inline" or node.spin_once(0.01) >= 0) and got.items)
    with pytest.raises(WaitTimeoutError):
        node.wait_for_message("t", Float64, timeout=SHORT)
    node.subscribe("t", Float64, later)
    publisher = talker.advertise("t", Float64, latch=True)
    publisher.publish(2)
    until(lambda: (callbacks == "inline" or node.spin_once(0.01) >= 0) and later.items)
    assert later.data == [2]


@pytest.mark.parametrize("callbacks", ["inline", "spin"])
def test_the_latched_message_of_a_publisher_that_left_is_forgotten(
    make_node: Any, collect: Any, until: Any, callbacks: str
) -> None:
    node, talker, got, later = make_node("listener", callbacks=callbacks), make_node("talker"), collect(), collect()
    subscriber = node.subscribe("t", Float64, got)
    publisher = talker.advertise("t", Float64, latch=True)
    publisher.publish(1)
    until(lambda: (callbacks == "inline" or node.spin_once(0.01) >= 0) and got.items)
    publisher.unregister()
    until(lambda: subscriber.num_connections == 0)
    node.subscribe("t", Float64, later)
    talker.advertise("t", Float64, latch=True).publish(2)
    until(lambda: (callbacks == "inline" or node.spin_once(0.01) >= 0) and later.items)
    assert later.data == [2]


def test_a_lower_queue_size_leaves_no_message_behind(make_node: Any, collect: Any, until: Any) -> None:
    node, talker, got, other = make_node("listener", callbacks="spin"), make_node("talker"), collect(), collect()
    larger = node.subscribe("t", Float64, other, queue_size=10)
    node.subscribe("t", Float64, got, queue_size=2)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    delivery = subscription_of(node, "/t").delivery
    for number in range(10):
        publisher.publish(number)
    until(lambda: not len(delivery.inboxes) and delivery.waiting == 10)
    larger.unregister()
    for number in range(10, 15):
        publisher.publish(number)
    until(lambda: delivery.dropped == 3)
    until(lambda: node.spin_once(0.01) >= 0 and not delivery.waiting)
    assert got.data == [*range(10), 13, 14]
