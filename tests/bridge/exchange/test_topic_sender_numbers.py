"""The numbers of messages of topics that come and go, in a site's machine: no number is used twice."""

from __future__ import annotations

import pytest

from pyros1.bridge.exchange import topic_sender as module
from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.exchange.outgoing import ReceivedMessage
from pyros1.bridge.exchange.topic_sender import LocalTopic, TopicSender
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packets import Request, decode_message_head
from pyros1.bridge.rules.parsing import parse_config

MD5 = "a" * 32
LIGHT = LocalTopic("/light", "std_msgs/String", MD5, "string data\n", False, ("/button",))


@pytest.fixture
def sender(monkeypatch: pytest.MonkeyPatch) -> TopicSender:
    """The sender of a site that sends a topic to any site under that site's name, and remembers two numbers."""
    monkeypatch.setattr(module, "MAX_ENDED_TOPICS", 2)
    sender = TopicSender(parse_config("send: [{topic: '*:/light', here: /light}]", "f", "base").rules, 11)
    sender.set_topics([LIGHT], 0.0, 0.0)
    return sender


def numbers(sender: TopicSender, site: str, count: int) -> list[int]:
    """Return the numbers of so many messages for a site, which comes and goes."""
    sender.set_peers({site: 22}, 0.0)
    sender.set_requests(site, [Request(SharedName(site, "/light"), 0.0)], 0.0)
    message = ReceivedMessage("/button", MD5, False, b"on")
    actions = [action for _ in range(count) for action in sender.on_message("/light", message, False, 0.0)]
    sender.set_peers({}, 0.0)
    return [decode_message_head(action.head).number for action in actions if isinstance(action, Send)]


def test_numbering_continues(sender: TopicSender) -> None:
    assert numbers(sender, "red", 3) == [1, 2, 3]
    for number in range(9):
        assert numbers(sender, f"silent{number}", 0) == []
    assert numbers(sender, "red", 2) == [4, 5], "sites without messages take no room"
    assert numbers(sender, "blue", 1) == [1]


def test_numbering_after_too_many_topics(sender: TopicSender) -> None:
    for site, count in (("s0", 1), ("s1", 4), ("s2", 1)):
        assert numbers(sender, site, count) == [*range(1, count + 1)]
    assert numbers(sender, "s3", 2) == [2, 3], "above the number of s0, which is forgotten: this may be s0"
    assert numbers(sender, "s2", 1) == [2]
    for site in ("s4", "s0", "s1"):
        assert numbers(sender, site, 1) == [5], "above all that are forgotten"
