"""Messages that do not end where their bytes do are received, as in stock ROS, with one warning for each publisher."""

from __future__ import annotations

import struct
from typing import Any

import pytest

from pyros1.msgs import AnyMsg
from pyros1.msgs.sensor_msgs.msg import CompressedImage
from pyros1.msgs.std_msgs.msg import Float64, Float64MultiArray, String
from pyros1.node.subscribing.tcp_source import MIN_LARGE_FRAME

from ...bodies import encode


def frame(body: bytes) -> bytes:
    return struct.pack("<I", len(body)) + body


def linked(fake: Any, cls: Any, **fields: str) -> Any:
    return fake.accept_subscriber(type=cls._type, md5sum=cls._md5sum, message_definition=cls._full_text, **fields)


@pytest.mark.parametrize("callbacks", ["inline", "spin"])
def test_bytes_behind_messages_are_ignored_with_one_warning_for_each_publisher(
    make_node: Any, fake_node: Any, collect: Any, watch_log: Any, until: Any, callbacks: str
) -> None:
    node, got, raw = make_node("listener", callbacks=callbacks), collect(), collect()
    log, fakes = watch_log(node), [fake_node("/one"), fake_node("/two")]
    for fake in fakes:
        fake.publish("/t")
    node.subscribe("t", Float64, got)
    node.subscribe("t", AnyMsg, raw)
    for number, fake in enumerate(fakes):
        bodies = [encode(Float64(number + n)) + b"x" * (n + 1) for n in range(3)]
        linked(fake, Float64, callerid=fake.name).sendall(b"".join(map(frame, bodies)))
    if callbacks == "spin":
        until(lambda: node.spin_once(0.01) >= 0 and len(raw.items) == 6)
    raw.wait(6)
    assert sorted(message.data for message in got.wait(6)) == [0, 1, 1, 2, 2, 3]
    for fake in fakes:
        log.saw(f"/t from {fake.name}: received a std_msgs/Float64 with ")
    assert len([text for text in log.texts if "at its end" in text]) == 2


def test_a_publisher_that_connects_again_does_not_fill_the_log(
    make_node: Any, fake_node: Any, collect: Any, watch_log: Any
) -> None:
    node, got, fake = make_node("listener"), collect(), fake_node("/fake")
    log = watch_log(node)
    fake.publish("/t")
    node.subscribe("t", Float64, got)
    for number in range(3):
        sock = linked(fake, Float64, callerid="/fake")
        sock.sendall(frame(encode(Float64(number)) + b"x" * (number + 1)))
        got.wait(number + 1)
        sock.close()
    log.saw("/t from /fake: received a std_msgs/Float64 with 1 surplus byte")
    assert len([text for text in log.texts if "at its end" in text]) == 1


@pytest.mark.parametrize("arrays", [None, "numpy", "memoryview"])
def test_of_messages_of_any_size(
    make_node: Any, fake_node: Any, collect: Any, watch_log: Any, arrays: str | None
) -> None:
    node, got, fake = make_node("listener"), collect(), fake_node("/fake")
    log = watch_log(node)
    fake.publish("/t")
    node.subscribe("t", CompressedImage, got, arrays=arrays)
    sock = linked(fake, CompressedImage)
    for size in (
        3,
        MIN_LARGE_FRAME,
        2 * MIN_LARGE_FRAME,
        3 * MIN_LARGE_FRAME,
        10,
    ):  # large ones are received in pieces, if these fit
        sock.sendall(frame(encode(CompressedImage(format="raw", data=bytes(size))) + b"abc"))
    got.wait(5)
    assert [len(message.data) for message in got.items] == [
        3,
        MIN_LARGE_FRAME,
        2 * MIN_LARGE_FRAME,
        3 * MIN_LARGE_FRAME,
        10,
    ]
    log.saw("CompressedImage with 3 surplus bytes at its end")


def test_of_latched_messages_and_those_that_end_too_early(
    make_node: Any, fake_node: Any, collect: Any, watch_log: Any
) -> None:
    """A string that is cut off is shorter; a message that lacks more is dropped."""
    node, got, later, fake = make_node("listener"), collect(), collect(), fake_node("/fake")
    log = watch_log(node)
    fake.publish("/t")
    node.subscribe("t", String, got)
    linked(fake, String, latching="1").sendall(frame(b"\5\0\0\0ab") + frame(b"\5\0\0") + frame(b"\1\0\0\0c_"))
    assert [message.data for message in got.wait(2)] == ["ab", "c"]
    log.saw("/t from /fake: received a std_msgs/String with 3 bytes missing at its end")
    log.saw("/t from /fake", "dropped")
    node.subscribe("t", String, later)
    assert later.wait()[0].data == "c"


def test_of_arrays_and_iterations(make_node: Any, fake_node: Any, collect: Any) -> None:
    """Each subscriber of a topic may have a form of its own."""
    node, plain, views, fake = make_node("listener"), collect(), collect(), fake_node("/fake")
    fake.publish("/t")
    node.subscribe("t", Float64MultiArray, plain)
    node.subscribe("t", Float64MultiArray, views, arrays="numpy")
    linked(fake, Float64MultiArray).sendall(frame(encode(Float64MultiArray(data=[1, 2])) + b"abc"))
    assert list(plain.wait()[0].data) == list(views.wait()[0].data) == [1, 2]


def test_a_publisher_that_does_not_check_the_md5(make_node: Any, fake_node: Any, collect: Any, watch_log: Any) -> None:
    """Its messages come, as in stock ROS, with a warning (T15)."""
    node, got, fake = make_node("listener"), collect(), fake_node("/fake")
    log = watch_log(node)
    fake.publish("/t")
    node.subscribe("t", Float64, got)
    fake.accept_subscriber(md5sum="0" * 32).sendall(frame(encode(Float64(5))))
    assert got.wait()[0].data == 5
    log.saw("/t", f"[{'0' * 32}], but this subscriber wants std_msgs/Float64", "may be wrong")


def test_a_publisher_with_a_definition_of_megabytes(make_node: Any, fake_node: Any, collect: Any) -> None:
    node, got, fake = make_node("listener"), collect(), fake_node("/fake")
    fake.publish("/t")
    node.subscribe("t", Float64, got)
    text = Float64._full_text + "# padding\n" * 300_000
    fake.accept_subscriber(type=Float64._type, md5sum=Float64._md5sum, message_definition=text).sendall(
        frame(encode(Float64(5)))
    )
    assert got.wait()[0].data == 5
