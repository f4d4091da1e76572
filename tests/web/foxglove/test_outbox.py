"""What waits for a slow viewer."""

from __future__ import annotations

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.web.foxglove.outbox import Outbox, QueuedMessage

ALL = 1 << 40
PATIENCE = 20.0


def message(ticket: int, number: int, size: int = 1000, latched_by: str | None = None) -> QueuedMessage:
    return QueuedMessage(ticket, number, bytes(size), latched_by)


def numbers(box: Outbox) -> list[int]:
    return [each.time for each in box.take(ALL)]


def test_nothing_is_dropped_while_there_is_room() -> None:
    box = Outbox()
    ticket = box.open()
    for number in range(500):
        box.put(message(ticket, number))
    assert numbers(box) == [*range(500)]
    assert (box.size, box.dropped) == (0, 0)


def test_the_oldest_of_a_channel_are_dropped_first() -> None:
    box = Outbox(max_channel_bytes=5_000)
    busy, quiet = box.open(), box.open()
    box.put(message(quiet, -1))
    for number in range(100):
        box.put(message(busy, number))
    found = box.take(ALL)
    assert [each.time for each in found if each.ticket == quiet] == [-1]
    assert [each.time for each in found if each.ticket == busy] == [96, 97, 98, 99]
    assert box.dropped == 96


def test_of_messages_that_are_larger_than_the_room_the_newest_stays() -> None:
    box = Outbox(max_channel_bytes=5_000)
    ticket = box.open()
    for number in range(5):
        box.put(message(ticket, number, 10_000_000))
    assert numbers(box) == [4]


def test_for_lack_of_room_the_oldest_go_of_the_channel_that_takes_most() -> None:
    box = Outbox(max_bytes=10_000, max_channel_bytes=ALL)
    small, large = box.open(), box.open()
    for number in range(3):
        box.put(message(small, -3 + number))
    for number in range(100):
        box.put(message(large, number))
    found = box.take(ALL)
    assert [each.time for each in found if each.ticket == small] == [-3, -2, -1]
    kept = [each.time for each in found if each.ticket == large]
    assert 3 < len(kept) < 8 and kept == [*range(100 - len(kept), 100)]
    assert box.dropped == 100 - len(kept)


def test_the_newest_latched_message_of_each_publisher_is_kept() -> None:
    box = Outbox(max_channel_bytes=5_000)
    ticket = box.open()
    box.put(message(ticket, -3, latched_by="/map"))
    box.put(message(ticket, -2, latched_by="/other"))
    box.put(message(ticket, -1, latched_by="/map"))
    for number in range(100):
        box.put(message(ticket, number))
    found = numbers(box)
    assert found[:2] == [-2, -1]
    assert found[2:] == [*range(100 - len(found[2:]), 100)]
    box.put(message(ticket, 1, latched_by="/map"))
    assert numbers(box) == [1]


def test_channels_take_turns() -> None:
    box = Outbox()
    busy, quiet = box.open(), box.open()
    for number in range(50):
        box.put(message(busy, number))
    box.put(message(quiet, 0))
    assert [each.ticket for each in box.take(3_000)] == [busy, quiet, busy]


def test_messages_of_several_channels_are_in_the_order_in_which_they_came() -> None:
    outbox = Outbox()
    one, two = outbox.open(), outbox.open()
    for number, ticket in enumerate((one, one, two, one)):
        outbox.put(QueuedMessage(ticket, 0, b"", None, float(number)))
    assert [(each.ticket, each.arrived_at) for each in outbox.take(10**6)] == [(one, 0), (one, 1), (two, 2), (one, 3)]


def test_a_channel_that_is_closed_is_forgotten() -> None:
    box = Outbox()
    first, second = box.open(), box.open()
    for ticket in (first, second):
        box.put(message(ticket, ticket))
    box.close(first)
    box.close(first)
    box.put(message(first, 9))
    assert [each.ticket for each in box.take(ALL)] == [second]
    assert box.size == 0


