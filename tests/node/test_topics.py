"""topics: what publishers and subscribers promise each other, within a process and over TCP."""

from __future__ import annotations

import os
import re
import sys
import threading
from typing import Any

import pytest

from pyros1.ground.errors import (
    MessageError,
    NodeError,
    NodeShutdownError,
    SerializationError,
    ServiceError,
    WaitTimeoutError,
)
from pyros1.msgs import AnyMsg, from_definition
from pyros1.msgs.geometry_msgs.msg import PointStamped, Vector3
from pyros1.msgs.sensor_msgs.msg import Image
from pyros1.msgs.std_msgs.msg import Empty, Float64, Float64MultiArray, Header, String
from pyros1.msgs.std_srvs.srv import Trigger
from pyros1.net.master_client import MasterClient
from pyros1.node.topic_type import topic_type

from ..bodies import encode
from ..parts import context_of, publication_of

FLOAT64_MD5 = "fdb28210bfa9d7c91146260178d9a584"


@pytest.fixture
def pair(make_node: Any, transport: str) -> tuple[Any, Any]:
    return make_node("talker"), make_node("listener")


def connect(talker: Any, listener: Any, type: Any, callback: Any, **options: Any) -> tuple[Any, Any]:
    subscriber = listener.subscribe("t", type, callback)
    publisher = talker.advertise("t", type, **options)
    assert publisher.wait_for_subscribers(timeout=20)
    assert subscriber.wait_for_publishers(timeout=20)
    return publisher, subscriber


# Delivery -------------------------------------------------------------------------------------------------------------


def test_all_messages_arrive_in_order(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Float64, got, queue_size=0)
    for number in range(5000):
        publisher.publish(number)
    got.wait(5000)
    assert got.data == list(range(5000))
    assert publisher.dropped == 0


def test_large_messages_of_a_class_that_a_program_has_derived(pair: Any, collect: Any) -> None:
    """Its own ``deserialize`` gets whole messages, whatever their size, and may make anything of the array."""
    talker, listener = pair

    class Summed(Image):  # type: ignore[misc]
        def deserialize(self, data: Any) -> Any:
            super().deserialize(data)
            self.data = sum(self.data)
            return self

    class Later(Summed):
        pass

    class Plain(Image):  # type: ignore[misc]
        pass

    summed, plain = collect(), collect()
    subscribers = [listener.subscribe("t", Later, summed), listener.subscribe("t", Plain, plain)]
    publisher = talker.advertise("t", Image, queue_size=0)
    assert publisher.wait_for_subscribers(timeout=20) and subscribers[0].wait_for_publishers(timeout=20)
    for number in range(1, 6):
        publisher.publish(Image(data=bytes([number]) * 200_000))
    numbers = range(1, 6)
    assert [(type(each), each.data) for each in summed.wait(5)] == [(Later, 200_000 * number) for number in numbers]
    assert [(type(each), each.data) for each in plain.wait(5)] == [(Plain, bytes([n]) * 200_000) for n in numbers]


@pytest.mark.parametrize("publisher_first", [True, False])
def test_publisher_and_subscriber_may_start_in_any_order(pair: Any, collect: Any, publisher_first: bool) -> None:
    talker, listener = pair
    got = collect()
    if publisher_first:
        publisher = talker.advertise("t", Float64)
        subscriber = listener.subscribe("t", "std_msgs/Float64", got)
    else:
        subscriber = listener.subscribe("t", "std_msgs/Float64", got)
        publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20) and subscriber.wait_for_publishers(timeout=20)
    assert publisher.num_connections == subscriber.num_connections == 1
    publisher.publish(1.5)
    assert got.wait()[0] == Float64(1.5)


