"""A running bridge to ROS 2 whose other side does much, or changes its mind at a bad moment."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("zenoh")

from pyros1.bridge.bridge_publishers import BridgePublishers
from pyros1.bridge.exchange.actions import Advertise
from pyros1.bridge.local_graph import LocalGraph
from pyros1.ros2.bridge import runner
from pyros1.ros2.bridge.plan import Plan
from pyros1.ros2.zenoh.attachments import Attachment, encode_attachment
from pyros1.ros2.zenoh.names import DataKey
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2.zenoh.tokens import Entity, Kind, encode_token

from ...bridge.conftest import QueuedSubscriber, wait_until
from .test_running import RunningBridge, endpoint, key, string

__all__ = ["endpoint"]

ATTACHMENT = encode_attachment(Attachment(1, 1, bytes(16)))


@pytest.fixture
def bridge(endpoint: str, tmp_path: Path) -> Iterator[RunningBridge]:
    running = RunningBridge(tmp_path, listen=[endpoint])
    yield running
    running.close()


def token(number: int, of: DataKey, latched: bool = False) -> str:
    """Return the token of a publisher in ROS 2."""
    qos = Qos(transient_local=latched)
    return encode_token(
        Entity(0, "ab", 0, number, Kind.PUBLISHER, "far", topic=of.name, type=of.type, hash=of.hash, qos=qos)
    )


def count_calls(monkeypatch: pytest.MonkeyPatch, owner: Any, name: str) -> list[float]:
    """Return a list to which the time of each call of a function is added."""
    original, times = getattr(owner, name), []

    def counted(*args: Any) -> Any:
        times.append(time.monotonic())
        return original(*args)

    monkeypatch.setattr(owner, name, counted)
    return times


def test_nothing_is_planned_while_nothing_changes(bridge: RunningBridge, monkeypatch: pytest.MonkeyPatch) -> None:
    bridge.node.advertise("/ours", "std_msgs/String", queue_size=1)
    bridge.on_token(token(1, key("/theirs")), True)
    wait_until(lambda: bridge.status()["sent"] and "/theirs" in bridge.topics(), "all is planned")
    monkeypatch.setattr(runner, "ADJUST_PERIOD", 0.01)
    polls = count_calls(monkeypatch, LocalGraph, "topics")
    wait_until(lambda: len(polls) >= 2, "what was on the way is done")
    plans = count_calls(monkeypatch, runner, "make_plan")
    wait_until(lambda: len(polls) >= 6, "the master is asked again and again")
    assert not plans
    bridge.on_token(token(1, key("/theirs")), False)
    wait_until(lambda: "/theirs" not in bridge.topics(), "a change is noticed")


@pytest.mark.slow
def test_those_who_come_and_go_do_not_take_all_the_time(bridge: RunningBridge, monkeypatch: pytest.MonkeyPatch) -> None:
    times: list[tuple[float, float]] = []

    def make_plan(*args: Any) -> Plan:
        start = time.monotonic()
        end = time.thread_time() + 0.02
        while time.thread_time() < end:
            pass
        times.append((start, time.monotonic()))
        return Plan()

    monkeypatch.setattr(runner, "make_plan", make_plan)
    numbers = iter(range(1_000_000))

    def flap() -> bool:
        bridge.on_token(token(next(numbers), key("/theirs")), True)
        return len(times) >= 6

    wait_until(flap, "the bridge has planned some times")
    pauses = [later[0] - earlier[1] for earlier, later in pairwise(times)]
    assert min(pauses) >= 0.05


def test_a_message_of_a_type_that_ends_is_not_published_as_the_next_type(
    bridge: RunningBridge, monkeypatch: pytest.MonkeyPatch
) -> None:
    old, new = key("/theirs"), key("/theirs", "std_msgs/msg/Header")
    bridge.on_token(token(1, old), True)
    wait_until(lambda: bridge.topics().get("/theirs") == "std_msgs/String", "it has the first type")
    advertise, published = BridgePublishers.advertise, []
    monkeypatch.setattr(BridgePublishers, "publish", lambda self, action: published.append(action))

    def advertise_and_take(self: BridgePublishers, action: Advertise) -> None:
        advertise(self, action)
        bridge.on_message(old, string("late"), ATTACHMENT)

    monkeypatch.setattr(BridgePublishers, "advertise", advertise_and_take)
    bridge.on_token(token(1, old), False)
    bridge.on_token(token(2, new), True)
    wait_until(lambda: bridge.topics().get("/theirs") == "std_msgs/Header", "it has the second type")
    (row,) = (each for each in bridge.status()["received"] if each["local"] == "/theirs")
    wait_until(lambda: bridge.status()["received"][0]["dropped"], "the late message is counted")
    assert row["type"] == "std_msgs/Header" and not published


def test_publishers_are_told_apart_where_messages_are_latched(
    bridge: RunningBridge, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.ros2.bridge.sources.MAX_SOURCES", 3)
    for number, name in enumerate(("/plain", "/latched")):
        bridge.on_token(token(number, key(name), latched=number == 1), True)
    wait_until(lambda: {"/plain", "/latched"} <= bridge.topics().keys(), "they are published")
    sent, asked = iter(range(1, 100)), [0]

    def send(name: str, publisher: int, text: str) -> None:
        gid = publisher.to_bytes(16, "little")
        bridge.on_message(key(name), string(text), encode_attachment(Attachment(next(sent), 1, gid)))

    def are_kept(*texts: str) -> None:
        total = next(sent) - 1 - asked.pop()
        asked.append(1)
        wait_until(lambda: sum(each["messages"] for each in bridge.status()["received"]) >= total, "all are published")
        subscriber = QueuedSubscriber(bridge.make_node(f"late{total}"), "/latched")
        assert {subscriber.get().data for _ in texts} == {*texts} and subscriber.is_silent()

    for number in range(10):
        send("/plain", number, "plain")
    send("/latched", 1, "one")
    send("/latched", 2, "two")
    are_kept("one", "two")
    send("/latched", 1, "one again")
    send("/latched", 3, "three")
    send("/latched", 4, "four")
    are_kept("one again", "three", "four")
