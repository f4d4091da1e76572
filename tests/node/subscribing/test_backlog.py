"""backlog: the newest messages of each source, one source after the other."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from pyros1.node.subscribing.backlog import Backlog


@given(st.integers(1, 5), st.lists(st.tuples(st.sampled_from("abc"), st.integers())))
def test_each_source_keeps_its_newest_and_the_rest_is_counted(limit: int, entries: list[tuple[str, int]]) -> None:
    backlog: Backlog[str, int] = Backlog(limit)
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
    backlog: Backlog[str, int] = Backlog(3)
    for source, item in (("a", 1), ("a", 2), ("a", 3), ("b", 4), ("b", 5)):
        backlog.put(source, item)
    assert [backlog.take() for _ in range(5)] == [("a", 1), ("b", 4), ("a", 2), ("b", 5), ("a", 3)]
