"""Streams: order, repetitions and gaps."""

from __future__ import annotations

from itertools import pairwise
from random import Random

import pytest

from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.exchange.streams import (
    MESSAGE_COST,
    BufferedBytes,
    Delivery,
    LatchedStream,
    NewestStream,
    ReliableStream,
    Stream,
    make_stream,
)
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packets import Flag, LatchedList, MessageHead, ResendRefusal, Tail

TOPIC = SharedName("red", "/t")


def head(number: int, publisher: int = 1, flags: int = 0) -> MessageHead:
    return MessageHead(7, 0, number, publisher, 0.0, flags, "0" * 32)


def feed(stream: Stream, *numbers: int, now: float = 0.0) -> list[int]:
    return [delivery.head.number for number in numbers for delivery in stream.accept(head(number), b"x", now)]


def reliable(age: float = 2.0, before: int = 0, site: BufferedBytes | None = None) -> ReliableStream:
    """Return a stream whose sender has said where it begins."""
    stream = ReliableStream(age, 0, site)
    assert stream.on_tail(Tail(before, before), 0.0) == []
    return stream


def latched_list(number: int, **messages: int) -> LatchedList:
    return LatchedList(TOPIC, number, {int(name[1:]): each for name, each in messages.items()})


def latched(number: int, publisher: int = 1) -> MessageHead:
    return head(number, publisher, Flag.LATCHED)


def left(number: int, publisher: int = 1) -> MessageHead:
    return head(number, publisher, Flag.LEFT)


def test_only_newer_messages() -> None:
    stream = NewestStream(0)
    assert feed(stream, 1, 3, 3, 2, 4) == [1, 3, 4]
    assert stream.drops == {DropReason.REPEATED: 1, DropReason.OVERTAKEN: 1}
    assert stream.missed(9.0) is None


def test_all_messages_in_order() -> None:
    stream = reliable(before=4)
    assert feed(stream, 5) == [5]
    assert feed(stream, 7, 8, 7, 4) == []
    assert stream.missed(0.0) == (6, 6) and stream.missed(0.1) is None and stream.missed(0.6) == (6, 6)
    assert feed(stream, 6, 6, 9) == [6, 7, 8, 9]
    assert stream.missed(9.0) is None


def test_the_last_messages_are_missed_as_well() -> None:
    stream = reliable(before=4)
    assert stream.missed(0.0) is None  # they were before the beginning
    stream.on_tail(Tail(6, 4), 0.0)
    assert stream.missed(0.0) == (5, 6)
    assert feed(stream, 6, 5) == [5, 6]


def test_the_first_messages_are_missed_if_a_heartbeat_overtakes_them() -> None:
    stream = ReliableStream(2.0, 0)
    assert stream.on_tail(Tail(6, 4), 0.0) == []
    assert stream.missed(0.0) == (5, 6)
    assert feed(stream, 5, 6, 7) == [5, 6, 7] and not stream.drops


def test_the_first_messages_wait_for_the_beginning() -> None:
    site = BufferedBytes()
    stream = ReliableStream(2.0, 2, site)
    assert feed(stream, 2, 7, 4, 6) == [] and stream.drops == {DropReason.REPEATED: 1}
    assert stream.missed(0.0) is None
    assert [each.head.number for each in stream.on_tail(Tail(6, 4), 0.0)] == []
    assert stream.missed(0.0) == (5, 5) and site.total == 2 * (MESSAGE_COST + 1), "message 4 was for others"
    assert feed(stream, 5) == [5, 6, 7]
    stream.restart(0.0)
    assert feed(stream, 9, 8) == []
    assert [each.head.number for each in stream.on_tail(Tail(9, 7), 0.0)] == [8, 9] and site.total == 0


def test_the_beginning_is_waited_for_as_long_as_for_missed_messages() -> None:
    stream = ReliableStream(2.0, 0)
    assert feed(stream, 5, 6, 8) == [] and stream.tick(2.0) == []
    assert [each.head.number for each in stream.tick(2.1)] == [5, 6]
    assert not stream.drops and stream.missed(2.1) == (7, 7)


