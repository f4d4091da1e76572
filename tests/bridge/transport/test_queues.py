"""What waits until the network takes it."""

from __future__ import annotations

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.queues import Outbox


def drain(outbox: Outbox, now: float = 0.0) -> list[bytes]:
    found = []
    while (packet := outbox.pop(now)) is not None:
        found.append(packet.body)
    return found


def test_urgent_packets_go_first() -> None:
    outbox = Outbox()
    for body, priority in (
        (b"1", Priority.LOW),
        (b"2", Priority.NORMAL),
        (b"3", Priority.URGENT),
        (b"4", Priority.NORMAL),
    ):
        outbox.put(Send("t", b"", body, priority), 0.0)
    assert len(outbox) == 4 and outbox.waiting_bytes == 4
    assert drain(outbox) == [b"3", b"2", b"4", b"1"] and outbox.waiting_bytes == 0


def test_a_slow_network_gets_only_the_newest() -> None:
    outbox = Outbox()
    for number in range(5):
        outbox.put(Send("t", b"", b"old %d" % number, replaces=1, may_drop=True), number / 1000)
    outbox.put(Send("t", b"", b"other publisher", replaces=2, may_drop=True), 0.01)
    outbox.put(Send("u", b"", b"other topic", replaces=1, may_drop=True), 0.01)
    assert len(outbox) == 7, "the network has had no time yet"
    outbox.put(Send("t", b"", b"new", replaces=1, may_drop=True), 0.06)
    outbox.put(Send("t", b"", b"newest", replaces=1, may_drop=True), 0.061)
    assert len(outbox) == 3 and outbox.waiting_bytes == len(b"newestother publisherother topic")
    assert drain(outbox) == [b"newest", b"other publisher", b"other topic"] and len(outbox) == 0
    assert outbox.drops == {"t": {DropReason.OVERTAKEN: 6}}
    outbox.put(Send("t", b"", b"next", replaces=1, may_drop=True), 9.0)
    assert drain(outbox, 9.0) == [b"next"] and outbox.waiting_bytes == 0


def test_a_fast_publisher_cannot_fill_the_outbox() -> None:
    outbox = Outbox()
    for number in range(1000):
        outbox.put(Send("t", b"", b"%d" % number, replaces=1, may_drop=True), 0.0)
    assert len(outbox) <= 50 and drain(outbox)[-1] == b"999"


def test_a_topic_whose_priority_changes_while_its_messages_wait() -> None:
    outbox = Outbox()
    outbox.put(Send("t", b"", b"image", Priority.LOW, replaces=1, may_drop=True), 0.0)
    outbox.put(Send("t", b"", b"old pose", Priority.NORMAL, replaces=1, may_drop=True), 0.1)
    outbox.put(Send("t", b"", b"pose", Priority.NORMAL, replaces=1, may_drop=True), 0.2)
    assert outbox.drops == {"t": {DropReason.OVERTAKEN: 1}}
    assert drain(outbox, 0.2) == [b"pose", b"image"] and outbox.waiting_bytes == 0


def test_what_is_sent_again_waits_only_once() -> None:
    outbox = Outbox()
    for _ in range(2):
        outbox.put(Send("again/base/t", b"", b"5", replaces=5), 0.0)
        outbox.put(Send("again/base/t", b"", b"6", replaces=6), 0.0)
    assert drain(outbox) == [b"5", b"6"]


def test_what_is_too_old_is_not_sent() -> None:
    outbox = Outbox()
    outbox.put(Send("t", b"", b"1", expires=1.0), 0.0)
    outbox.put(Send("t", b"", b"2", expires=3.0), 0.0)
    assert drain(outbox, 2.0) == [b"2"] and outbox.drops == {"t": {DropReason.OLD: 1}}


def test_only_urgent_packets_overtake_something_else_that_waits() -> None:
    outbox = Outbox()
    for at, body, priority in (
        (1.0, b"before", Priority.HIGH),
        (2.0, b"after", Priority.HIGH),
        (3.0, b"heartbeat", Priority.URGENT),
    ):
        outbox.put(Send("t", b"", body, priority), at)
    outbox.put(Send("t", b"", b"old", Priority.URGENT, expires=3.5), 3.0)
    popped = [outbox.pop(4.0, before=2.0) for _ in range(3)]
    assert [packet and packet.body for packet in popped] == [b"heartbeat", b"before", None]
    assert drain(outbox, 4.0) == [b"after"]


def test_the_outbox_is_bounded() -> None:
    outbox = Outbox(max_bytes=10, max_packets=3)
    outbox.put(Send("big", b"", bytes(20)), 0.0)
    assert len(outbox) == 1  # one may always wait
    outbox.put(Send("a", b"", b"1", Priority.LOW), 0.0)
    outbox.put(Send("a", b"", b"2", Priority.LOW), 0.0)
    assert drain(outbox) == [bytes(20)] and outbox.drops == {"a": {DropReason.QUEUE: 2}}
    for number in range(5):
        outbox.put(Send("a", b"", b"%d" % number), 0.0)
    assert drain(outbox) == [b"2", b"3", b"4"]
