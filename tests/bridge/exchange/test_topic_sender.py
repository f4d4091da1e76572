"""Topics that are sent, in a site's machine."""

from __future__ import annotations

import pytest

from pyros1.bridge.exchange.actions import Action, Send, Subscribe
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


GOAL = "move_base_msgs/MoveBaseActionGoal"


def request(machine: TopicSender, site: str, *topics: SharedName) -> list[Subscribe]:
    actions = machine.set_requests(site, [Request(topic, 0.0) for topic in topics], 0.0)
    return [action for action in actions if isinstance(action, Subscribe)]


def test_a_goal_is_not_sent_again_when_a_site_has_returned() -> None:
    """Its publisher still latches it, so the bridge gets it again when it subscribes again."""
    goal = SharedName("base", "/goal")
    machine = sending("send: ['base:/goal']", latching("/base/goal", GOAL))
    assert request(machine, "base", goal) == [Subscribe("/base/goal", True)]
    assert len(sends(machine.on_message("/base/goal", message(b"1"), False, 1.0))) == 1
    machine.set_peers({}, 2.0)
    machine.set_peers({"base": 23}, 3.0)
    assert request(machine, "base", goal) == [Subscribe("/base/goal", True)]
    assert sends(machine.on_message("/base/goal", message(b"1"), False, 4.0)) == []
    ((_, _, flow),) = machine.flows()
    assert flow.drops == {DropReason.REPEATED: 1}
    assert len(sends(machine.on_message("/base/goal", message(b"1"), False, 5.0))) == 1, "it was published again"


def test_what_is_published_for_two_sites_is_not_a_repetition() -> None:
    goals = [SharedName(site, "/goal") for site in ("base", "blue")]
    machine = sending("send: [{topic: '*:/goal', here: /goal}]", latching("/goal", GOAL))
    assert request(machine, "base", goals[0]) == [Subscribe("/goal", True)]
    machine.on_message("/goal", message(b"1"), False, 1.0)
    assert request(machine, "blue", goals[1]) == [], "the bridge goes on receiving, and nothing comes again"
    assert len(sends(machine.on_message("/goal", message(b"2"), False, 2.0))) == 2
    assert request(machine, "blue") == [] and request(machine, "blue", goals[1]) == []
    assert len(sends(machine.on_message("/goal", message(b"3"), False, 3.0))) == 2


def test_a_map_is_sent_again() -> None:
    machine = sending("send: [/map]", latching("/map"))
    for now in (1.0, 2.0):
        assert request(machine, "base", MAP) == [Subscribe("/map", True)]
        (sent,) = sends(machine.on_message("/map", message(b"map"), False, now))
        assert sent.body == b"map" and decode_message_head(sent.head).flags == Flag.LATCHED
        assert request(machine, "base") == [Subscribe("/map", False)]


@pytest.mark.parametrize("is_registered", [True, False])
def test_another_node_of_the_same_name_repeats_nothing(is_registered: bool) -> None:
    """A node that merely hangs is no longer offered, but still registered."""
    goal = SharedName("base", "/goal")
    machine = sending("send: ['base:/goal']", latching("/base/goal", GOAL))
    request(machine, "base", goal)
    machine.on_message("/base/goal", message(b"1"), False, 1.0)
    machine.set_topics([], 2.0, 2.0)
    machine.set_registered({"/base/goal": ["/server"]} if is_registered else {}, 2.0)
    machine.set_topics([latching("/base/goal", GOAL)], 3.0, 3.0)
    sent = sends(machine.on_message("/base/goal", message(b"1"), False, 4.0))
    assert len(sent) == (0 if is_registered else 1)
