"""Topics whose frames and nodes get a prefix when they are taken, in a site's machine."""

from __future__ import annotations

import json
from typing import Any

import pytest
from tests.bodies import decode, encode

from pyros1.bridge.exchange.actions import Action, Forget, Publish, Source
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol import packets
from pyros1.bridge.protocol.key_expressions import Channel, Key
from pyros1.bridge.protocol.packets import Definition, Flag, Heartbeat, Kind, MessageHead
from pyros1.bridge.rules.parsing import parse_config
from pyros1.msgs import load_message
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.std_msgs.msg import Header

LOG: Any = load_message("rosgraph_msgs/Log")
TF: Any = load_message("tf2_msgs/TFMessage")
POINT: Any = load_message("geometry_msgs/PointStamped")


class Taking:
    """A base that takes topics of red, whose packets the test writes."""

    def __init__(self, rules: str) -> None:
        self.site = Site(parse_config(rules, "f", "base").rules, 11, 0.0)
        self.now = 0.0
        self.version = 0
        for number in (1, 2):
            body = packets.encode_heartbeat(Heartbeat(number, 0.0, number - 1, 0.0, 0, 1, 99, 99, {}))
            self.control(Kind.HEARTBEAT, body)

    def control(self, kind: Kind, body: bytes) -> list[Action]:
        head = packets.encode_head(kind, 22, 11)
        return self.site.on_packet(Key("red", Channel.TO, "base"), head, body, self.now)

    def offer(self, name: str, cls: Any, local: str, *, latched: bool = False, text: str | None = None) -> None:
        self.version += 1
        row = [f"red:{name}", cls._type, cls._md5sum, latched, False, ["/driver"]]
        self.control(Kind.OFFER, json.dumps([self.version, 0, 1, [row]]).encode())
        text = cls._full_text if text is None else text
        self.control(Kind.DEFINITION, packets.encode_definition(Definition(cls._type, cls._md5sum, text)))
        self.site.set_subscribed([local], self.now)
        self.now += 0.5

    def packet(self, name: str, cls: Any, body: bytes, number: int = 1, flags: int = 0) -> list[Action]:
        head = packets.encode_message_head(MessageHead(22, 0, number, 1, self.now, flags, cls._md5sum))
        key = Key("red", Channel.TOPIC, "", SharedName("red", name))
        return self.site.on_packet(key, head, body, self.now)

    def message(self, name: str, cls: Any, body: bytes, number: int = 1, flags: int = 0) -> list[Publish]:
        return [each for each in self.packet(name, cls, body, number, flags) if isinstance(each, Publish)]


def test_frames_of_topics_that_are_taken() -> None:
    taking = Taking("take: [{topic: 'red:**', prefix_frames: red, keep_frames: [map]}]")
    for frame, expected in (("base_link", "red/base_link"), ("map", "map")):
        taking.offer("/point", POINT, "/red/point")
        body = encode(POINT(header=Header(frame_id=frame)))
        (publish,) = taking.message("/point", POINT, body, taking.version)
        assert decode(POINT, publish.body).header.frame_id == expected


def test_latched_frames() -> None:
    taking = Taking("take: [{topic: 'red:/tf_static', here: /tf_static, prefix_frames: red}]")
    taking.offer("/tf_static", TF, "/tf_static", latched=True)
    body = encode(TF([load_message("geometry_msgs/TransformStamped")(child_frame_id="laser")]))
    (publish,) = taking.message("/tf_static", TF, body, flags=Flag.LATCHED)
    assert publish.local == "/tf_static" and publish.latched
    assert decode(TF, publish.body).transforms[0].child_frame_id == "red/laser"


def test_messages_that_are_damaged_are_dropped() -> None:
    taking = Taking("take: [{topic: 'red:**', prefix_frames: red}]")
    taking.offer("/point", POINT, "/red/point")
    assert taking.message("/point", POINT, b"short") == []
    (received,) = taking.site.received_topics()
    assert received.flow.drops == {DropReason.DAMAGED: 1} and received.flow.messages == 0


def test_latched_frames_do_not_stay_if_the_next_message_is_damaged() -> None:
    taking = Taking("take: [{topic: 'red:/tf_static', here: /tf_static, prefix_frames: red}]")
    taking.offer("/tf_static", TF, "/tf_static", latched=True)
    taking.message("/tf_static", TF, encode(TF()), flags=Flag.LATCHED)
    forget = Forget("/tf_static", Source("red", SharedName("red", "/tf_static"), 1))
    assert forget in taking.packet("/tf_static", TF, b"short", 2, Flag.LATCHED)


def test_a_topic_without_definition_is_refused_if_its_frames_need_a_prefix() -> None:
    taking = Taking("take: [{topic: 'red:**', prefix_frames: red}]")
    taking.offer("/point", POINT, "/red/point", text="")
    (received,) = taking.site.received_topics()
    assert received.state == "prefixes cannot be added: the definition of its type is not known"
    assert taking.message("/point", POINT, encode(POINT())) == []


@pytest.mark.parametrize(("prefix", "name"), [("", "/red/driver"), ("prefix: {red: /}", "/driver")])
def test_nodes_in_logs_appear_as_topics_do(prefix: str, name: str) -> None:
    taking = Taking(f"take: [{{topic: 'red:/rosout', here: /rosout_agg}}]\n{prefix}")
    taking.offer("/rosout", LOG, "/rosout_agg")
    (publish,) = taking.message("/rosout", LOG, encode(Log(name="/driver", msg="hot")))
    log = decode(LOG, publish.body)
    assert (publish.local, log.name, log.msg) == ("/rosout_agg", name, "hot")
