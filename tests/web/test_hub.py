"""One subscription per topic, shared by all views."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.msgs import AnyMsg
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.web.hub import Arrival, Hub

from ..bodies import encode


class Subscriptions:
    """What a node would do, step by step."""

    def __init__(self) -> None:
        self.callbacks: dict[str, Callable[[AnyMsg], object]] = {}
        self.ended: list[str] = []

    def subscribe(self, topic: str, callback: Callable[[AnyMsg], object]) -> Any:
        self.callbacks[topic] = callback
        ended = self.ended

        class Subscriber:
            def unregister(self) -> None:
                ended.append(topic)

        return Subscriber()

    def send(self, topic: str, number: float, latching: bool = False, caller: str = "/talker") -> None:
        raw = AnyMsg(encode(Float64(number)))
        raw._connection_header = {
            "type": "std_msgs/Float64",
            "md5sum": Float64._md5sum,
            "message_definition": "float64 data",
            "callerid": caller,
            "latching": "1" if latching else "0",
        }
        self.callbacks[topic](raw)


@pytest.fixture
def subscriptions() -> Subscriptions:
    return Subscriptions()


@pytest.fixture
def hub(subscriptions: Subscriptions) -> Hub:
    return Hub(subscriptions.subscribe, lambda: 12.5)


def numbers(into: list[float]) -> Callable[[Arrival], object]:
    return lambda arrival: into.append(arrival.message.data)  # type: ignore[attr-defined]


def test_all_listeners_share_a_subscription(hub: Hub, subscriptions: Subscriptions) -> None:
    one: list[float] = []
    two: list[float] = []
    end_one = hub.listen("/a", numbers(one))
    first = subscriptions.callbacks["/a"]
    end_two = hub.listen("/a", numbers(two))
    assert subscriptions.callbacks["/a"] is first
    subscriptions.send("/a", 1.0)
    end_one()
    end_one()  # again does no harm
    subscriptions.send("/a", 2.0)
    assert (one, two, subscriptions.ended) == ([1.0], [1.0, 2.0], [])
    end_two()
    assert subscriptions.ended == ["/a"]
    hub.listen("/a", numbers(one))
    assert subscriptions.callbacks["/a"] is not first
    hub.close()
    assert subscriptions.ended == ["/a", "/a"]


def test_a_message_is_decoded_once_and_has_its_times(hub: Hub, subscriptions: Subscriptions) -> None:
    seen: list[Arrival] = []
    for _ in range(2):
        hub.listen("/a", seen.append)
    subscriptions.send("/a", 1.0)
    assert seen[0] is seen[1]
    assert seen[0].message is seen[1].message
    assert seen[0].time == 12.5


def test_a_later_listener_gets_what_is_latched_of_each_publisher(hub: Hub, subscriptions: Subscriptions) -> None:
    hub.listen("/a", lambda arrival: None)
    subscriptions.send("/a", 1.0, latching=True)
    subscriptions.send("/a", 2.0, latching=True)
    subscriptions.send("/a", 3.0, latching=True, caller="/other")
    subscriptions.send("/a", 4.0, caller="/third")
    later: list[float] = []
    hub.listen("/a", numbers(later))
    assert later == [2.0, 3.0]


def test_no_message_is_lost_that_comes_while_one_subscribes(subscriptions: Subscriptions) -> None:
    seen: list[float] = []

    def subscribe(topic: str, callback: Callable[[AnyMsg], object]) -> Any:
        found = subscriptions.subscribe(topic, callback)
        thread = threading.Thread(target=subscriptions.send, args=(topic, 7.0))
        thread.start()
        thread.join(10)
        return found

    Hub(subscribe, lambda: 0.0).listen("/a", numbers(seen))
    assert seen == [7.0]


def test_a_topic_that_cannot_be_subscribed_to_is_tried_anew() -> None:
    attempts: list[str] = []

    def subscribe(topic: str, callback: Callable[[AnyMsg], object]) -> Any:
        attempts.append(topic)
        raise ValueError("no")

    hub = Hub(subscribe, lambda: 0.0)
    for _ in range(2):
        with pytest.raises(ValueError, match="no"):
            hub.listen("/a", lambda arrival: None)
    assert attempts == ["/a", "/a"]