def test_missed_messages_are_given_up() -> None:
    stream = reliable()
    assert feed(stream, 1, 3, 6) == [1]
    assert stream.tick(2.0) == []
    assert [each.head.number for each in stream.tick(2.1)] == [3]
    assert [each.head.number for each in stream.on_gone(ResendRefusal(TOPIC, 6), 2.1)] == [6]
    assert stream.drops == {DropReason.MISSED: 3}
    stream.on_tail(Tail(9, 0), 3.0)
    assert stream.tick(3.5) == [] and stream.tick(5.5) == [] and stream.missed(9.0) is None
    assert stream.drops == {DropReason.MISSED: 6}
    assert feed(stream, 8, 10) == [10]


def test_what_cannot_come_again_is_said_by_the_sender() -> None:
    stream = reliable()
    assert feed(stream, 1, 5, 7) == [1]
    assert stream.on_gone(ResendRefusal(TOPIC, 2), 0.0) == []  # nothing new
    assert stream.on_gone(ResendRefusal(TOPIC, 999), 0.0) == []  # nothing that there is
    assert [each.head.number for each in stream.on_gone(ResendRefusal(TOPIC, 5), 0.0)] == [5]
    assert feed(stream, 6) == [6, 7]


def test_what_waits_is_bounded() -> None:
    stream = reliable()
    feed(stream, 1)
    delivered = feed(stream, *range(3, 2500))
    assert delivered == [*range(3, 2500)][: len(delivered)] and len(delivered) >= 490
    stream = reliable()
    feed(stream, 1)
    big = [stream.accept(head(number), bytes(3 << 20), 0.0) for number in (3, 4, 5)]
    assert [len(each) for each in big] == [0, 0, 3]


def test_questions_become_rare_without_answers() -> None:
    stream = reliable(100.0)
    feed(stream, 1, 3)
    asked = [step / 10 for step in range(600) if stream.missed(step / 10)]
    gaps = [round(later - sooner, 1) for sooner, later in pairwise(asked)]
    assert gaps[:5] == [0.5, 1.0, 2.0, 4.0, 8.0] and set(gaps[5:]) == {8.0}


def test_after_a_pause_nothing_comes_twice() -> None:
    stream = reliable()
    assert feed(stream, 1, 2, 4) == [1, 2]
    stream.restart(0.0)
    stream.on_tail(Tail(5, 5), 0.0)
    assert feed(stream, 2, 3, 4) == [] and feed(stream, 6, 5, 7) == [6, 7]
    newest = NewestStream(0)
    feed(newest, 1, 2)
    newest.restart(0.0)
    assert feed(newest, 2, 3) == [3]


def test_the_last_message_of_each_publisher() -> None:
    stream = LatchedStream(0)
    assert stream.missed(0.0) == (0, 0)
    assert stream.on_latched_list(latched_list(0)) == [] and stream.missed(9.0) is None
    for each, expected in (
        (latched(1, 1), 1),
        (latched(2, 2), 1),
        (latched(3, 1), 1),
        (latched(3, 1), 0),
        (latched(1, 1), 0),
    ):
        assert len(stream.accept(each, b"x", 0.0)) == expected
    assert stream.missed(9.0) is None
    assert stream.on_tail(Tail(5, 0), 9.0) == []
    assert stream.missed(9.0) == (4, 5)
    stream.accept(latched(5, 2), b"x", 9.0)
    assert stream.missed(20.0) == (4, 5)
    assert stream.on_latched_list(latched_list(5, p1=4, p2=5)) == [] and stream.missed(30.0) == (
        4,
        5,
    )  # the one of 1 has yet to come
    stream.accept(latched(4, 1), b"x", 30.0)
    stream.on_latched_list(latched_list(5, p1=4, p2=5))
    assert stream.missed(99.0) is None


def test_publishers_that_are_gone() -> None:
    stream = LatchedStream(0)
    stream.on_latched_list(latched_list(0))
    stream.accept(latched(1, 1), b"x", 0.0)
    stream.accept(latched(2, 2), b"x", 0.0)
    assert stream.accept(left(3, 1), b"", 0.0) == [Delivery(left(3, 1), None)]
    assert stream.accept(left(3, 1), b"", 0.0) == [] and stream.accept(latched(1, 1), b"x", 0.0) == []
    notes = stream.on_latched_list(latched_list(4))
    assert [(each.head.publisher, each.body) for each in notes] == [(2, None)]
    assert stream.on_latched_list(latched_list(4)) == [] and stream.on_latched_list(latched_list(1, p1=1)) == []
    assert stream.accept(left(9, 7), b"", 0.0) == []  # of one that was never here


