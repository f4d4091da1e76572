"""What waits for a slow client: bounded, and the newest."""

from __future__ import annotations

from typing import Any

from pyros1.msgs import AnyMsg
from pyros1.observe.decoder import Decoder
from pyros1.web.hub import Arrival
from pyros1.web.rosbridge.operations import Subscribe
from pyros1.web.rosbridge.outbox import MOST_BYTES, MOST_MESSAGES, MOST_OF_ALL, MOST_TOLD, Flow, Outbox


def arrival(at: float = 0.0, size: int = 1) -> Arrival:
    return Arrival(AnyMsg(bytes(size)), at, at, Decoder())


def wish(**given: Any) -> Subscribe:
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


def made(*wishes: Subscribe) -> tuple[Outbox, Flow, list[None]]:
    woken: list[None] = []
    outbox, flow = Outbox(lambda: woken.append(None)), Flow("/t")
    for each in wishes or (wish(),):
        flow.wish(each)
    outbox.add(flow)
    return outbox, flow, woken


def times(outbox: Outbox, now: float) -> tuple[list[float], float | None]:
    _, found, again = outbox.take(now)
    return [each.at for _, each in found], again


def test_all_messages_in_order() -> None:
    outbox, flow, woken = made()
    other = Flow("/other")
    other.wish(wish())
    outbox.add(other)
    for number in range(10):
        outbox.put((flow, other)[number % 2], arrival(number))
    assert len(woken) == 10
    assert times(outbox, 0.0) == ([*range(10)], None)
    assert times(outbox, 0.0) == ([], None)


def test_the_newest_stay() -> None:
    outbox, flow, _ = made()
    for number in range(2 * MOST_MESSAGES):
        outbox.put(flow, arrival(number))
    assert times(outbox, 0.0)[0] == [*range(MOST_MESSAGES, 2 * MOST_MESSAGES)]
    outbox, flow, _ = made(wish(queue_length=2))
    for number in range(10):
        outbox.put(flow, arrival(number))
    assert times(outbox, 0.0)[0] == [8, 9]


def test_large_messages() -> None:
    outbox, flow, _ = made()
    for number in range(10):
        outbox.put(flow, arrival(number, MOST_BYTES // 2))
    assert flow.size <= MOST_BYTES
    assert times(outbox, 0.0)[0] == [8]  # one at a time: others may come in between
    outbox.put(flow, arrival(20, 2 * MOST_BYTES))
    assert times(outbox, 0.0)[0] == [20]


def test_many_topics_with_large_messages() -> None:
    outbox, _, _ = made()
    flows = [Flow(str(number)) for number in range(20)]
    for flow in flows:
        flow.wish(wish())
        outbox.add(flow)
        for number in range(10):
            outbox.put(flow, arrival(number, MOST_BYTES // 4))
    assert sum(flow.size for flow in flows) <= MOST_OF_ALL + len(flows) * MOST_BYTES // 4
    assert all(flow.waiting[-1].at == 9 for flow in flows)


def test_throttle() -> None:
    outbox, flow, _ = made(wish(throttle=0.1))
    for number in range(3):
        outbox.put(flow, arrival(number))
    assert times(outbox, 1.0) == ([2], None)
    outbox.put(flow, arrival(3))
    assert times(outbox, 1.05) == ([], 1.1)
    outbox.put(flow, arrival(4))
    assert times(outbox, 1.1) == ([4], None)


def test_throttle_with_a_queue() -> None:
    outbox, flow, _ = made(wish(throttle=0.1, queue_length=2))
    for number in range(3):
        outbox.put(flow, arrival(number))
    assert times(outbox, 1.0) == ([1], 1.1)
    assert times(outbox, 1.1) == ([2], None)


def test_wishes_together() -> None:
    outbox, flow, _ = made(
        wish(key="a", throttle=0.5, queue_length=1, fragment_size=100, compression="png"),
        wish(key="b", throttle=0.2, queue_length=5, compression="cbor"),
    )
    assert (flow.throttle, flow.most, flow.fragment_size, flow.compression) == (0.2, 5, 100, "cbor")
    outbox.put(flow, arrival(1))
    outbox.take(1.0)
    flow.unwish("b")
    assert (flow.throttle, flow.most, flow.compression) == (0.5, 1, "png")
    outbox.put(flow, arrival(2))
    assert times(outbox, 1.4) == ([], 1.5)
    flow.wish(wish(key="c"))
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
    outbox.tell("x" * MOST_TOLD)
    assert not outbox.is_full()
    outbox.tell("y")
    assert outbox.is_full()
    told, found, _ = outbox.take(0.0)
    assert (len(told), len(found)) == (2, 1)
    assert not outbox.is_full()
    outbox.remove(flow)
    outbox.put(flow, arrival(2))
    assert outbox.take(0.0) == ([], [], None)
