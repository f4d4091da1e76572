"""Bridges that make a circle: two masters, each with a bridge to the same ROS 2, and a bridge between the masters."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("zenoh")

from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.runner import Bridge
from pyros1.bridge.transport.zenoh_link import ZenohLink

from ...bridge.conftest import QueuedSubscriber, wait_until
from .test_running import Ros2Peer, RunningBridge, endpoint, key, string

__all__ = ["endpoint"]


def join(bridge: RunningBridge, site: str, other: str, **where: Any) -> None:
    """Add a bridge to the other master, which exchanges a topic without a prefix."""
    text = f"{{send: [/chatter], take: ['{other}:**'], prefix: {{{other}: /}}}}"
    rules = parse_config(text, "rules.yaml", site).rules
    Bridge(bridge.make_node(f"bridge_{site}"), rules, lambda receive: ZenohLink(site, receive, **where))


@pytest.fixture
def site_endpoint(free_port: int) -> str:
    return f"tcp/127.0.0.1:{free_port}"


@pytest.mark.slow
def test_no_message_goes_round(endpoint: str, site_endpoint: str, tmp_path: Path) -> None:
    one = RunningBridge(tmp_path, name="one", listen=[endpoint])
    two = RunningBridge(tmp_path, name="two", connect=[endpoint])
    peer = Ros2Peer(endpoint)
    try:
        join(one, "one", "two", listen=[site_endpoint])
        join(two, "two", "one", connect=[site_endpoint])
        heard = [QueuedSubscriber(each.node, "/chatter") for each in (one, two)]
        peer.subscribe(key("/chatter"))
        publisher: Any = one.node.advertise("/chatter", "std_msgs/String", queue_size=10)
        one.subscribes(publisher, "/bridge_ros2", "/bridge_one")
        problem = "/bridge_two also publishes it in ROS 1, so its messages may arrive twice"
        wait_until(lambda: two.status()["problems"].get("/chatter") == problem, "the second bridge says so")
        peer.publish(key("/chatter"))
        wait_until(lambda: len(peer.graph.topic("/chatter").subscribers) == 2, "both take what ROS 2 has")
        assert {each.node_name for each in peer.graph.topic("/chatter").publishers} == {"one"}

        def number_of(text: str, subscriber: QueuedSubscriber) -> None:
            while True:
                data = subscriber.get().data
                counts[subscriber][data] += 1
                if data == text:
                    return

        counts: dict[QueuedSubscriber, Counter[str]] = {each: Counter() for each in heard}
        for text in ("first", "second"):
            publisher.publish(text)
        number_of("second", heard[0])
        for _ in range(2):
            number_of("second", heard[1])  # it comes on both ways
        peer.send(key("/chatter"), string("from ROS 2"))
        for each in heard:
            number_of("from ROS 2", each)
        publisher.publish("end")
        number_of("end", heard[0])
        for _ in range(2):
            number_of("end", heard[1])
        assert counts[heard[0]] == {"first": 1, "second": 1, "from ROS 2": 1, "end": 1}
        assert counts[heard[1]] == {"first": 2, "second": 2, "from ROS 2": 1, "end": 2}
        assert [peer.get()[1] for _ in range(3)] == [string(text) for text in ("first", "second", "end")]
        assert peer.messages.empty() and all(each.is_silent() for each in heard)
    finally:
        peer.session.close()
        two.close()
        one.close()
