"""The log of ROS 2's nodes in ROS 1, through a running bridge.

Feature: ROS 2's log in `pyros1 console` and rosout_agg -- `pyros1 bridge ros2`
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from itertools import count
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("zenoh")

from pyros1.node.log.rosout import RosoutAggregator
from pyros1.ros2.bridge.rules import Ros2Rules
from pyros1.ros2.zenoh.qos import Qos

from ...bridge.conftest import QueuedSubscriber, wait_until
from .test_running import Ros2Peer, RunningBridge, endpoint, key

__all__ = ["endpoint"]

LOG = key("/rosout", "rcl_interfaces/msg/Log")
LOG_QOS = Qos(transient_local=True, depth=1000)


def log(text: str, level: int = 40) -> bytes:
    """Return a rcl_interfaces/msg/Log as CDR."""
    data = bytearray(struct.pack("<iIB", 5, 6, level))
    for part in ("talker", text, "talker.cpp", "main"):
        data += bytes(-len(data) % 4) + struct.pack("<I", len(part) + 1) + part.encode() + b"\0"
    return b"\0\1\0\0" + bytes(data + bytes(-len(data) % 4) + struct.pack("<I", 42))


class LogReader(QueuedSubscriber):
    """A node's log as it comes on a topic."""

    def __init__(self, bridge: RunningBridge, topic: str) -> None:
        super().__init__(bridge.make_node("reader"), topic, "rosgraph_msgs/Log")

    def get_of(self, name: str) -> Any:
        """Return the next message of a node; others may come before."""
        while (message := self.get()).name != name:
            pass
        return message

    def texts_of(self, name: str) -> list[str]:
        """Return the texts that have arrived from a node since the last call."""
        messages = []
        while not self.is_silent():
            messages.append(self.get())
        return [message.msg for message in messages if message.name == name]


@pytest.fixture
def bridge(endpoint: str, tmp_path: Path) -> Iterator[RunningBridge]:
    running = RunningBridge(tmp_path, Ros2Rules(["/rosout"], ["/**"]), listen=[endpoint])
    yield running
    running.close()


@pytest.fixture
def peer(bridge: RunningBridge, endpoint: str) -> Iterator[Ros2Peer]:
    peer = Ros2Peer(endpoint)
    yield peer
    peer.session.close()


def test_the_log_of_ros2_is_collected_by_rosout(bridge: RunningBridge, peer: Ros2Peer) -> None:
    RosoutAggregator(bridge.make_node("rosout"), None)
    reader = LogReader(bridge, "/rosout_agg")
    peer.publish(LOG, LOG_QOS)
    peer.is_subscribed_by("/rosout")
    peer.send(LOG, log("it burns"))
    message = reader.get_of("talker")
    assert (message.level, message.msg, message.file, message.function, message.line, message.topics) == (
        message.ERROR,
        "it burns",
        "talker.cpp",
        "main",
        42,
        [],
    )
    assert (message.header.stamp.secs, message.header.stamp.nsecs) == (5, 6)


def test_logs_both_ways_make_no_loop(bridge: RunningBridge, peer: Ros2Peer, endpoint: str) -> None:
    other = bridge.make_bridge("bridge_two", "bridge", Ros2Rules(["/rosout"], ["/**"]), connect=[endpoint])
    listener = Ros2Peer(endpoint)
    got: list[str] = []
    texts: list[str] = []

    def copies(text: str) -> int:
        while not listener.messages.empty():
            got.append(listener.messages.get()[1].decode("latin-1"))
        return sum(text in each for each in got)

    try:
        listener.subscribe(LOG)
        peer.publish(LOG, LOG_QOS)
        peer.is_subscribed_by("/rosout")
        node, reader = bridge.make_node("driver"), LogReader(bridge, "/rosout")
        numbers = count()

        def both_send() -> bool:
            node.log.warn("number %d.", number := next(numbers))
            return any(copies(f"number {each}.") == 2 for each in range(number + 1))

        wait_until(both_send, "both bridges send the log of ROS 1")

        def both_publish() -> bool:
            peer.send(LOG, log(f"of ROS 2: {next(numbers)}."))
            texts.extend(reader.texts_of("talker"))
            return any(texts.count(text) == 2 for text in texts)

        wait_until(both_publish, "both bridges publish the log of ROS 2")
        node.log.warn("the end")
        wait_until(lambda: copies("the end") == 2 and all(copies(text) for text in texts), "all arrive")
        assert {copies(text) for text in texts} == {1}, "only by its publisher"
        assert all("\x1e" in each[:16] for each in got if "the end" in each), "30 is a warning in ROS 2"
    finally:
        listener.session.close()
        other.close()
