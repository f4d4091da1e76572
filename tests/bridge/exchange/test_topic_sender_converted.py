"""Topics that are converted before they are sent, in a site's machine."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.bridge.conversions.conversion import Conversion, MessageType
from pyros1.bridge.exchange.actions import Action, RestartConversion, Send, Subscribe
from pyros1.bridge.exchange.outgoing import DropReason, ReceivedMessage
from pyros1.bridge.exchange.topic_sender import LocalTopic, TopicSender
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packets import Flag, OfferedTopic, Request, Tail, decode_message_head
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Priority

JPEG, H264 = Conversion("jpeg", 80.0), Conversion("h264", 2e6)
JPEG_TYPE = MessageType("sensor_msgs/CompressedImage", "c" * 32, "string format\n")
VIDEO_TYPE = MessageType("foxglove_msgs/CompressedVideo", "e" * 32, "string format\n")
COMPRESSED = SharedName("red", "/camera/compressed")
CAMERA = LocalTopic(
    "/camera", "sensor_msgs/Image", "a" * 32, "string encoding\n", False, ("/driver",),
    ((JPEG, JPEG_TYPE), (H264, VIDEO_TYPE)),
)  # fmt: skip


def sending(rules: str, *topics: LocalTopic) -> TopicSender:
    machine = TopicSender(parse_config(rules, "f", "red").rules, 11)
    machine.set_peers({"base": 22, "blue": 33}, 0.0)
    machine.set_topics(topics, 0.0, 0.0)
    return machine


def converted(body: bytes = b"jpeg", md5sum: str = JPEG_TYPE.md5sum, latched: bool = False) -> ReceivedMessage:
    return ReceivedMessage("/driver", md5sum, latched, body)


def raw(latched: bool = False) -> ReceivedMessage:
    return ReceivedMessage("/driver", CAMERA.md5sum, latched, b"raw")


def sends(actions: list[Action]) -> list[Send]:
    return [action for action in actions if isinstance(action, Send)]


def drops(machine: TopicSender) -> dict[str, int]:
    ((_, _, flow),) = machine.flows()
    return flow.drops


def test_what_is_offered_is_the_converted_type() -> None:
    machine = sending("send: [{topic: /camera, convert: jpeg}]", CAMERA)
    assert machine.offers("base") == [
        OfferedTopic(COMPRESSED, JPEG_TYPE.name, JPEG_TYPE.md5sum, False, False, ("/driver",))
    ]
    (answer,) = machine.on_ask("base", [JPEG_TYPE.md5sum, CAMERA.md5sum], 1.0)
    assert isinstance(answer, Send) and b"string format" in answer.body


def test_a_topic_as_it_is_and_converted() -> None:
    machine = sending("send: [/camera, {topic: /camera, convert: jpeg}]", CAMERA)
    assert {offered.topic.name: offered.md5sum for offered in machine.offers("base")} == {
        "/camera": CAMERA.md5sum,
        "/camera/compressed": JPEG_TYPE.md5sum,
    }
    assert machine.set_requests("base", [Request(COMPRESSED, 0.0)], 0.0) == [
        RestartConversion("/camera", JPEG),
        Subscribe("/camera", True, JPEG),
    ]
    assert machine.set_requests("base", [Request(SharedName("red", "/camera"), 0.0)], 0.0) == [
        Subscribe("/camera", False, JPEG),
        Subscribe("/camera", True),
    ]
    assert sends(machine.on_message("/camera", converted(), False, 1.0, JPEG)) == []
    assert len(sends(machine.on_message("/camera", raw(), False, 1.0))) == 1


def test_a_rule_is_only_for_topics_that_it_can_convert() -> None:
    camera_info = LocalTopic("/info", "sensor_msgs/CameraInfo", "b" * 32, "", False, ("/driver",))
    machine = sending("send: [{topic: '/**', convert: jpeg}, {topic: '/**', rate: 1}]", CAMERA, camera_info)
    assert [offered.topic.name for offered in machine.offers("base")] == ["/camera", "/info", "/camera/compressed"]
    machine = sending("send: [{topic: '/**', convert: jpeg}]", CAMERA, camera_info)
    assert [offered.topic.name for offered in machine.offers("base")] == ["/camera/compressed"]


@pytest.mark.parametrize("denied", ["/camera", "/camera/compressed"])
def test_what_is_denied_is_not_converted_either(denied: str) -> None:
    machine = sending(f"send: [{{topic: /camera, convert: jpeg}}]\ndeny_send: [{denied}]", CAMERA)
    assert machine.offers("base") == []


def test_what_a_node_publishes_itself_goes_first() -> None:
    own = LocalTopic(COMPRESSED.name, JPEG_TYPE.name, "d" * 32, "", False, ("/driver",))
    machine = sending("send: [{topic: /camera, convert: jpeg}, /camera/compressed]", CAMERA, own)
    assert [offered.md5sum for offered in machine.offers("base")] == [own.md5sum]


def test_another_name_here() -> None:
    machine = sending("send: [{topic: base:/eye, here: /camera, convert: jpeg}]", CAMERA)
    assert [str(offered.topic) for offered in machine.offers("base")] == ["base:/eye/compressed"]
    assert machine.offers("blue") == []


def test_rates_hold_before_the_conversion() -> None:
    machine = sending("send: [{topic: /camera, convert: jpeg, rate: 2}]", CAMERA)
    assert not machine.would_send("/camera", JPEG, raw(), False, 0.0), "no site wants it"
    machine.set_requests("base", [Request(COMPRESSED, 0.0)], 0.0)
    sent = []
    for number in range(21):
        now = number / 10
        if machine.would_send("/camera", JPEG, raw(), False, now):
            assert machine.would_send("/camera", JPEG, raw(), False, now), "asking changes nothing"
            sent += sends(machine.on_message("/camera", converted(), False, now, JPEG))
    assert [decode_message_head(each.head).received_at for each in sent] == [0.0, 0.5, 1.0, 1.5, 2.0]
    assert drops(machine) == {DropReason.RATE: 16}
    assert {(each.priority, each.may_drop, each.key) for each in sent} == {
        (Priority.LOW, True, "t/red/camera/compressed")
    }


def test_what_came_over_a_bridge_is_not_converted() -> None:
    machine = sending("send: [{topic: /camera, convert: jpeg}]", CAMERA)
    machine.set_requests("base", [Request(COMPRESSED, 0.0)], 0.0)
    assert not machine.would_send("/camera", JPEG, raw(), True, 0.0)
    assert machine.drop("/camera", JPEG, "/driver", DropReason.UNCONVERTED, 0.0) == []
    assert machine.drop("/unknown", JPEG, "/driver", DropReason.UNCONVERTED, 0.0) == []
    assert drops(machine) == {DropReason.BRIDGED: 1, DropReason.UNCONVERTED: 1}


def test_sizes_hold_after_the_conversion() -> None:
    machine = sending("send: [{topic: /camera, convert: jpeg, size: 10}]", CAMERA)
    machine.set_requests("base", [Request(COMPRESSED, 0.0)], 0.0)
    assert machine.on_message("/camera", converted(b"x" * 11), False, 0.0, JPEG) == []
    assert len(machine.on_message("/camera", converted(b"x" * 10), False, 0.0, JPEG)) == 1
    assert drops(machine) == {DropReason.SIZE: 1}


def test_delivery_holds_after_the_conversion() -> None:
    machine = sending("send: [{topic: /camera, convert: jpeg, delivery: reliable}]", CAMERA)
    machine.set_requests("base", [Request(COMPRESSED, 0.0)], 0.0)
    (sent,) = sends(machine.on_message("/camera", converted(), False, 0.0, JPEG))
    assert not sent.may_drop and machine.tails("base") == {COMPRESSED: Tail(1, 0)}


def test_latched_images_are_kept_converted() -> None:
    machine = sending("send: [{topic: /camera, convert: jpeg, rate: 1}]", CAMERA._replace(latched=True))
    machine.set_requests("base", [Request(COMPRESSED, 0.0)], 0.0)
    for number in range(3):  # the last one must arrive, so the rate does not stop it from being converted
        assert machine.would_send("/camera", JPEG, raw(latched=True), False, 0.1 * number)
        machine.on_message("/camera", converted(b"%d" % number, latched=True), False, 0.1 * number, JPEG)
    assert [each.body for each in sends(machine.tick(1.0))] == [b"2"]
    later = sends(machine.set_requests("blue", [Request(COMPRESSED, 0.0)], 2.0))
    assert later[0].body == b"2" and decode_message_head(later[0].head).flags == Flag.LATCHED


def test_a_latched_image_does_not_stay_if_the_next_one_cannot_be_converted() -> None:
    machine = sending("send: [{topic: /camera, convert: jpeg}]", CAMERA._replace(latched=True))
    machine.set_requests("base", [Request(COMPRESSED, 0.0)], 0.0)
    machine.on_message("/camera", converted(b"old", latched=True), False, 0.0, JPEG)
    assert machine.drop("/camera", JPEG, "/driver", DropReason.OVERTAKEN, 1.0) == [], "a newer one is being converted"
    (note,) = sends(machine.drop("/camera", JPEG, "/driver", DropReason.UNCONVERTED, 2.0))
    assert decode_message_head(note.head).flags == Flag.LEFT
    later = sends(machine.set_requests("blue", [Request(COMPRESSED, 0.0)], 3.0))
    assert [each.key for each in later] == ["to/blue"], "there is only the list of latched messages, which is empty"


def test_videos_are_reliable_and_begin_anew_for_each_site() -> None:
    machine = sending("send: [{topic: /camera, convert: h264}]", CAMERA._replace(latched=True))
    video = SharedName("red", "/camera/h264")
    assert machine.offers("base") == [
        OfferedTopic(video, VIDEO_TYPE.name, VIDEO_TYPE.md5sum, False, True, ("/driver",))
    ]
    machine.set_requests("base", [Request(video, 0.0)], 0.0)
    received = converted(b"picture", VIDEO_TYPE.md5sum, latched=True)
    (sent,) = sends(machine.on_message("/camera", received, False, 0.0, H264))
    assert decode_message_head(sent.head).flags == 0, "one picture of a video is of no use later"
    assert machine.set_requests("blue", [Request(video, 0.0)], 0.0) == [RestartConversion("/camera", H264)]
    assert machine.set_requests("blue", [Request(video, 5.0)], 0.0) == []


def test_another_conversion_of_a_topic_that_is_sent() -> None:
    scan: Any = LocalTopic(
        "/scan", "sensor_msgs/LaserScan", "a" * 32, "", False, ("/n",),
        ((Conversion("every", 2.0), MessageType("sensor_msgs/LaserScan", "a" * 32, "")),),
    )  # fmt: skip
    machine = sending("send: [{topic: /scan, convert: every, every: 2, rate: 1}, /scan]", scan)
    scans = SharedName("red", "/scan")
    assert machine.set_requests("base", [Request(scans, 0.0)], 0.0)[1:] == [
        Subscribe("/scan", True, Conversion("every", 2.0))
    ]
    assert machine.set_topics([scan._replace(convertible=())], 1.0, 1.0) == [
        Subscribe("/scan", False, Conversion("every", 2.0)),
        Subscribe("/scan", True),
    ]
    ((topic, _, _),) = machine.flows()
    assert topic.settings.rate is None, "the other rule counts now"


def test_not_all_publishers_are_named() -> None:
    names = tuple(f"/driver{number}" for number in range(9))
    machine = sending("send: [/camera]", CAMERA._replace(publishers=("/no name", *names[::-1])))
    assert [offered.publishers for offered in machine.offers("base")] == [names[:8]]
