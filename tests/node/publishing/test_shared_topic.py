"""Publishers of one node that share a topic."""

from __future__ import annotations

import threading
from typing import Any

from pyros1.msgs import AnyMsg
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.msgs.std_msgs.msg import Header, String
from pyros1.wire.handshake import TopicType

from ...bodies import encode

PATIENCE = 20.0


def raw(node: Any, topic: str, cls: Any) -> Any:
    return node.advertise(topic, AnyMsg, latch=True, raw_type=TopicType(cls._type, cls._md5sum, cls._full_text))


def heard(node: Any, topic: str, cls: Any, count: int) -> list[Any]:
    got: list[Any] = []
    enough = threading.Event()

    def take(message: Any) -> None:
        got.append(message)
        if len(got) == count:
            enough.set()

    with node.subscribe(topic, cls, take):
        assert enough.wait(PATIENCE), got
    return got


def test_late_subscribers_get_the_last_message_of_each_raw_publisher(make_node: Any, transport: str) -> None:
    node = make_node("pub")
    one, two, gone = (raw(node, "/t", String) for _ in range(3))
    for publisher, text in ((one, "old"), (two, "b"), (one, "a"), (gone, "gone")):
        publisher.publish(AnyMsg(encode(String(text))))
    gone.unregister()
    assert sorted(message.data for message in heard(make_node("late"), "/t", String, 2)) == ["a", "b"]


def test_raw_messages_on_a_topic_whose_headers_the_node_numbers(make_node: Any, transport: str) -> None:
    node = make_node("pub")
    node.advertise("/log", Log)
    raw(node, "/log", Log).publish(AnyMsg(encode(Log(header=Header(seq=77), msg="as it came"))))
    (message,) = heard(make_node("late"), "/log", Log, 1)
    assert (message.header.seq, message.msg) == (77, "as it came")
