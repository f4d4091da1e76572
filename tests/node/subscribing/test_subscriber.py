"""subscriber: what the messages of a subscription are made of, over TCP and within the process.

Feature: images and point clouds arrive without being copied -- as `bytes`, memoryviews or numpy arrays
"""

from __future__ import annotations

import sys
from typing import Any

import pytest

from pyros1.ground.errors import SerializationError
from pyros1.msgs import AnyMsg, load_message

from ...bodies import encode

Image: Any = load_message("sensor_msgs/Image")
LaserScan: Any = load_message("sensor_msgs/LaserScan")
Float64: Any = load_message("std_msgs/Float64")
TFMessage: Any = load_message("tf2_msgs/TFMessage")


@pytest.fixture
def topic(make_node: Any, transport: str, collect: Any) -> Any:
    """Return a function that links a publisher and a subscriber: (publish, collector)."""

    def link(message_class: Any, **options: Any) -> Any:
        talker, listener, got = make_node("talker"), make_node("listener"), collect()
        listener.subscribe("t", message_class, got, **options)
        publisher = talker.advertise("t", message_class, queue_size=100)
        assert publisher.wait_for_subscribers(timeout=20)
        return publisher.publish, got

    return link


def image(number: int, size: int) -> Any:
    message = Image(width=number, encoding="mono8", data=bytes([number]) * size)
    message.header.frame_id = "camera"
    return message


def test_images_of_all_sizes_arrive_as_bytes(topic: Any) -> None:
    publish, got = topic(Image)
    sizes = [0, 10, 1 << 17, 1 << 20, 1 << 20, 5, 3 << 20, (1 << 20) + 1]
    for number, size in enumerate(sizes):
        publish(image(number, size))
        got.wait(number + 1)
    for number, (message, size) in enumerate(zip(got.items, sizes, strict=True)):
        assert message.data.__class__ is bytes and len(message.data) == size
        assert (message.width, message.header.frame_id, message.data[-1:]) == (number, "camera", bytes([number])[:size])


def test_arrays_as_memoryviews(topic: Any) -> None:
    publish, got = topic(LaserScan, arrays="memoryview")
    publish(LaserScan(ranges=[0.5, 1.5], intensities=[]))
    got.wait(1)
    ranges = got.items[0].ranges
    assert isinstance(ranges, memoryview) and ranges.readonly and ranges.format == "f" and ranges.tolist() == [0.5, 1.5]
    assert got.items[0].intensities.tolist() == []


def test_arrays_as_numpy_arrays(topic: Any) -> None:
    numpy = pytest.importorskip("numpy")
    publish, got = topic(Image, arrays="numpy")
    for number, size in enumerate((3, 1 << 20, 1 << 20)):
        publish(image(number, size))
        got.wait(number + 1)
        data = got.items[number].data
        assert data.dtype == numpy.uint8 and not data.flags.writeable and (data == number).all() and len(data) == size


def test_arrays_as_something_else(make_node: Any) -> None:
    with pytest.raises(ValueError, match='arrays must be None, "memoryview" or "numpy", not \'list\''):
        make_node("listener").subscribe("t", Image, print, arrays="list")


def test_subscribers_of_one_topic_may_want_different_arrays(make_node: Any, transport: str, collect: Any) -> None:
    talker, listener = make_node("talker"), make_node("listener")
    plain, views, raw = collect(), collect(), collect()
    listener.subscribe("t", Image, plain)
    listener.subscribe("t", Image, views, arrays="memoryview")
    listener.subscribe("t", AnyMsg, raw)
    publisher = talker.advertise("t", Image, queue_size=10)
    assert publisher.wait_for_subscribers(timeout=20)
    for number in range(3):
        sent = image(number, 1 << 18)
        publisher.publish(sent)
        for collector in (plain, views, raw):
            collector.wait(number + 1)
        assert plain.items[-1].data == views.items[-1].data == sent.data
        assert isinstance(views.items[-1].data, memoryview)
        assert raw.items[-1]._buff == encode(plain.items[-1])


