"""queue: between the threads that receive and the one that writes."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pyros1.bag.record.queue import MESSAGE_OVERHEAD, RecordQueue

LIMIT = 4 * MESSAGE_OVERHEAD


@given(st.lists(st.integers(0, 2 * LIMIT), max_size=20), st.booleans())
def test_the_newest_are_kept_in_order_and_the_others_counted(sizes: list[int], at_end: bool) -> None:
    """As many as have room; the last one in any case, however large."""
    came: list[int] = []
    dropped: list[int] = []
    queue: RecordQueue[int] = RecordQueue(LIMIT, lambda source, _: came.append(source), dropped.append)
    for number, size in enumerate(sizes):
        assert queue.put(number, number, bytes(size))
    messages_at: list[int] = []
    for number in reversed(range(len(sizes))):
        if messages_at and sum(sizes[each] + MESSAGE_OVERHEAD for each in [number, *messages_at]) > LIMIT:
            break
        messages_at.insert(0, number)
    found = queue.close() if at_end else queue.take(0.0)
    assert [source for source, _, _ in found] == [time for _, time, _ in found] == messages_at
    assert [len(data) for _, _, data in found] == [sizes[each] for each in messages_at]
    assert came == list(range(len(sizes))) and dropped == [each for each in came if each not in messages_at]


def test_without_a_limit_nothing_is_dropped() -> None:
    dropped: list[int] = []
    queue: RecordQueue[int] = RecordQueue(0, lambda *_: None, dropped.append)
    for number in range(100):
        queue.put(number, number, bytes(1000))
    queue.wake()
    assert [source for source, _, _ in queue.take(10.0)] == list(range(100)) and not dropped
    queue.close()
    assert not queue.put(1, 1, b"")
