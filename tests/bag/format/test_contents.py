"""bag.format.contents: messages in order of time."""

from __future__ import annotations

import struct

import pytest

from pyros1.bag.format.contents import Messages, read_content
from pyros1.bag.format.records import RecordError, message_record_prefix


@pytest.mark.parametrize(
    ("times", "ranks", "order"),
    [
        ([1, 2, 3], {0: 0, 1: 1}, [0, 1, 2]),
        ([3, 1, 2], {0: 0, 1: 1}, [1, 2, 0]),
        ([2, 2, 1], {0: 1, 1: 0}, [2, 1, 0]),
        ([2, 1, 1, 2], {0: 1, 1: 0}, [1, 2, 3, 0]),
        ([2, 1, 1, 2], {0: 0, 1: 1}, [2, 1, 0, 3]),
        ([2, 1, 3, 2], {0: 1, 1: 0}, [1, 3, 0, 2]),
        ([2, 1, 3, 2], None, [1, 0, 3, 2]),
    ],
)
def test_messages_of_the_same_time_are_in_the_order_of_their_ranks(
    times: list[int], ranks: dict[int, int] | None, order: list[int]
) -> None:
    messages = Messages()
    for index, time in enumerate(times):
        messages.add(index % 2, time, index, index, index)
    assert list(messages.sorted_by_time(ranks).offsets) == order


@pytest.mark.parametrize("extra", [b"", b"x=1"])
def test_messages_may_have_more_fields_than_those_that_pyros1_writes(extra: bytes) -> None:
    field = struct.pack("<I", len(extra)) + extra if extra else b""
    fields = message_record_prefix(7)[4:] + struct.pack("<II", 5, 6) + field
    record = struct.pack("<I", len(fields)) + fields + struct.pack("<I", 3) + b"abc"
    messages, connections = read_content(2 * record)
    assert list(messages.conns) == [7, 7] and list(messages.times) == [5_000_000_006] * 2 and not connections
    assert [(2 * record)[start:end] for start, end in zip(messages.starts, messages.ends, strict=True)] == [b"abc"] * 2


def test_a_message_record_whose_second_half_is_damaged_is_refused() -> None:
    fields = message_record_prefix(7)[4:] + struct.pack("<II", 5, 6)
    damaged = fields.replace(b"time=", b"tame=")
    assert damaged != fields and len(damaged) == 38
    with pytest.raises(RecordError, match="at byte 0 of the chunk's content"):
        read_content(struct.pack("<I", 38) + damaged + struct.pack("<I", 3) + b"abc")
