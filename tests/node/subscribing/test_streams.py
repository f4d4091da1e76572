"""Streams, the queues of asyncio iterations: they get messages undecoded, in whatever way they come."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from pyros1.msgs import AnyMsg
from pyros1.msgs.sensor_msgs.msg import CompressedImage
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.node.subscribing.tcp_source import MIN_LARGE_FRAME

from ...bodies import encode, encode_frame
from ...parts import subscription_of


class Queue:
    """A stream that keeps everything."""

    full = False
    urgent = False

    def __init__(self, keep: Callable[[Any], object], wants_newest: bool = True) -> None:
        self.wants_newest = wants_newest
        self._keep = keep

    def put(self, source: Any, item: Any) -> None:
        self._keep((source, item))


@pytest.fixture
def stream(collect: Any) -> Callable[..., Any]:
    """Return a function that subscribes a node with a stream, and returns the subscriber and what the stream gets."""

    def subscribe(node: Any, message_class: Any) -> Any:
        got = collect()
        node.subscribe("t", AnyMsg, lambda _: None)
        subscription = subscription_of(node)
        subscriber = Subscriber(subscription, message_class, print, None, subscription.remove, stream=Queue(got))
        subscription.add(subscriber)
        return subscriber, got

    return subscribe


def messages(subscriber: Any, got: Any) -> list[Any]:
    return [subscriber.decode_for_stream(source, item) for source, item in got.items]


@pytest.mark.parametrize("size", [10, MIN_LARGE_FRAME, 3 * MIN_LARGE_FRAME])
def test_messages_of_any_size_are_decoded_later(make_node: Any, transport: str, stream: Any, size: int) -> None:
    subscriber, got = stream(make_node("listener"), CompressedImage)
    publisher = make_node("talker").advertise("t", CompressedImage)
    assert publisher.wait_for_subscribers(timeout=20)
    for number in range(3):
        publisher.publish(CompressedImage(format="jpeg", data=bytes([number]) * size))
        got.wait(number + 1)
        messages(subscriber, got)
    found = messages(subscriber, got)
    assert [(message.format, bytes(message.data)) for message in found] == [
        ("jpeg", bytes([number]) * size) for number in range(3)
    ]
    assert {message._connection_header["callerid"] for message in found} == {"/talker"}


def test_a_late_stream_gets_the_latched_message(make_node: Any, transport: str, stream: Any, collect: Any) -> None:
    listener, first = make_node("listener"), collect()
    listener.subscribe("t", Float64, first)
    make_node("talker").advertise("t", Float64, latch=True).publish(5)
    first.wait(1)
    subscriber, got = stream(listener, Float64)
    got.wait(1)
    assert [message.data for message in messages(subscriber, got)] == [5]


def test_what_cannot_be_decoded_is_logged_when_it_is_taken(
    make_node: Any, fake_node: Any, watch_log: Any, stream: Any
) -> None:
    listener, fake = make_node("listener"), fake_node("/fake")
    log = watch_log(listener)
    fake.publish("/t")
    subscriber, got = stream(listener, Float64)
    sock = fake.accept_subscriber()
    sock.sendall(b"\x03\0\0\0abc" + encode_frame(Float64(1)) + b"\x0a\0\0\0" + encode(Float64(2)) + b"xx")
    got.wait(3)
    short, whole, long = messages(subscriber, got)
    assert short is None and (whole.data, long.data) == (1, 2)
    log.saw("/t from /fake", "(message dropped)")
    log.saw("/t from /fake: received a std_msgs/Float64 with 2 surplus bytes")


def test_an_ended_stream_gets_nothing(make_node: Any, transport: str, stream: Any, collect: Any) -> None:
    listener, rest = make_node("listener"), collect()
    subscriber, got = stream(listener, Float64)
    listener.subscribe("t", Float64, rest)
    publisher = make_node("talker").advertise("t", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(1)
    got.wait(1)
    subscriber.unregister()
    publisher.publish(2)
    rest.wait(2)
    assert len(got.items) == 1