# The copy rule --------------------------------------------------------------------------------------------------------


def test_a_publisher_may_change_its_message_at_once(topic: Any) -> None:
    publish, got = topic(TFMessage)
    message = TFMessage([load_message("geometry_msgs/TransformStamped")()])
    for number in range(5):
        message.transforms[0].transform.translation.x = float(number)
        publish(message)
    message.transforms.clear()
    got.wait(5)
    assert [m.transforms[0].transform.translation.x for m in got.items] == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_within_a_process_a_large_array_is_shared_and_the_subscribers_share_the_message(
    make_node: Any, collect: Any
) -> None:
    """Feature: within a process nothing is serialized -- subscribers get a copy that shares immutable parts"""
    talker = make_node("talker")
    listeners, received = [make_node(f"listener{i}") for i in range(2)], [collect() for _ in range(2)]
    for listener, got in zip(listeners, received, strict=True):
        listener.subscribe("t", Image, got)
    publisher = talker.advertise("t", Image, queue_size=1)
    assert publisher.wait_for_subscribers(2, timeout=20)
    sent = image(1, 1 << 20)
    publisher.publish(sent)
    for got in received:
        got.wait(1)
    first, second = (got.items[0] for got in received)
    assert first is second and first is not sent and first.data is sent.data
    assert first._connection_header["callerid"] == "/talker"


def test_wrong_values_are_refused_within_a_process_too(topic: Any) -> None:
    publish, got = topic(Float64)
    with pytest.raises(SerializationError, match="/t: field data"):
        publish(Float64("text"))
    publish(Float64(3))
    got.wait(1)
    assert got.items[0].data.__class__ is float


def test_raw_messages_have_no_arrays(make_node: Any, transport: str, collect: Any) -> None:
    got = collect()
    make_node("listener").subscribe("t", AnyMsg, got, arrays="numpy")
    publisher = make_node("talker").advertise("t", Image)
    assert publisher.wait_for_subscribers(timeout=20)
    publisher.publish(image(1, 10))
    assert got.wait(1)[0]._buff.endswith(bytes([1]) * 10)


def test_what_a_callback_raises_to_end_its_program(make_node: Any, transport: str, watch_log: Any) -> None:
    """In a node that spins it runs in the program's own thread; in others it cannot end the program."""
    spinning, other = make_node("spinning", callbacks="spin"), make_node("other")
    log = watch_log(other)
    for node in (spinning, other):
        node.subscribe("t", Float64, lambda _: sys.exit("enough"))
    publisher = make_node("talker").advertise("t", Float64)
    assert publisher.wait_for_subscribers(2, timeout=20)
    publisher.publish(1)
    with pytest.raises(SystemExit, match="enough"):
        while spinning.ok():
            spinning.spin_once(1)
    log.saw("callback of /t: sys.exit() ends a program only from its main thread; call node.shutdown()")
    assert other.ok()


def test_a_queue_size_can_be_changed_while_messages_wait(make_node: Any, transport: str, until: Any) -> None:
    node, got = make_node("listener", callbacks="spin"), []
    subscriber = node.subscribe("t", Float64, lambda message: got.append(message.data), queue_size=10)
    publisher = make_node("talker").advertise("t", Float64, queue_size=10)
    assert publisher.wait_for_subscribers(timeout=20)
    subscriber.set_queue_size(2)
    for number in range(5):
        publisher.publish(number)
    until(lambda: subscriber.dropped == 3)
    while len(got) < 2:
        node.spin_once(1)
    assert got == [3, 4] and subscriber.queue_size == 2


def test_raw_messages_are_published_without_a_queue(make_node: Any, transport: str, collect: Any) -> None:
    got = collect()
    make_node("reader").subscribe("raw", Float64, got)
    publisher = make_node("writer").advertise("raw", Float64)
    assert publisher.wait_for_subscribers(timeout=20)
    raw = AnyMsg()
    raw._buff = encode(Float64(5))
    publisher.publish(raw)
    assert got.wait(1)[0].data == 5
