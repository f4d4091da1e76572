"""When a bridge advertises what it takes from ROS 2."""

from __future__ import annotations

from typing import Any
from unittest.mock import Mock

import pytest

from pyros1.bridge.deferred import RETURN_DELAY
from pyros1.bridge.exchange.actions import Advertise
from pyros1.ground.errors import NodeError
from pyros1.ros2.bridge.counts import Counts
from pyros1.ros2.bridge.incoming import IncomingMessages
from pyros1.ros2.bridge.plan import Plan, TakenTopic
from pyros1.ros2.pairs.type_pairs import TypePair


class BridgePublishers:
    """Notes what is advertised and withdrawn."""

    def __init__(self) -> None:
        self.done: list[tuple[str, str]] = []
        self.refuses = False

    def advertise(self, action: Advertise) -> None:
        if self.refuses:
            raise NodeError("no")
        self.done.append((action.local, f"{action.type} latched" if action.latched else action.type))

    def withdraw(self, local: str) -> None:
        self.done.append((local, ""))


class Bridge:
    """An `IncomingMessages` whose time the test sets."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        self.publishing = BridgePublishers()
        fake: Any = self.publishing
        self.incoming = IncomingMessages(fake, Counts(), Mock())
        monkeypatch.setattr("pyros1.ros2.bridge.incoming.steady_now", lambda: self.now)

    def adjust(self, **types: str) -> list[tuple[str, str]]:
        """Take topics of these types; return what was done for that, and what could not be done."""
        transcoder: Any = None
        plan = Plan()
        for topic, text in types.items():
            name, _, latched = text.partition(" ")
            pair = TypePair(name, f"md5 of {name}", "", name, "", transcoder)
            plan.takes[f"/{topic}"] = TakenTopic(pair, latched=bool(latched), publishers=["/far"])
        problems: dict[str, str] = {}
        self.publishing.done = []
        self.incoming.adjust(plan, problems)
        return [*self.publishing.done, *problems.items()]


@pytest.fixture
def bridge(monkeypatch: pytest.MonkeyPatch) -> Bridge:
    return Bridge(monkeypatch)


def test_another_type_is_advertised_a_moment_later(bridge: Bridge) -> None:
    assert bridge.adjust(a="p/A", b="p/A") == [("/a", "p/A"), ("/b", "p/A")]
    assert bridge.adjust(a="p/A", b="p/A") == []
    assert bridge.adjust(a="p/B", b="p/A") == [("/a", "")]
    bridge.now += RETURN_DELAY / 2
    assert bridge.adjust(a="p/B", b="p/A") == []
    bridge.now += RETURN_DELAY / 2
    assert bridge.adjust(a="p/B", b="p/A") == [("/a", "p/B")]


def test_a_topic_that_returns(bridge: Bridge) -> None:
    bridge.adjust(a="p/A")
    assert bridge.adjust() == [("/a", "")]
    assert bridge.adjust(a="p/A") == []
    bridge.now += RETURN_DELAY
    assert bridge.adjust(a="p/A") == [("/a", "p/A")]


def test_a_topic_that_becomes_latched_keeps_its_subscribers(bridge: Bridge) -> None:
    bridge.adjust(a="p/A")
    assert bridge.adjust(a="p/A latched") == [("/a", "p/A latched")]
    assert bridge.adjust(a="p/A") == [] and bridge.adjust(a="p/A latched") == [], "it stays so"


def test_what_is_refused_is_tried_again(bridge: Bridge) -> None:
    bridge.publishing.refuses = True
    assert bridge.adjust(a="p/A") == [("/a", "no")]
    bridge.publishing.refuses = False
    assert bridge.adjust(a="p/A") == [("/a", "p/A")]
