"""Which nodes respond: those that a master knows may be dead."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from pyros1.bridge.publisher_watch import PublisherWatch
from pyros1.node import Node

from .conftest import wait_until

MakeNode = Callable[..., Node]


@pytest.fixture
def changes() -> threading.Semaphore:
    return threading.Semaphore(0)


@pytest.fixture
def watch(make_node: MakeNode, changes: threading.Semaphore) -> Iterator[PublisherWatch]:
    watch = PublisherWatch(make_node("bridge"), 1.0, changes.release)
    yield watch
    watch.close()


def test_a_node_comes_goes_and_returns(
    watch: PublisherWatch, make_node: MakeNode, changes: threading.Semaphore
) -> None:
    first = make_node("talker")
    watch.update(["/talker"], ["/talker"])
    assert changes.acquire(timeout=20)
    assert (watch.responding, watch.lost) == ({"/talker"}, set())
    first.shutdown()
    assert changes.acquire(timeout=20)
    assert (watch.responding, watch.lost) == (set(), {"/talker"})
    watch.update([], ["/talker"])  # nobody wants it now, but it is still registered
    assert watch.lost == {"/talker"}
    make_node("talker")
    assert changes.acquire(timeout=20)
    assert (watch.responding, watch.lost) == ({"/talker"}, set())
    watch.update([], [])
    assert (watch.responding, watch.lost) == (set(), set())


def test_nodes_whose_names_are_not_legal_are_left_out(
    watch: PublisherWatch, make_node: MakeNode, changes: threading.Semaphore
) -> None:
    make_node("talker")
    names = ["/my-node", "talker", "/", "", "/talker"]
    watch.update(names, names)
    assert changes.acquire(timeout=20)
    assert watch.responding == {"/talker"}


def test_a_node_that_is_found_before_it_is_known_to_be_watched(
    make_node: MakeNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    node, _ = make_node("bridge"), make_node("talker")
    watch_node = node.watch

    def watch_slowly(name: str, *callbacks: Callable[[Any], object], **options: float) -> Any:
        told = threading.Event()

        def tell(sighting: Any) -> None:
            callbacks[0](sighting)
            told.set()

        watched = watch_node(name, tell, tell, **options)
        assert told.wait(20)
        return watched

    monkeypatch.setattr(node, "watch", watch_slowly)
    watch = PublisherWatch(node, 1.0, lambda: None)
    watch.update(["/talker"], ["/talker"])
    assert watch.responding == {"/talker"}
    watch.close()


def test_a_node_that_was_never_found_is_not_lost(watch: PublisherWatch) -> None:
    watch.update(["/nobody"], ["/nobody"])
    assert (watch.responding, watch.lost) == (set(), set())


def test_a_node_that_is_lost_just_when_it_is_watched_no_longer(
    make_node: MakeNode, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If it counted as lost for good, its topics would be left out for good, when a node of that name starts."""
    node = make_node("bridge")
    callbacks: list[Callable[[Any], object]] = []

    class Fake:
        def __init__(self, _: str, callback: Callable[[Any], object], *__: object, **___: object) -> None:
            callbacks.append(callback)

        def close(self) -> None:
            pass

    class Lost:
        name = "/talker"

        @property
        def alive(self) -> bool:
            watch.update((), ())
            return False

    monkeypatch.setattr(node, "watch", Fake)
    watch = PublisherWatch(node, 1.0, lambda: None)
    watch.update(["/talker"], ["/talker"])
    callbacks[0](Lost())
    assert (watch.responding, watch.lost) == (set(), set())


def test_there_are_not_too_many(watch: PublisherWatch, make_node: MakeNode, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.publisher_watch.MAX_WATCHED", 1)
    names = ["/left", "/right"]
    nodes = [make_node(name[1:]) for name in names]
    watch.update(names, names)
    wait_until(lambda: watch.responding == {"/left"}, "the first one is watched")
    nodes[0].shutdown()
    watch.update(["/right"], ["/right"])
    wait_until(lambda: watch.responding == {"/right"}, "the second one takes its place")
