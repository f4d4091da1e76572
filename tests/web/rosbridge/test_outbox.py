"""What waits for a slow client: bounded, and the newest."""

from __future__ import annotations

from typing import Any

from pyros1.msgs import AnyMsg
from pyros1.observe.decoder import Decoder
from pyros1.web.hub import Arrival
from pyros1.web.rosbridge.operations import Subscribe
from pyros1.web.rosbridge.outbox import MAX_BYTES, MAX_FRAME_BYTES, MAX_MESSAGES, MAX_TOTAL_BYTES, Outbox, TopicQueue


def arrival(at: float = 0.0, size: int = 1) -> Arrival:
    return Arrival(AnyMsg(bytes(size)), at, at, Decoder())


def add_subscription(**given: Any) -> Subscribe:
    fields = {
        "topic": "/t",
        "type": "",
        "throttle": 0.0,
        "queue_length": 0,
        "fragment_size": None,
        "compression": "none",
        "key": None,
    }
    return Subscribe(**{**fields, **given})


def made(*requests: Subscribe) -> tuple[Outbox, TopicQueue, list[None]]:
    woken: list[None] = []
    outbox, flow = Outbox(lambda: woken.append(None)), TopicQueue("/t")
    for each in requests or (add_subscription(),):
        flow.add_subscription(each)
    outbox.add(flow)
    return outbox, flow, woken


def times(outbox: Outbox, now: float) -> tuple[list[float], float | None]:
    _, found, again = outbox.take(now)
    return [each.arrived_at for _, each in found], again


def test_all_messages_in_order() -> None:
    outbox, flow, woken = made()
    other = TopicQueue("/other")
    other.add_subscription(add_subscription())
    outbox.add(other)
    for number in range(10):
        outbox.put((flow, other)[number % 2], arrival(number))
    assert len(woken) == 10
    assert times(outbox, 0.0) == ([*range(10)], None)
    assert times(outbox, 0.0) == ([], None)


def test_the_newest_stay() -> None:
    outbox, flow, _ = made()
    for number in range(2 * MAX_MESSAGES):
        outbox.put(flow, arrival(number))
    assert times(outbox, 0.0)[0] == [*range(MAX_MESSAGES, 2 * MAX_MESSAGES)]
    outbox, flow, _ = made(add_subscription(queue_length=2))
    for number in range(10):
        outbox.put(flow, arrival(number))
    assert times(outbox, 0.0)[0] == [8, 9]


