"""Subscriptions: what becomes of links that are made while a subscription ends."""

from __future__ import annotations

import threading
from typing import Any

import pytest

from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node.subscribing.subscription import Subscription

from ..conftest import PATIENCE


def test_a_subscriber_that_ends_while_its_link_is_made_leaves_no_link(
    make_node: Any, until: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    add = Subscription.add_inbox_link
    is_linked, has_ended = threading.Event(), threading.Event()

    def add_late(subscription: Subscription, link: Any) -> None:
        is_linked.set()
        assert has_ended.wait(PATIENCE)
        add(subscription, link)

    monkeypatch.setattr(Subscription, "add_inbox_link", add_late)
    publisher = make_node("talker").advertise("t", Float64)
    subscriber = make_node("listener").subscribe("t", Float64, lambda message: None)
    assert is_linked.wait(PATIENCE)
    assert publisher.wait_for_subscribers(1, PATIENCE)
    subscriber.unregister()
    has_ended.set()
    until(lambda: publisher.num_connections == 0)
