"""node.parameters.cache: which copies are up to date. That they end alike with the master is tested with one."""

from __future__ import annotations

from pyros1.node.parameters.cache import MISSING, ParameterCache


def cache_of(**values: object) -> ParameterCache:
    cache = ParameterCache()
    for name, value in values.items():
        cache.complete_fetch(cache.begin_fetch(f"/{name}"), value)
    return cache


def test_an_invalidated_copy_is_fetched_again() -> None:
    cache = cache_of(a={"b": 1}, other=2)
    before = cache.versions()
    cache.invalidate("/a/b")
    assert (cache.get("/a"), cache.get("/other")) == (MISSING, 2)
    assert cache.versions() != before, "a change that was under way must notice it"
    cache.complete_fetch(cache.begin_fetch("/a"), 3)
    assert cache.get("/a") == 3


def test_a_value_that_is_fetched_meanwhile_is_in_doubt() -> None:
    cache = cache_of()
    fetch, other = cache.begin_fetch("/a"), cache.begin_fetch("/other")
    assert cache.is_affected_by("/a/b") and not cache.is_affected_by("/b")
    cache.invalidate("/a/b")
    cache.invalidate("/b")
    cache.complete_fetch(fetch, 1)
    cache.complete_fetch(other, 2)
    assert (cache.get("/a"), cache.get("/other")) == (MISSING, 2)


def test_a_parameter_that_another_node_deletes_is_in_no_copy() -> None:
    cache = cache_of(a={"b": 1, "c": {"d": 2}, "e": 3})
    cache.set_remotely("/a/b", {})
    cache.set_remotely("/a/c/d", {})
    assert cache.get("/a") == {"e": 3}


def test_own_changes_make_a_fetched_value_doubtful() -> None:
    cache = cache_of()
    fetch, other = cache.begin_fetch("/a"), cache.begin_fetch("/other")
    cache.set_locally("/a", 1, cache.versions())
    cache.set_locally("/b", 1, cache.versions())
    cache.complete_fetch(fetch, 1)
    cache.complete_fetch(other, 2)
    assert (cache.get("/a"), cache.get("/other")) == (MISSING, 2)


def test_too_many_changes_are_not_kept() -> None:
    for count, found in ((1000, 1000), (1001, MISSING), (1500, MISSING)):
        cache = cache_of()
        fetch = cache.begin_fetch("/a")
        for number in range(1, count + 1):
            cache.set_remotely("/a", number)
        assert len(fetch.changes) <= 1000
        cache.complete_fetch(fetch, 0)
        assert cache.get("/a") == found


def test_a_fetch_that_failed_leaves_nothing() -> None:
    cache = cache_of()
    cache.abort_fetch(cache.begin_fetch("/a"))
    assert not cache.is_affected_by("/a") and cache.get("/a") is MISSING and cache.names() == []


def test_a_dropped_copy_is_forgotten() -> None:
    cache = cache_of(a=1, b=2)
    cache.set_locally("/a", 5, cache.versions())
    cache.drop("/a")
    assert (cache.get("/a"), cache.names(), list(cache.versions())) == (MISSING, ["/b"], ["/b"])
    # What the node has set is forgotten with it, so the next change by another node is believed.
    cache.complete_fetch(cache.begin_fetch("/a"), 6)
    cache.set_remotely("/a", 7)
    assert cache.get("/a") == 7


def test_a_change_of_another_parameter_does_not_concern_a_fetch() -> None:
    cache = cache_of(other=1)
    fetch = cache.begin_fetch("/a")
    cache.set_remotely("/other", 2)
    assert not fetch.changes
    cache.complete_fetch(fetch, 3)
    assert (cache.get("/a"), cache.get("/other")) == (3, 2)


def test_what_the_node_has_set_elsewhere_is_not_forgotten_with_a_copy() -> None:
    cache = cache_of(a=1, b=2)
    cache.set_locally("/b", 5, cache.versions())
    cache.drop("/a")
    fetch = cache.begin_fetch("/b")
    cache.set_remotely("/b", 2)  # which of the two was first, only the master knows
    cache.complete_fetch(fetch, 5)
    assert cache.get("/b") is MISSING