@pytest.mark.slow
@given(
    st.lists(st.tuples(st.integers(0, 4), st.integers(0, 8_000), st.sampled_from([None, "/a", "/b", "/c"]))),
    st.integers(0, 20),
)
def test_what_waits_is_bounded_in_order_and_ends_with_the_newest(
    puts: list[tuple[int, int, str | None]], often: int
) -> None:
    box = Outbox(max_bytes=20_000, max_channel_bytes=3_000)
    tickets = [box.open() for _ in range(5)]
    seen: dict[int, int] = {}

    def take(most: int) -> None:
        for each in box.take(most):
            assert seen.get(each.ticket, -1) < each.time
            seen[each.ticket] = each.time

    for number, (which, size, latched_by) in enumerate(puts):
        box.put(message(tickets[which], number, size, latched_by))
        assert box.size <= 20_000
        if often and number % often == 0:
            take(2_000)
    take(ALL)
    assert box.size == 0
    if puts:
        assert seen[tickets[puts[-1][0]]] == len(puts) - 1


def free() -> tuple[Outbox, int, list[None]]:
    woken: list[None] = []
    box = Outbox(wake=lambda: woken.append(None))
    ticket = box.open()
    box.release()
    assert box.is_free
    return box, ticket, woken


def test_a_message_is_sent_past_the_queue_if_nothing_is_there() -> None:
    box, ticket, woken = free()
    assert box.put(message(ticket, 1), may_send=True)
    assert not box.is_free
    box.end_sending(None)
    assert box.take(ALL) == [] and not woken and box.size == 0
    assert not box.put(message(ticket, 2)) and len(woken) == 1
    box.release()
    assert not box.put(message(ticket, 3), may_send=True)
    assert [each.time for each in box.take(ALL)] == [2, 3]
    assert not box.put(message(ticket, 4), may_send=True)  # those that were taken may not be sent yet
    assert box.take(ALL)
    box.release()
    assert not box.put(message(ticket + 1, 5), may_send=True)  # of no subscription
    assert box.is_free


def test_what_comes_while_a_message_is_sent_waits() -> None:
    box, ticket, woken = free()
    other = box.open()
    assert box.put(message(ticket, 1), may_send=True)
    assert not box.put(message(other, 2), may_send=True)
    assert box.take(ALL) == [] and not woken
    box.end_sending(None)
    assert len(woken) == 1
    assert [each.time for each in box.take(ALL)] == [2]


def test_a_message_that_could_not_be_sent_waits() -> None:
    box, ticket, woken = free()
    unsent = message(ticket, 1)
    assert box.put(unsent, may_send=True)
    box.end_sending(unsent)
    assert len(woken) == 1
    assert box.take(ALL) == [unsent]
    assert box.size == 0


@pytest.mark.parametrize("is_sent", [False, True])
def test_a_channel_is_closed_when_its_last_message_has_been_sent(
    is_sent: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A viewer is told afterwards that the channel has gone: no message may follow."""
    box, ticket, woken = free()
    other = box.open()
    sent = message(ticket, 1)
    assert box.put(sent, may_send=True)
    box.close(other)  # it has nothing to wait for
    closed: list[None] = []
    is_waiting = threading.Event()
    wait = threading.Condition.wait

    def wait_and_tell(condition: threading.Condition, timeout: float | None = None) -> bool:
        if timeout is None:
            is_waiting.set()
        return wait(condition, timeout)

    def close() -> None:
        box.close(ticket)
        closed.append(None)
        is_waiting.set()

    monkeypatch.setattr(threading.Condition, "wait", wait_and_tell)
    closing = threading.Thread(target=close, daemon=True)
    closing.start()
    assert is_waiting.wait(PATIENCE) and not closed
    assert not box.put(message(ticket, 2), may_send=True)  # otherwise it could wait for ever
    box.end_sending(None if is_sent else sent)
    closing.join(PATIENCE)
    assert closed and not woken
    assert box.take(ALL) == [] and box.size == 0
    assert box.put(message(box.open(), 3), may_send=True)