def test_large_messages() -> None:
    outbox, flow, _ = made()
    for number in range(10):
        outbox.put(flow, arrival(number, MAX_BYTES // 2))
    assert flow.size <= MAX_BYTES
    assert times(outbox, 0.0)[0] == [8]  # one at a time: others may come in between
    outbox.put(flow, arrival(20, 2 * MAX_BYTES))
    assert times(outbox, 0.0)[0] == [20]


def test_many_topics_with_large_messages() -> None:
    outbox, _, _ = made()
    flows = [TopicQueue(str(number)) for number in range(20)]
    for flow in flows:
        flow.add_subscription(add_subscription())
        outbox.add(flow)
        for number in range(10):
            outbox.put(flow, arrival(number, MAX_BYTES // 4))
    assert sum(flow.size for flow in flows) <= MAX_TOTAL_BYTES + len(flows) * MAX_BYTES // 4
    assert all(flow.messages[-1].arrived_at == 9 for flow in flows)


def test_throttle() -> None:
    outbox, flow, _ = made(add_subscription(throttle=0.1))
    for number in range(3):
        outbox.put(flow, arrival(number))
    assert times(outbox, 1.0) == ([2], None)
    outbox.put(flow, arrival(3))
    assert times(outbox, 1.05) == ([], 1.1)
    outbox.put(flow, arrival(4))
    assert times(outbox, 1.1) == ([4], None)


def test_throttle_with_a_queue() -> None:
    outbox, flow, _ = made(add_subscription(throttle=0.1, queue_length=2))
    for number in range(3):
        outbox.put(flow, arrival(number))
    assert times(outbox, 1.0) == ([1], 1.1)
    assert times(outbox, 1.1) == ([2], None)


def test_wishes_together() -> None:
    outbox, flow, _ = made(
        add_subscription(key="a", throttle=0.5, queue_length=1, fragment_size=100, compression="png"),
        add_subscription(key="b", throttle=0.2, queue_length=5, compression="cbor"),
    )
    assert (flow.throttle_period, flow.max_length, flow.fragment_size, flow.compression) == (0.2, 5, 100, "cbor")
    outbox.put(flow, arrival(1))
    outbox.take(1.0)
    flow.remove_subscription("b")
    assert (flow.throttle_period, flow.max_length, flow.compression) == (0.5, 1, "png")
    outbox.put(flow, arrival(2))
    assert times(outbox, 1.4) == ([], 1.5)
    flow.add_subscription(add_subscription(key="c"))
    assert times(outbox, 1.4) == ([2], None)


def test_a_message_that_comes_twice() -> None:
    outbox, flow, _ = made()
    one = arrival(1)
    outbox.put(flow, one)
    outbox.put(flow, one)
    assert times(outbox, 0.0)[0] == [1]


def test_answers() -> None:
    outbox, flow, _ = made()
    outbox.put(flow, arrival(1))
    outbox.enqueue("x" * MAX_FRAME_BYTES)
    assert not outbox.is_full()
    outbox.enqueue("y")
    assert outbox.is_full()
    told, found, _ = outbox.take(0.0)
    assert (len(told), len(found)) == (2, 1)
    assert not outbox.is_full()
    outbox.remove(flow)
    outbox.put(flow, arrival(2))
    assert outbox.take(0.0) == ([], [], None)


def test_topics_with_large_messages_take_turns() -> None:
    outbox, flow, _ = made()
    other = TopicQueue("/other")
    other.add_subscription(add_subscription())
    outbox.add(other)
    turns = []
    for now in range(6):
        for queue in (flow, other):
            outbox.put(queue, arrival(now, size=1_100_000))
        turns.append([queue.name for queue, _ in outbox.take(float(now))[1]])
    assert turns == [["/t"], ["/other"]] * 3


def free(*requests: Subscribe) -> tuple[Outbox, TopicQueue, list[None]]:
    outbox, flow, woken = made(*requests)
    outbox.release()
    assert outbox.is_free
    return outbox, flow, woken


def test_a_message_is_sent_past_the_queue_if_nothing_is_there() -> None:
    outbox, flow, woken = free()
    first, second = arrival(1), arrival(2)
    assert not outbox.put(flow, first) and woken  # not wanted
    assert times(outbox, 0.0) == ([1], None)
    outbox.release()
    woken.clear()
    assert not outbox.put(flow, first, may_send=True)  # it comes twice
    assert outbox.put(flow, second, may_send=True)
    assert not outbox.put(flow, second, may_send=True)
    outbox.end_sending(flow, None, 5.0)
    assert times(outbox, 9.0) == ([], None) and not woken
    assert flow.next_time == 5.0 and flow.size == 0
    outbox.release()
    assert outbox.put(flow, arrival(3), may_send=True)


def test_what_comes_while_a_message_is_sent_waits() -> None:
    outbox, flow, woken = free()
    assert outbox.put(flow, arrival(1), may_send=True)
    assert not outbox.put(flow, arrival(2), may_send=True)
    outbox.enqueue("a response")
    outbox.release()
    assert outbox.take(9.0) == ([], [], None) and not woken  # it would overtake the first
    outbox.end_sending(flow, None, 5.0)
    assert len(woken) == 1
    assert not outbox.put(flow, arrival(3), may_send=True)
    responses, found, again = outbox.take(9.0)
    assert (responses, [each.arrived_at for _, each in found], again) == (["a response"], [2, 3], None)
    assert not outbox.put(flow, arrival(4), may_send=True)  # those that were taken may not be sent yet
    outbox.release()
    assert not outbox.is_free  # the fourth waits
    assert times(outbox, 9.0)[0] == [4]
    outbox.enqueue("another response")
    outbox.release()
    assert not outbox.is_free
    assert outbox.take(9.0)[0]
    outbox.release()
    assert outbox.is_free


def test_a_message_that_could_not_be_sent_waits_before_later_ones() -> None:
    outbox, flow, woken = free()
    unsent = arrival(1)
    assert outbox.put(flow, unsent, may_send=True)
    outbox.put(flow, arrival(2))
    outbox.end_sending(flow, unsent, 5.0)
    assert len(woken) == 1 and flow.size == 2
    assert times(outbox, 0.0) == ([1, 2], None)
    outbox.release()
    unsent = arrival(3)
    assert outbox.put(flow, unsent, may_send=True)
    outbox.end_sending(flow, unsent, 5.0)
    assert len(woken) == 2
    assert times(outbox, 0.0) == ([3], None)


def test_a_message_that_could_not_be_sent_is_dropped_like_any_other() -> None:
    outbox, flow, _ = free(add_subscription(queue_length=2))
    unsent = arrival(1)
    assert outbox.put(flow, unsent, may_send=True)
    for number in (2, 3):
        outbox.put(flow, arrival(number))
    outbox.end_sending(flow, unsent, 5.0)
    assert times(outbox, 0.0)[0] == [2, 3]


def test_throttled_messages_and_those_of_no_subscription_are_not_sent_past_the_queue() -> None:
    outbox, flow, _ = free(add_subscription(throttle=1.0))
    assert not outbox.put(flow, arrival(1), may_send=True)
    assert times(outbox, 0.0) == ([1], None)
    outbox, flow, _ = free()
    outbox.remove(flow)
    assert not outbox.put(flow, arrival(1), may_send=True)
