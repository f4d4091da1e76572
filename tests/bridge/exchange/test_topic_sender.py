"""Topics that are sent, in a site's machine."""

from __future__ import annotations

import pytest

from pyros1.bridge.exchange.actions import Action, Send
from pyros1.bridge.exchange.outgoing import DropReason, ReceivedMessage
from pyros1.bridge.exchange.topic_sender import LocalTopic, TopicSender
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packets import Flag, Request, decode_message_head
from pyros1.bridge.rules.parsing import parse_config

MAP = SharedName("red", "/map")
MD5 = "a" * 32


def sending(rules: str, *topics: LocalTopic) -> TopicSender:
    machine = TopicSender(parse_config(rules, "f", "red").rules, 11)
    machine.set_peers({"base": 22, "blue": 33}, 0.0)
    machine.set_topics(topics, 0.0, 0.0)
    return machine


def latching(name: str, type_name: str = "nav_msgs/OccupancyGrid") -> LocalTopic:
    return LocalTopic(name, type_name, MD5, "", True, ("/server",))


def message(body: bytes = b"x", md5sum: str = MD5) -> ReceivedMessage:
    return ReceivedMessage("/server", md5sum, True, body)


def sends(actions: list[Action]) -> list[Send]:
    return [action for action in actions if isinstance(action, Send)]


@pytest.mark.parametrize(
    ("bad", "reason"), [(message(bytes(11)), DropReason.SIZE), (message(md5sum="b" * 32), DropReason.TYPE)]
)
def test_a_latched_message_does_not_stay_if_the_next_one_cannot_be_sent(bad: ReceivedMessage, reason: str) -> None:
    """Later subscribers must not get an old map as the current one."""
    machine = sending("send: [{topic: /map, size: 10}]", latching("/map"))
    machine.set_requests("base", [Request(MAP, 0.0)], 0.0)
    machine.on_message("/map", message(b"old"), False, 1.0)
    (note,) = sends(machine.on_message("/map", bad, False, 2.0))
    assert decode_message_head(note.head).flags == Flag.LEFT and note.body == b""
    ((_, _, flow),) = machine.flows()
    assert flow.drops == {reason: 1}
    assert sends(machine.on_message("/map", bad, False, 3.0)) == []
    later = sends(machine.set_requests("blue", [Request(MAP, 0.0)], 4.0))
    assert [each.key for each in later] == ["to/blue"], "there is only the list of latched messages, which is empty"
    (sent,) = sends(machine.on_message("/map", message(b"new"), False, 5.0))
    assert decode_message_head(sent.head).flags == Flag.LATCHED
