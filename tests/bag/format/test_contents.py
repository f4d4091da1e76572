"""bag.format.contents: messages in order of time."""

from __future__ import annotations

import pytest

from pyros1.bag.format.contents import Messages


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
