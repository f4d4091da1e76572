"""Latched messages in a node that spins: who waits for a message gets them without a spin."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.ground.errors import WaitTimeoutError
from pyros1.msgs.std_msgs.msg import Float64

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