def test_large_messages_arrive_whole(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Image, got)
    sent = [bytes(range(256)) * (size // 256) + b"\x07" * (size % 256) for size in (0, 1, 70_000, 5_000_000)]
    for count, data in enumerate(sent, 1):
        publisher.publish(Image(data=data))
        assert got.wait(count)[-1].data == data


def test_a_message_may_be_changed_once_it_is_published(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Float64MultiArray, got)
    message = Float64MultiArray(data=[1.0, 2.0])
    publisher.publish(message)
    message.data[0] = 99.0
    publisher.publish(message)
    got.wait(2)
    assert [item.data for item in got.items] == [(1.0, 2.0), (99.0, 2.0)]
    assert got.items[0] is not got.items[1]


def test_messages_without_subscribers_are_lost_t54(pair: Any, collect: Any) -> None:
    talker, _ = pair
    publisher = talker.advertise("t", Float64)
    publisher.publish(1)
    got = collect()
    connect(*pair, Float64, got)
    publisher.publish(2)
    got.wait()
    assert got.data == [2]


def test_several_publishers_and_subscribers(make_node: Any, transport: str, collect: Any) -> None:
    receivers = [collect(), collect()]
    for index, got in enumerate(receivers):
        make_node(f"listener{index}").subscribe("t", String, got)
    publishers = [make_node(f"talker{index}").advertise("t", String, queue_size=0) for index in range(2)]
    for publisher in publishers:
        assert publisher.wait_for_subscribers(2, timeout=20)
    for number in range(50):
        for name, publisher in zip("ab", publishers, strict=True):
            publisher.publish(f"{name}{number}")
    for got in receivers:
        got.wait(100)
        for name in "ab":
            assert [text for text in got.data if text[0] == name] == [f"{name}{number}" for number in range(50)]


def test_a_node_may_subscribe_to_itself_t53(make_node: Any, transport: str, collect: Any) -> None:
    node, got = make_node("both"), collect()
    publisher, _ = connect(node, node, Float64, got)
    publisher.publish(3)
    got.wait()
    assert got.data == [3]


def test_callbacks_may_publish_to_their_own_topic(make_node: Any, transport: str) -> None:
    node, done = make_node("both"), threading.Event()

    def count_down(message: Any) -> None:
        if message.data > 0:
            publisher.publish(message.data - 1)
        else:
            done.set()

    node.subscribe("t", Float64, count_down)
    publisher = node.advertise("t", Float64, queue_size=None)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(100)
    assert done.wait(20)


# Connection headers ---------------------------------------------------------------------------------------------------


def test_messages_carry_the_publishers_header_t07_t21(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Float64, got, headers={"flavour": "salt=sweet"}, latch=True)
    publisher.publish(1)
    header = got.wait()[0]._connection_header
    assert {key: header[key] for key in ("callerid", "topic", "type", "md5sum", "latching", "flavour")} == {
        "callerid": "/talker",
        "topic": "/t",
        "type": "std_msgs/Float64",
        "md5sum": FLOAT64_MD5,
        "latching": "1",
        "flavour": "salt=sweet",
    }
    assert header["message_definition"] == Float64._full_text


def test_subscribers_greet_with_all_fields_t06(make_node: Any, fake_node: Any) -> None:
    fake = fake_node("/fake")
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, print)
    _, header = fake.accept()
    assert header == {
        "callerid": "/listener",
        "topic": "/t",
        "type": "std_msgs/Float64",
        "md5sum": FLOAT64_MD5,
        "message_definition": Float64._full_text,
        "tcp_nodelay": "1",
    }
    assert ("requestTopic", ["/listener", "/t", [["TCPROS"]]]) in fake.calls.items


def test_tcp_nodelay_can_be_declined(make_node: Any, fake_node: Any) -> None:
    fake = fake_node("/fake")
    fake.publish("/t")
    make_node("listener").subscribe("t", Float64, print, tcp_nodelay=False)
    assert fake.accept()[1]["tcp_nodelay"] == "0"


# Latching -------------------------------------------------------------------------------------------------------------


def test_latched_message_goes_to_late_subscribers_t19(pair: Any, collect: Any) -> None:
    talker, listener = pair
    publisher = talker.advertise("t", Float64, latch=True)
    publisher.publish(1)
    publisher.publish(2)
    got = collect()
    listener.subscribe("t", Float64, got)
    got.wait()
    publisher.publish(3)
    got.wait(2)
    assert got.data == [2, 3]


def test_latched_message_goes_to_late_callbacks_t18(pair: Any, collect: Any) -> None:
    first, second = collect(), collect()
    publisher, _ = connect(*pair, Float64, first, latch=True)
    publisher.publish(7)
    first.wait()
    pair[1].subscribe("t", Float64, second)
    second.wait()
    assert second.data == [7]
    assert first.data == [7], "the first callback is not called again"
    assert publisher.num_connections == 1


def test_late_callbacks_get_nothing_of_an_unlatched_topic(pair: Any, collect: Any) -> None:
    first, second = collect(), collect()
    publisher, _ = connect(*pair, Float64, first)
    publisher.publish(1)
    first.wait()
    pair[1].subscribe("t", Float64, second)
    publisher.publish(2)
    second.wait()
    assert second.data == [2]


def test_late_callbacks_get_nothing_of_a_latched_publisher_that_is_gone(
    pair: Any, make_node: Any, collect: Any
) -> None:
    first, second = collect(), collect()
    publisher, _subscriber = connect(*pair, Float64, first, latch=True)
    publisher.publish(1)
    first.wait()
    publisher.unregister()
    other = make_node("other").advertise("t", Float64)
    assert other.wait_for_subscribers(timeout=20)
    other.publish(2)
    first.wait(2)
    pair[1].subscribe("t", Float64, second)
    other.publish(3)
    second.wait()
    assert second.data == [3]


def test_each_latched_publisher_sends_its_message_t20(make_node: Any, transport: str, collect: Any) -> None:
    for index in range(2):
        make_node(f"talker{index}").advertise("t", Float64, latch=True).publish(index)
    got = collect()
    make_node("listener").subscribe("t", Float64, got)
    assert {message.data for message in got.wait(2)} == {0, 1}


def test_a_second_handle_may_turn_latching_on(pair: Any, collect: Any) -> None:
    talker, listener = pair
    talker.advertise("t", Float64)
    talker.advertise("t", Float64, latch=True).publish(5)
    got = collect()
    listener.subscribe("t", Float64, got)
    got.wait()
    assert got.data == [5]


# Publishers come and go -----------------------------------------------------------------------------------------------


def test_subscriber_resumes_when_its_publisher_is_replaced(make_node: Any, transport: str, collect: Any) -> None:
    got = collect()
    make_node("listener").subscribe("t", Float64, got)
    for number in range(3):
        talker = make_node("talker")
        publisher = talker.advertise("t", Float64)
        assert publisher.wait_for_subscribers(timeout=20)
        publisher.publish(number)
        got.wait(number + 1)
        talker.shutdown()
    assert got.data == [0, 1, 2]


def test_subscriber_resumes_when_a_second_publisher_takes_the_name_t52(
    make_node: Any, transport: str, collect: Any
) -> None:
    got = collect()
    make_node("listener").subscribe("t", Float64, got)
    first = make_node("talker").advertise("t", Float64)
    assert first.wait_for_subscribers(timeout=20)
    second = make_node("talker").advertise("t", Float64)
    assert second.wait_for_subscribers(timeout=20)
    second.publish(2)
    assert got.until(lambda items: 2 in [item.data for item in items])


def test_subscriber_resumes_after_unregister_and_advertise_in_the_same_node(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _subscriber = connect(*pair, Float64, got)
    for number in range(3):
        publisher.publish(number)
        publisher.unregister()  # sends what waits, then closes
        got.wait(number + 1)
        publisher = pair[0].advertise("t", Float64)
        assert publisher.wait_for_subscribers(timeout=20)
    assert got.data == [0, 1, 2]
    assert publisher.num_connections == 1


def test_what_waits_is_sent_before_a_publisher_closes(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Float64, got, queue_size=0)
    for number in range(1000):
        publisher.publish(number)
    pair[0].shutdown()
    got.wait(1000)
    assert got.data == list(range(1000))


def test_links_are_gone_when_the_subscriber_is(pair: Any) -> None:
    publisher, subscriber = connect(*pair, Float64, print)
    gone = threading.Event()
    publication_of(pair[0]).change_listeners.append(gone.set)
    subscriber.unregister()
    assert gone.wait(20)
    assert publisher.num_connections == 0 and subscriber.num_connections == 0
    publisher.publish(1)


# Types ----------------------------------------------------------------------------------------------------------------


def test_wrong_type_is_refused_and_both_sides_say_why_t11(pair: Any, watch_log: Any) -> None:
    talker, listener = pair
    there, here = watch_log(talker), watch_log(listener)
    publisher = talker.advertise("t", String)
    subscriber = listener.subscribe("t", Float64, print)
    at_publisher = there.saw("refused", "/t")
    at_subscriber = here.saw("refused", "/t")
    for text in (at_publisher, at_subscriber):
        assert "[std_msgs/Float64] vs. [std_msgs/String]" in text
    assert "/listener" in at_publisher
    assert talker.uri in at_subscriber
    assert publisher.num_connections == subscriber.num_connections == 0


def test_wrong_md5_of_the_same_type_is_refused_t11(pair: Any, watch_log: Any) -> None:
    talker, listener = pair
    there, here = watch_log(talker), watch_log(listener)
    other = from_definition("std_msgs/Float64", "float32 data\n")
    talker.advertise("t", other)
    listener.subscribe("t", Float64, print)
    for text in (there.saw("refused", "/t"), here.saw("refused", "/t")):
        assert f"[std_msgs/Float64/{FLOAT64_MD5}]" in text
        assert f"[std_msgs/Float64/{other._md5sum}]" in text


def test_refused_subscriber_connects_to_the_next_publisher(
    pair: Any, make_node: Any, watch_log: Any, collect: Any
) -> None:
    talker, listener = pair
    here, got = watch_log(listener), collect()
    wrong = talker.advertise("t", String)
    listener.subscribe("t", Float64, got)
    here.saw("refused")
    right = make_node("other").advertise("t", Float64)
    assert right.wait_for_subscribers(timeout=20)
    right.publish(1)
    got.wait()
    wrong.unregister()
    again = talker.advertise("t", Float64)
    assert again.wait_for_subscribers(timeout=20)
    again.publish(2)
    got.wait(2)
    assert got.data == [1, 2]


def test_same_md5_of_another_type_is_accepted_t10(pair: Any, collect: Any) -> None:
    talker, listener = pair
    renamed = from_definition("other_msgs/Number", "float64 data\n")
    got = collect()
    publisher = talker.advertise("t", renamed)
    listener.subscribe("t", Float64, got)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(renamed(4.0))
    publisher.publish(Float64(5.0))
    got.wait(2)
    assert got.data == [4.0, 5.0]
    assert type(got.items[0]) is Float64


def test_any_type_is_received_raw_and_decodes_itself_t09_o05(pair: Any, collect: Any) -> None:
    talker, listener = pair
    got = collect()
    publisher = talker.advertise("t", PointStamped)
    listener.subscribe("t", AnyMsg, got)
    assert publisher.wait_for_subscribers(timeout=20)
    sent = PointStamped(header=Header(frame_id="map"))
    sent.point.y = 2.5
    publisher.publish(sent)
    message = got.wait()[0]
    assert isinstance(message, AnyMsg)
    assert message._connection_header["type"] == "geometry_msgs/PointStamped"
    assert message._buff == encode(sent)
    decoded = message.decode()
    assert decoded._md5sum == PointStamped._md5sum
    assert (decoded.header.frame_id, decoded.point.y) == ("map", 2.5)


def test_raw_messages_are_passed_on_unchanged_b40(make_node: Any, transport: str, collect: Any) -> None:
    source, relay, sink = make_node("source"), make_node("relay"), make_node("sink")
    got = collect()
    out = relay.advertise("out", AnyMsg, raw_type=topic_type(PointStamped))
    relay.subscribe("in", AnyMsg, out.publish)
    sink.subscribe("out", PointStamped, got)
    publisher = source.advertise("in", PointStamped)
    assert out.wait_for_subscribers(timeout=20) and publisher.wait_for_subscribers(timeout=20)
    publisher.publish(PointStamped(header=Header(frame_id="a")))
    publisher.publish(PointStamped(header=Header(frame_id="b")))
    got.wait(2)
    assert [(m.header.seq, m.header.frame_id) for m in got.items] == [(1, "a"), (2, "b")]


def test_a_raw_message_may_be_published_by_a_typed_publisher(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Float64, got)
    raw = AnyMsg()
    raw._buff = encode(Float64(2.5))
    publisher.publish(raw)
    got.wait()
    assert got.data == [2.5]


# One topic, several users in a node -----------------------------------------------------------------------------------


def test_two_subscribers_share_one_link_p12(pair: Any, collect: Any) -> None:
    talker, listener = pair
    typed, raw = collect(), collect()
    first = listener.subscribe("t", Float64, typed)
    second = listener.subscribe("t", AnyMsg, raw)
    publisher = talker.advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    typed.wait()
    raw.wait()
    assert publisher.num_connections == 1
    assert raw.items[0].decode().data == 1
    second.unregister()
    publisher.publish(2)
    typed.wait(2)
    assert typed.data == [1, 2] and len(raw.items) == 1
    assert first.num_connections == 1


def test_topic_is_unregistered_with_its_last_user(make_node: Any) -> None:
    node = make_node("both")

    def state() -> tuple[list[str], list[str]]:
        publishers, subscribers, _ = node.master.get_system_state()
        return [t for t, _ in publishers if t == "/t"], [t for t, _ in subscribers if t == "/t"]

    publishers = [node.advertise("t", Float64) for _ in range(2)]
    subscribers = [node.subscribe("t", Float64, print) for _ in range(2)]
    assert state() == (["/t"], ["/t"])
    publishers[0].unregister()
    subscribers[0].unregister()
    publishers[0].unregister()  # again: nothing happens
    subscribers[0].unregister()
    assert state() == (["/t"], ["/t"])
    with publishers[1], subscribers[1]:
        pass
    assert state() == ([], [])


def test_unregister_within_a_callback(pair: Any, collect: Any) -> None:
    got = collect()

    def once(message: Any) -> None:
        subscriber.unregister()
        got(message)

    publisher, subscriber = connect(*pair, Float64, once)
    for number in range(10):
        publisher.publish(number)
    got.wait()
    assert got.data == [0]


def test_one_topic_has_one_type_per_node(make_node: Any) -> None:
    node = make_node("both")
    node.advertise("t", Float64)
    node.subscribe("t", Float64, print)
    with pytest.raises(NodeError, match=r"this node already publishes /t as std_msgs/Float64, not as std_msgs/String"):
        node.advertise("t", String)
    with pytest.raises(
        NodeError, match=r"this node already subscribes to /t as std_msgs/Float64, not as std_msgs/String"
    ):
        node.subscribe("t", String, print)


@pytest.mark.parametrize("size", [0, -1])
def test_subscriber_queue_size_must_be_positive(make_node: Any, size: int) -> None:
    with pytest.raises(ValueError, match=str(size)):
        make_node("a").subscribe("t", Float64, print, queue_size=size)


def test_refused_registration_leaves_nothing_behind(make_node: Any) -> None:
    node = make_node("a")
    with pytest.raises(MessageError, match="no_such_msgs/Thing"):
        node.subscribe("t", "no_such_msgs/Thing", print)
    assert "/t" not in context_of(node).subscriptions


# Publishing -----------------------------------------------------------------------------------------------------------


def test_forms_of_publish_p09(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Vector3, got)
    publisher.publish(Vector3(1, 2, 3))
    publisher.publish(4, 5, 6)
    publisher.publish(y=8)
    publisher.publish()
    got.wait(4)
    assert [(m.x, m.y, m.z) for m in got.items] == [(1, 2, 3), (4, 5, 6), (0, 8, 0), (0, 0, 0)]
    with pytest.raises(TypeError):
        publisher.publish(1, y=2)
    with pytest.raises(TypeError):
        publisher.publish(1, 2)
    with pytest.raises(AttributeError):
        publisher.publish(w=1)


def test_a_single_value_is_wrapped_p09(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, String, got)
    publisher.publish("hi")
    publisher.publish(data="ho")
    got.wait(2)
    assert got.data == ["hi", "ho"]


def test_an_empty_message_has_no_values(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Empty, got)
    publisher.publish()
    publisher.publish(Empty())
    assert got.wait(2) == [Empty(), Empty()]


def test_wrong_values_name_the_topic_p10(pair: Any) -> None:
    publisher, _ = connect(*pair, Float64, print)
    with pytest.raises(SerializationError, match=r"/t.*data"):
        publisher.publish("not a number")
    with pytest.raises(MessageError, match="/t"):
        publisher.publish(Vector3(1, 2, 3))


def test_another_message_type_names_both_types(pair: Any) -> None:
    publisher, _ = connect(*pair, Vector3, print)
    with pytest.raises(MessageError, match="/t carries geometry_msgs/Vector3, not std_msgs/String"):
        publisher.publish(String("x"))


class Foreign:
    """A message class that another generator made."""

    def __init__(self, cls: Any, **fields: Any) -> None:
        self._type, self._md5sum = cls._type, cls._md5sum
        vars(self).update(fields)


@pytest.mark.parametrize("listening", [False, True])
@pytest.mark.parametrize(
    ("published", "message", "reason"),
    [
        (Float64, String("x"), "/t carries std_msgs/Float64, not std_msgs/String"),
        (Vector3, String("x"), "/t carries geometry_msgs/Vector3, not std_msgs/String"),
        (Float64, Foreign(String, data="x"), "/t carries std_msgs/Float64, not std_msgs/String"),
        (Vector3, Foreign(String, data="x"), "/t carries geometry_msgs/Vector3, not std_msgs/String"),
        (
            Float64,
            from_definition("std_msgs/Float64", "float32 data")(),
            f"/t carries std_msgs/Float64, with md5sum {Float64._md5sum}, not 73fcbf46b49191e672908e50842a83d4",
        ),
        (
            Float64,
            AnyMsg(b"", {"type": "std_msgs/String", "md5sum": String._md5sum}),
            "/t carries std_msgs/Float64, not std_msgs/String",
        ),
    ],
)
def test_a_message_of_another_type_is_refused_whether_or_not_somebody_listens(
    pair: Any, collect: Any, published: Any, message: Any, reason: str, listening: bool
) -> None:
    """Feature: a publisher rejects a message of another type -- and names the type, with or without
    subscribers
    """
    talker, _ = pair
    publisher = connect(*pair, published, collect())[0] if listening else talker.advertise("t", published)
    with pytest.raises(SerializationError, match=f"^{re.escape(reason)}$"):
        publisher.publish(message)


def test_messages_of_the_same_type_that_others_made(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Float64, got)
    publisher.publish(from_definition("std_msgs/Float64", "float64 data")(1.0))
    publisher.publish(Foreign(Float64, data=2))
    publisher.publish(AnyMsg(bytes(8)))
    publisher.publish(AnyMsg(bytes(8), {"type": "std_msgs/Float64", "md5sum": "*"}))
    got.wait(4)
    assert got.data == [1.0, 2.0, 0.0, 0.0]


def test_a_message_as_the_only_field(pair: Any, collect: Any) -> None:
    got = collect()
    separator = "=" * 80
    holder = from_definition("p/Holder", f"std_msgs/String s\n{separator}\nMSG: std_msgs/String\nstring data")
    publisher, _ = connect(*pair, holder, got)
    publisher.publish(String("x"))
    with pytest.raises(SerializationError, match="/t carries p/Holder, not geometry_msgs/Vector3"):
        publisher.publish(Vector3())
    assert got.wait(1)[0].s.data == "x"


def test_a_wrong_value_costs_nothing_but_itself(pair: Any, collect: Any) -> None:
    got = collect()
    publisher, _ = connect(*pair, Float64, got)
    with pytest.raises(SerializationError):
        publisher.publish("x")
    publisher.publish(1)
    got.wait()
    assert got.data == [1]


def test_seq_counts_from_one_while_somebody_listens_t22_o08(pair: Any, collect: Any) -> None:
    talker, _ = pair
    publisher = talker.advertise("t", PointStamped)
    publisher.publish(PointStamped())
    publisher.publish(PointStamped())
    got = collect()
    connect(*pair, PointStamped, got)
    message = PointStamped(header=Header(seq=77))
    for _ in range(3):
        publisher.publish(message)
    got.wait(3)
    assert [m.header.seq for m in got.items] == [1, 2, 3]


def test_publishing_after_the_end(make_node: Any) -> None:
    node = make_node("a")
    publisher = node.advertise("t", Float64)
    publisher.unregister()
    with pytest.raises(NodeError, match="/t"):
        publisher.publish(1)
    other = node.advertise("u", Float64)
    node.shutdown()
    other.publish(1)  # a program that is told to stop may be in the middle of its loop
    with pytest.raises(NodeShutdownError):
        node.advertise("v", Float64)
    with pytest.raises(NodeShutdownError):
        node.subscribe("v", Float64, print)


def test_names_are_resolved_and_remapped_n03_n12(make_node: Any) -> None:
    node = make_node("a", namespace="/robot", argv=["t:=u", "/robot/s:=/other"])
    assert node.advertise("t", Float64).name == "/robot/u"
    assert node.subscribe("s", Float64, print).name == "/other"
    assert node.advertise("~t", Float64).name == "/robot/a/t"
    assert node.advertise("/t", Float64).name == "/t"


# Waiting for a message ------------------------------------------------------------------------------------------------


def test_wait_for_message(pair: Any, in_thread: Any) -> None:
    talker, listener = pair
    publisher = talker.advertise("t", Float64)
    waiting = in_thread(listener.wait_for_message, "t", Float64, 10.0)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(6)
    assert waiting.join().data == 6
    assert "/t" not in context_of(listener).subscriptions


def test_wait_for_message_in_a_node_that_spins(make_node: Any, transport: str) -> None:
    make_node("talker").advertise("t", Float64, latch=True).publish(6)
    assert make_node("listener", callbacks="spin").wait_for_message("t", Float64, 10.0).data == 6


def test_wait_for_message_gives_up_p16(make_node: Any) -> None:
    with pytest.raises(WaitTimeoutError, match="timeout exceeded while waiting for message on topic /t"):
        make_node("a").wait_for_message("t", Float64, 0.05)


def test_wait_for_message_ends_with_the_node(make_node: Any, in_thread: Any) -> None:
    node, other = make_node("a"), make_node("b")
    waiting = in_thread(node.wait_for_message, "t", Float64)
    assert other.advertise("t", Float64).wait_for_subscribers(timeout=20)
    node.shutdown()
    with pytest.raises(NodeShutdownError):
        waiting.join()


def test_waiting_for_links_has_a_limit(make_node: Any) -> None:
    node = make_node("a")
    assert not node.advertise("t", Float64).wait_for_subscribers(timeout=0.02)
    assert not node.subscribe("u", Float64, print).wait_for_publishers(timeout=0.02)


def test_an_end_and_a_new_beginning_at_once_leave_the_node_subscribed(
    make_node: Any, master: Any, in_thread: Any
) -> None:
    node = make_node("listener")
    client = MasterClient("/test", master.uri)
    together = threading.Barrier(2)

    def end(subscriber: Any) -> None:
        together.wait(10)
        subscriber.unregister()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        subscriber = node.subscribe("t", Float64, print)
        for _ in range(100):
            ending = in_thread(end, subscriber)
            together.wait(10)
            subscriber = node.subscribe("t", Float64, print)
            ending.join()
            assert ["/t", ["/listener"]] in client.get_system_state()[1]
    finally:
        sys.setswitchinterval(interval)
        client.close()


def test_an_end_and_a_new_beginning_at_once_leave_the_node_publishing(
    make_node: Any, master: Any, in_thread: Any
) -> None:
    node = make_node("talker")
    other = make_node("listener")
    heard = threading.Event()
    client = MasterClient("/test", master.uri)
    together = threading.Barrier(2)

    def end(publisher: Any) -> None:
        together.wait(10)
        publisher.unregister()

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        publisher = node.advertise("t", Float64)
        for _ in range(100):
            ending = in_thread(end, publisher)
            together.wait(10)
            publisher = node.advertise("t", Float64)
            ending.join()
            assert ["/t", ["/talker"]] in client.get_system_state()[0]
    finally:
        sys.setswitchinterval(interval)
        client.close()
    other.subscribe("t", Float64, lambda _: heard.set())
    assert publisher.wait_for_subscribers(timeout=10)
    publisher.publish(Float64(1.0))
    assert heard.wait(10)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork")
@pytest.mark.parametrize("transport", ["tcp", "local"], indirect=True)
def test_links_end_though_a_forked_process_has_their_sockets(make_node: Any, transport: str, until: Any) -> None:
    """As one of ``multiprocessing`` does; else who subscribes would wait for ever for a publisher that begins again."""
    node, other = make_node("talker"), make_node("listener")
    service = node.advertise_service("s", Trigger, lambda request: (True, ""))
    publisher = node.advertise("t", Float64, queue_size=5)
    subscriber = other.subscribe("t", Float64, print)
    assert publisher.wait_for_subscribers(timeout=10)
    with other.service("s", Trigger, persistent=True) as client:
        client()
        reader, writer = os.pipe()
        child = os.fork()
        if not child:
            os.close(writer)
            os.read(reader, 1)  # to the end of the test
            os._exit(0)
        try:
            service.shutdown()
            with pytest.raises(ServiceError, match="call to service"):
                client.call(Trigger._request_class(), timeout=10)
            publisher.unregister()
            publisher = node.advertise("t", Float64, queue_size=5)
            assert publisher.wait_for_subscribers(timeout=10)
            subscriber.unregister()
            until(lambda: not publisher.num_connections)
        finally:
            os.close(writer)
            os.close(reader)
            os.waitpid(child, 0)
