"""`bag record --snapshot`: the last messages, when somebody asks for them.

Feature: recording the last minute before an event -- `pyros1 bag record --snapshot`
"""

from __future__ import annotations

import signal
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from pyros1.bag.format.reader import BagReader
from pyros1.bag.record.file_names import FileNames
from pyros1.bag.record.model import RecordedPublisher, RecordOptions, Topic
from pyros1.bag.record.snapshot import MessageRing, SnapshotBuffer
from pyros1.msgs.std_msgs.msg import Float64, String
from pyros1.msgs.std_srvs.srv import SetBool, Trigger

S = 10**9
DEADLINE = 20.0


@pytest.fixture
def publishers() -> tuple[RecordedPublisher, RecordedPublisher]:
    """A publisher that does not latch, and one that does."""
    topic = Topic("/t")
    return RecordedPublisher(topic, {}), RecordedPublisher(topic, {"latching": "1"}, latching=True)


def test_ring_keeps_what_is_new_enough(publishers: tuple[RecordedPublisher, RecordedPublisher]) -> None:
    ring, plain = MessageRing(10 * S, 0), publishers[0]
    for second in range(30):
        ring.add(second * S, plain, b"x")
    assert [stamp // S for stamp, _, _ in ring.messages_at(29 * S)[1]] == list(range(19, 30))
    assert [stamp // S for stamp, _, _ in ring.messages_at(35 * S)[1]] == list(range(25, 30)), "a silent topic"
    assert ring.messages_at(100 * S) == ([], [])
    assert ring.bytes == 0


def test_ring_keeps_what_is_small_enough(publishers: tuple[RecordedPublisher, RecordedPublisher]) -> None:
    ring, plain = MessageRing(0, 10_000), publishers[0]
    for number in range(30):
        ring.add(number, plain, bytes(2000))
        assert ring.bytes <= 10_000
    assert [stamp for stamp, _, _ in ring.messages_at(30)[1]] == [26, 27, 28, 29]
    ring.add(31, plain, bytes(50_000))
    assert len(ring.messages_at(31)[1]) == 1, "one message is kept, however large"


def test_ring_never_forgets_what_is_latched(publishers: tuple[RecordedPublisher, RecordedPublisher]) -> None:
    ring, (plain, latched) = MessageRing(10 * S, 0), publishers
    ring.add(0, latched, b"old")
    ring.add(1 * S, latched, b"map")
    for second in range(2, 60):
        ring.add(second * S, plain, b"x")
    older, rest = ring.messages_at(60 * S)
    assert [data for _, _, data in older] == [b"map"] and len(rest) == 10
    ring.add(60 * S, latched, b"new")
    older, rest = ring.messages_at(60 * S)
    assert not older and rest[-1][2] == b"new", "it is there once"


def test_a_snapshot_is_a_bag_by_time(tmp_path: Path, make_node: Any) -> None:
    talker = make_node("talker")
    talker.advertise("map", String, latch=True).publish("m")
    publishers = [talker.advertise(name, Float64, queue_size=0) for name in ("a", "b")]
    options = RecordOptions(names=FileNames(str(tmp_path / "s"), has_date=False, has_number=True), min_space=0)
    snapshots = SnapshotBuffer(make_node("record"), options, 0.0, 0, lambda text: None)
    assert snapshots.write() == ("", 0) and not list(tmp_path.glob("s*")), "nothing has come yet"
    for name in ("/map", "/a", "/b"):
        snapshots.subscribe(name)
    for publisher in publishers:
        assert publisher.wait_for_subscribers(timeout=DEADLINE)
    for value in range(20):
        publishers[value % 2].publish(float(value))
    until(lambda: sum(topic.messages for topic in snapshots.topics.values()) == 21)
    for number in range(2):
        assert snapshots.write() == (str(tmp_path / f"s_{number}.bag"), 21), "what is kept stays"
    with BagReader(tmp_path / "s_1.bag") as bag:
        messages = list(bag.messages())
        numbers = [struct.unpack("<d", m.data)[0] for m in messages if m.connection.topic in ("/a", "/b")]
        assert sorted(numbers) == list(map(float, range(20)))
        assert [message.time for message in messages] == sorted(message.time for message in messages)
        assert any(connection.latching for connection in bag.connections.values())
    snapshots.enable(False)
    publishers[0].publish(99.0)
    snapshots.enable(True)
    publishers[0].publish(100.0)
    until(lambda: snapshots.topics["/a"].messages in (11, 12))
    with BagReader(snapshots.write()[0]) as bag:
        assert bag.count(bag.connection_ids(["/a"])) <= 2 and bag.count(bag.connection_ids(["/map"])) == 1


@pytest.mark.slow
def test_services_trigger_and_pause(start: Any, make_node: Any, tmp_path: Path) -> None:
    node = make_node("talker")
    publisher = node.advertise("t", Float64, queue_size=0)
    child = start(
        "bag", "record", "--snapshot", "--snapshot-duration", "60", "-O", "snap", "--min-space", "0", "/t",
        "__name:=box",
    )  # fmt: skip
    node.wait_for_service("/box/snapshot", DEADLINE)
    trigger, enable = node.service("/box/snapshot", Trigger), node.service("/box/enable", SetBool)
    answer = trigger()
    assert (answer.success, answer.message) == (False, "no messages to write yet")
    assert publisher.wait_for_subscribers(timeout=DEADLINE)
    publisher.publish(1.0)
    answer = until(lambda: (answer := trigger()).success and answer)
    assert answer.message == "1 messages in snap.bag"
    assert trigger().message == "1 messages in snap_1.bag", "the first one stays"
    with BagReader(tmp_path / "snap.bag") as bag:
        assert bag.count() == 1
    assert enable(False).success
    child.send_signal(signal.SIGINT)
    out, err = child.communicate(timeout=DEADLINE)
    assert (child.returncode, err) == (0, "")
    assert "/box/snapshot" in out and "not being kept" in out
    assert not (tmp_path / "snap.bag.active").exists()


def until(reached: Callable[[], Any]) -> Any:
    import time

    end = time.monotonic() + DEADLINE
    while not (value := reached()):
        assert time.monotonic() < end
        time.sleep(0.01)
    return value
