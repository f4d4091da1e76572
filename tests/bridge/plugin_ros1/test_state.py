"""The state of a bridge: what is sent and published, and what is not."""

from __future__ import annotations

from typing import Any

from pyros1.bridge.exchange.outgoing import DropReason, ReceivedMessage
from pyros1.bridge.plugin_ros1.beacons import LOSS_TIME
from pyros1.bridge.plugin_ros1.keys import Kind, Resource
from pyros1.bridge.plugin_ros1.state import UNKNOWN, PluginState
from pyros1.bridge.rules.rules import Priority

from .test_keys import BEACON, MD5
from .test_plan import topic
from .test_rules import rules

KEY = f"7374645f6d7367732f537472696e67/{MD5}/*/chatter"


def state(namespace: str = "", **words: Any) -> PluginState:
    return PluginState(rules(namespace, **words), lambda: 0.0)


def received(body: bytes = b"text", publisher: str = "/talker", md5sum: str = MD5) -> ReceivedMessage:
    return ReceivedMessage(publisher, md5sum, False, body)


def beacons(bridge: PluginState, now: float) -> list[str]:
    """Return the keys of the beacons to send."""
    packets = bridge.tick(now)
    assert all((each.priority, each.expires, each.body) == (Priority.HIGH, now + 1.0, b"") for each in packets)
    return [each.key for each in packets]


def sending(*words: str, wanted: bool = True) -> PluginState:
    bridge = state(send=" ".join(words))
    bridge.set_local([topic("/chatter")], [], 1.0)
    if wanted:
        bridge.wanted = frozenset(bridge.plan.sends)
    return bridge


def test_a_topic_is_announced_and_sent_to_who_receives_it() -> None:
    bridge = sending("/chatter", wanted=False)
    assert beacons(bridge, 1.0) == [BEACON]
    assert bridge.on_message("/chatter", received(), False, 1.0) == []
    bridge.wanted = frozenset(bridge.plan.sends)
    (packet,) = bridge.on_message("/chatter", received(), False, 1.0)
    assert (packet.key, packet.head, packet.body, packet.priority) == (KEY, b"", b"text", Priority.NORMAL)
    assert packet.expires == 3.0 and packet.may_drop and packet.replaces is not None
    (other,) = bridge.on_message("/chatter", received(publisher="/other"), False, 1.0)
    assert other.replaces != packet.replaces
    (flow,) = bridge.sent.values()
    assert (flow.messages, flow.bytes, flow.drops) == (2, 8, {})


def test_what_is_not_sent() -> None:
    bridge = sending("/chatter@2")
    for message, is_bridged in (
        (received(), True),
        (received(md5sum="0" * 32), False),
        (received(b"x" * (17 << 20)), False),
        (received(), False),
        (received(), False),
    ):
        bridge.on_message("/chatter", message, is_bridged, 1.0)
    (flow,) = bridge.sent.values()
    assert flow.messages == 1 and flow.drops == {
        DropReason.BRIDGED: 1,
        DropReason.TYPE: 1,
        DropReason.SIZE: 1,
        DropReason.RATE: 1,
    }
    assert bridge.on_message("/chatter", received(publisher="/other"), False, 1.0)
    assert bridge.on_message("/chatter", received(), False, 1.46), "nearly due"
    assert not bridge.on_message("/chatter", received(), False, 1.9) and bridge.on_message(
        "/chatter", received(), False, 2.0
    )
    assert bridge.on_message("/unknown", received(), False, 3.0) == []


def test_a_rate_holds_on_average() -> None:
    bridge = sending("/chatter@2")
    sent = sum(len(bridge.on_message("/chatter", received(), False, 1.0 + number * 0.3)) for number in range(100))
    assert sent == 60


def test_a_topic_is_taken_while_its_beacons_come() -> None:
    bridge = state(take="/chatter")
    assert bridge.on_sample(KEY, b"early", 1.0) is None and bridge.ignored == {UNKNOWN: 1}
    bridge.on_beacon(BEACON, 1.0)
    published = bridge.on_sample(KEY, b"text", 1.0)
    assert published is not None
    assert (published.local, published.body, published.latched) == ("/chatter", b"text", False)
    assert bridge.taken["/chatter"].messages == 1
    assert bridge.tick(2.0) == [], "nobody here subscribes"
    bridge.set_subscribed({"/chatter"}, 2.0)
    assert beacons(bridge, 2.0) == [BEACON.replace("pub", "sub")]
    bridge.tick(1.1 + LOSS_TIME)
    assert bridge.plan.takes == {} and bridge.on_sample(KEY, b"late", 5.0) is None
    assert bridge.tick(10.0) == []


def test_limits_of_what_is_taken() -> None:
    bridge = state(take="/chatter@2")
    bridge.on_beacon(BEACON, 1.0)
    assert bridge.on_sample(KEY, b"x" * (17 << 20), 1.0) is None
    assert bridge.on_sample(KEY, b"1", 1.0) and not bridge.on_sample(KEY, b"2", 1.1)
    assert bridge.taken["/chatter"].drops == {DropReason.SIZE: 1, DropReason.RATE: 1}


def test_counts_stay_while_other_things_change() -> None:
    bridge = sending("/chatter", "/other")
    bridge.on_message("/chatter", received(), False, 1.0)
    plan = bridge.plan
    bridge.set_local([topic("/chatter")], [], 2.0)
    assert bridge.plan is plan, "nothing has changed"
    bridge.set_local([topic("/chatter"), topic("/other")], [], 2.0)
    assert [flow.messages for flow in bridge.sent.values()] == [1, 0]
    bridge.set_local([], [], 2.0)
    assert bridge.sent == {} and bridge.tick(2.0) == []


def test_bridges_that_announce_the_same_take_turns() -> None:
    bridge = sending("/chatter")
    assert beacons(bridge, 1.0) == [BEACON]
    bridge.on_beacon(BEACON, 1.5)
    assert bridge.tick(2.0) == [] and bridge.plan.takes == {}


def test_old_keys() -> None:
    bridge = state(take="/chatter")
    resource = Resource(Kind.PUBLISHER, "std_msgs/String", MD5, "*", "/chatter")
    assert bridge.key(resource) == KEY
    old = PluginState(type(bridge.rules)(bridge.rules.topics, bridge.rules.services, True), lambda: 0.0)
    old.on_beacon(BEACON, 1.0)
    assert old.key(resource) == f"7374645f6d7367732f537472696e67/{MD5}/chatter"
    assert old.on_sample(old.key(resource), b"text", 1.0) is not None


def test_not_each_of_many_beacons_makes_a_plan() -> None:
    """It would take minutes for thousands of them."""
    bridge = state(take="/**")
    plans = set()
    for number in range(200):
        bridge.on_beacon(BEACON.replace("chatter", f"chatter{number}"), 1.0)
        plans.add(id(bridge.plan))
    assert len(plans) < 50 and len(bridge.plan.takes) < 200
    bridge.tick(1.5)
    assert len(bridge.plan.takes) == 200
