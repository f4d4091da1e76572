"""queues: the messages of one receive, in parts; the newest messages of each source, one source after the other."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from pyros1.node.subscribing.queues import Backlog, Batch, Frames, Inbox, InboxSet, Items


@given(st.integers(1, 5), st.lists(st.tuples(st.sampled_from("abc"), st.integers())))
def test_each_source_keeps_its_newest_and_the_rest_is_counted(limit: int, entries: list[tuple[str, int]]) -> None:
    backlog: Any = Backlog(limit)
    for source, item in entries:
        backlog.put(source, item)
    taken: dict[str, list[int]] = {}
    while backlog:
        source, item = backlog.take()
        taken.setdefault(source, []).append(item)
    expected = {source: [item for other, item in entries if other == source][-limit:] for source, _ in entries}
    assert taken == expected
    assert backlog.dropped == len(entries) - sum(map(len, taken.values()))


def test_sources_take_turns() -> None:
    backlog: Any = Backlog(3)
    for source, item in (("a", 1), ("a", 2), ("a", 3), ("b", 4), ("b", 5)):
        backlog.put(source, item)
    assert [backlog.take() for _ in range(5)] == [("a", 1), ("b", 4), ("a", 2), ("b", 5), ("a", 3)]


class Receiver:
    """Notes what is delivered to it."""

    def __init__(self) -> None:
        self.got: list[bytes] = []

    def deliver_frame(self, _: Any, data: bytes, start: int, end: int) -> None:
        self.got.append(data[start:end])

    def deliver_item(self, _: Any, item: bytes) -> None:
        self.got.append(item)


def frames_of(bodies: list[bytes]) -> Batch:
    data, frames = b"", []
    for body in bodies:
        frames.append((len(data) + 4, len(data) + 4 + len(body)))
        data += b"size" + body
    return Frames(LINK, data, frames)


LINK: Any = "link"
BODIES = st.lists(st.binary(max_size=3), max_size=8)
KINDS = st.sampled_from([frames_of, lambda bodies: Items(LINK, bodies)])


@given(KINDS, BODIES, st.lists(st.integers(1, 4), max_size=4), st.integers(1, 4))
def test_messages_of_one_receive_are_delivered_in_parts(
    kind: Any, bodies: list[bytes], counts: list[int], limit: int
) -> None:
    batch, receiver = kind(bodies), Receiver()
    done = 0
    for count in counts:
        done += count
        assert batch.deliver(receiver, count) == (done < len(bodies))
    assert receiver.got == bodies[:done]
    assert batch.newest(limit) == bodies[done:][-limit:]
    backlog = Backlog(limit)
    backlog.put_batch(batch)
    kept = []
    while backlog:
        kept.append(backlog.take())
    assert kept == [(LINK, body) for body in bodies[done:][-limit:]]
    assert backlog.dropped == max(0, len(bodies) - done - limit)


@given(KINDS, BODIES, st.integers(1, 4))
def test_messages_are_delivered_until_a_time(kind: Any, bodies: list[bytes], count: int) -> None:
    """The one before which the time has passed is the last; then there may be none left."""
    batch, receiver = kind(bodies), Receiver()
    batch.deliver(receiver, count)
    assert batch.deliver_until(receiver, float("-inf")) == (len(bodies) > count)
    assert receiver.got == bodies[: count + 1]
    assert not batch.deliver_until(receiver, float("inf"))
    assert receiver.got == bodies and batch.newest(1) == []


def test_room_that_is_made_just_before_the_wait_ends_it() -> None:
    """Nobody tells a thread of it that does not wait yet."""
    inboxes, inbox = InboxSet(), Inbox(LINK)
    inbox.put(b"old", None)
    looks: list[Any] = []

    def has_ended() -> bool:
        looks.append(inbox.take())  # as another thread would meanwhile
        return False

    inboxes.wait_for_room(inbox, 1, has_ended)
    assert looks == [b"old"]
