"""Lists between sites."""

from __future__ import annotations

from itertools import count

from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.packets import PAGE_ENTRIES, Page, Request, decode_request
from pyros1.bridge.protocol.versioned_lists import ListReceiver, ListSender


def test_a_list_is_repeated_until_it_was_seen() -> None:
    versions = count(1)
    sender, other = ListSender(versions), ListSender(versions)
    assert (sender.version, other.version) == (1, 2)
    assert sender.is_due(-1, 0.0) and not sender.is_due(-1, 0.1) and sender.is_due(-1, 1.0)
    assert not sender.is_due(1, 5.0)
    sender.update([1])
    assert sender.version == 3 and sender.is_due(1, 5.0)
    sender.update([1])
    assert sender.version == 3


def test_pages_come_in_any_order() -> None:
    receiver = ListReceiver()
    assert receiver.accept(Page(5, 1, 2, ["b"])) is None
    assert receiver.accept(Page(5, 1, 2, ["b"])) is None
    assert receiver.accept(Page(5, 0, 2, ["a"])) == ["a", "b"]
    assert receiver.version == 5
    assert receiver.accept(Page(5, 0, 1, ["x"])) is None and receiver.accept(Page(4, 0, 1, ["x"])) is None


def test_pages_of_versions_are_not_mixed() -> None:
    receiver = ListReceiver()
    receiver.accept(Page(5, 0, 2, ["old"]))
    assert receiver.accept(Page(6, 1, 2, ["b"])) is None
    assert receiver.accept(Page(5, 1, 2, ["old"])) is None
    assert receiver.accept(Page(6, 0, 2, ["a"])) == ["a", "b"]
    receiver.accept(Page(7, 0, 3, ["x"]))
    assert receiver.accept(Page(7, 1, 2, ["b"])) is None  # another number of pages: the list begins again
    assert receiver.accept(Page(7, 0, 2, ["a"])) == ["a", "b"]


def test_a_network_that_takes_only_a_few_pages_gets_all_in_the_end() -> None:
    sender, receiver = ListSender(count(1)), ListReceiver()
    entries = [Request(SharedName("red", f"/t{number}"), 0.0) for number in range(PAGE_ENTRIES * 12)]
    sender.update(entries)
    completed = []
    for _ in range(12):
        pages = sender.pages()
        assert len(pages) == 12
        completed += [receiver.accept(decode_request(body)) for body in pages[:3]]
    assert [entries for entries in completed if entries is not None] == [entries]