def test_after_a_pause_latched_messages_come_again_but_no_older_ones() -> None:
    stream = LatchedStream(0)
    stream.on_latched_list(latched_list(0))
    for number in (1, 2, 3):
        stream.accept(latched(number), b"x", 0.0)
    stream.restart(0.0)
    assert stream.accept(latched(2), b"x", 0.0) == []
    assert len(stream.accept(latched(3), b"x", 0.0)) == 1
    assert stream.missed(0.4) is None and stream.missed(0.5) is not None  # the request has asked already


def test_messages_that_are_later_than_the_list_without_them() -> None:
    stream = LatchedStream(0)
    stream.on_latched_list(latched_list(0))
    stream.accept(latched(1, 1), b"x", 0.0)
    assert len(stream.on_latched_list(latched_list(5, p3=4))) == 1
    for late in (latched(2, 1), latched(3, 2), latched(2, 3)):
        assert stream.accept(late, b"x", 0.0) == []
    assert len(stream.accept(latched(4, 3), b"x", 0.0)) == 1 and len(stream.accept(latched(6, 2), b"x", 0.0)) == 1


def test_too_many_publishers() -> None:
    stream = LatchedStream(0)
    for number in range(1, 1001):
        assert stream.accept(latched(number, number), b"x", 0.0)
    assert stream.accept(latched(1001, 1001), b"x", 0.0) == [] and stream.drops == {DropReason.PUBLISHERS: 1}
    stream.accept(left(1002, 5), b"", 0.0)
    assert stream.accept(latched(1003, 1003), b"x", 0.0)


@pytest.mark.parametrize("seed", range(30))
def test_any_order(seed: int) -> None:
    """All messages of a reliable stream come in order, if all packets come at some time before they are too old."""
    random = Random(seed)
    stream = reliable(10.0)
    numbers = [*range(1, 100), *random.choices(range(1, 100), k=50)]
    random.shuffle(numbers)
    assert feed(stream, *numbers) == [*range(1, 100)]


def test_kinds_of_streams() -> None:
    assert isinstance(make_stream(True, True, 1.0, 0, BufferedBytes()), LatchedStream)
    assert isinstance(make_stream(False, True, 1.0, 0, BufferedBytes()), ReliableStream)
    assert isinstance(make_stream(False, False, 1.0, 0, BufferedBytes()), NewestStream)
    for stream in (
        make_stream(True, False, 1.0, 5, BufferedBytes()),
        make_stream(False, True, 1.0, 5, BufferedBytes()),
        make_stream(False, False, 1.0, 5, BufferedBytes()),
    ):
        stream.on_tail(Tail(5, 5), 0.0)
        assert feed(stream, 5, 6) == [6]


def test_what_a_site_has_kept_back_is_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.exchange.streams.SITE_BUFFER_BYTES", 100)
    monkeypatch.setattr("pyros1.bridge.exchange.streams.MESSAGE_COST", 0)
    site = BufferedBytes()
    streams = [reliable(site=site) for _ in range(3)]
    for stream in streams:
        stream.accept(head(1), b"", 0.0)
    assert streams[0].accept(head(3), bytes(60), 0.0) == [] and streams[1].accept(head(3), bytes(40), 0.0) == []
    assert [delivery.head.number for delivery in streams[2].accept(head(3), bytes(1), 0.0)] == [3]
    assert site.total == 100
    streams[0].restart(0.0)
    assert site.total == 40
    assert len(streams[1].accept(head(2), bytes(5), 0.0)) == 2 and site.total == 0
    assert streams[1].accept(head(5), bytes(40), 0.0) == [] and streams[1].accept(head(7), bytes(40), 0.0) == []
    assert len(streams[1].tick(9.0)) == 1 and site.total == 40
    streams[1].accept(head(9), bytes(40), 9.0)
    assert len(streams[1].on_gone(ResendRefusal(TOPIC, 10), 9.0)) == 2 and site.total == 0


def test_empty_messages_count_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.exchange.streams.SITE_BUFFER_BYTES", 10 * MESSAGE_COST)
    site = BufferedBytes()
    streams = [reliable(site=site) for _ in range(20)]
    for stream in streams:
        stream.accept(head(1), b"", 0.0)
    assert [len(stream.accept(head(3), b"", 0.0)) for stream in streams] == [0] * 10 + [1] * 10
