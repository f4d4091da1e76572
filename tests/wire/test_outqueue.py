"""outqueue: order kept, whole frames only, oldest dropped, over any interleaving of push, partial send and limit."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.wire.outqueue import OutQueue, frame_size


def as_bytes(frame: object) -> bytes:
    return frame if isinstance(frame, bytes) else b"".join(bytes(part) for part in frame)  # type: ignore[attr-defined]


frames = st.one_of(
    st.binary(min_size=1, max_size=9),
    st.lists(st.binary(min_size=1, max_size=5).map(bytearray), min_size=1, max_size=3),
)
steps = st.lists(
    st.one_of(st.tuples(st.just("push"), frames), st.tuples(st.just("send"), st.integers(1, 30))), max_size=60
)


@pytest.mark.slow
@given(steps, st.one_of(st.none(), st.integers(0, 4)))
def test_any_interleaving_sends_whole_frames_in_order(actions: list, limit: int | None) -> None:
    queue = OutQueue(limit)
    waiting: list[bytes] = []  # the model: frames that may still be dropped
    begun = b""
    expected = b""
    wire = b""
    dropped = 0
    for action, value in actions:
        if action == "push":
            queue.push(value)
            waiting.append(as_bytes(value))
            if limit and len(waiting) > limit:
                waiting.pop(0)
                dropped += 1
        else:
            data = b"".join(bytes(part) for part in queue.buffers())[:value]
            if not data:
                assert not len(queue)
                continue
            queue.sent_bytes = len(data)
            queue.discard_sent()
            wire += data
            count = len(data)
            while count:
                if not begun:
                    begun = waiting.pop(0)
                part = begun[:count]
                expected += part
                begun = begun[len(part) :]
                count -= len(part)
        assert len(queue) == len(waiting) + bool(begun)
        assert queue.dropped == dropped
        assert wire == expected
    remainder = b"".join(bytes(part) for part in queue.buffers())
    assert remainder == begun + b"".join(waiting)


@given(frames, st.integers(0, 40))
def test_a_begun_frame_is_finished_before_all_others(frame: object, sent: int) -> None:
    data = as_bytes(frame)
    queue = OutQueue(1)
    queue.push_partial(frame, sent)  # type: ignore[arg-type]
    queue.push(b"x")
    queue.push(b"y")
    assert b"".join(bytes(part) for part in queue.buffers()) == data[sent:] + b"y"
    assert queue.dropped == 1


def test_memory_that_may_change_is_copied_when_kept() -> None:
    array = bytearray(b"abc")
    queue = OutQueue(None)
    queue.push([b"1", array])
    array[:] = b"xyz"
    assert b"".join(queue.buffers()) == b"1abc"


def test_buffers_are_bounded_and_clear_forgets() -> None:
    queue = OutQueue(0)
    for _ in range(600):
        queue.push(b"z")
    assert len(queue.buffers(256)) == 256
    queue.clear()
    assert not len(queue)


def test_frame_size_counts_bytes_of_all_parts() -> None:
    assert frame_size(b"abc") == 3
    assert frame_size([b"ab", memoryview(bytearray(5))]) == 7


def test_what_remains_of_a_frame_is_not_copied_with_each_send() -> None:
    frame = bytes(1000)
    queue = OutQueue(None)
    queue.push_partial(frame, 10)
    for _ in range(5):
        queue.sent_bytes = 10
        queue.discard_sent()
    [remainder] = queue.buffers()
    assert isinstance(remainder, memoryview) and remainder.obj is frame and len(remainder) == 940


def test_what_its_owner_may_change_is_copied_once() -> None:
    parts = [bytearray(b"abc"), memoryview(b"def"), memoryview(bytearray(b"ghi"))]
    queue = OutQueue(None)
    queue.push_partial(list(parts), 1)
    queue.push(list(parts))
    parts[0][0] = parts[0][1] = parts[2][0] = ord("x")  # type: ignore[index]
    assert as_bytes(queue.buffers()) == b"bcdefghiabcdefghi"
    first = queue.buffers()[0]
    queue.sent_bytes = 1
    queue.discard_sent()
    assert queue.buffers()[0] == b"c" and first == b"bc"
