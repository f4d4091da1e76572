"""lookups: where nodes are, with as few calls of the master as possible."""

from __future__ import annotations

from collections import deque
from typing import Any

import pytest

from pyros1.ground.errors import DeadlineError, XmlRpcFault
from pyros1.node.watching.lookups import Lookups


class Bench:
    """A loop and a caller of methods whose calls the test answers."""

    def __init__(self) -> None:
        self.soon: deque[Any] = deque()
        self.calls: list[tuple[str, Any, Any]] = []
        self.told: list[tuple[str, str]] = []
        self.lookups = Lookups(self, self, "/me", "http://master:1/")  # type: ignore[arg-type]  # both are this

    def call_soon(self, function: Any, *args: Any) -> None:
        self.soon.append(function)

    def call(self, uri: str, method: str, params: Any, on_done: Any, timeout: float) -> None:
        assert uri == "http://master:1/" and timeout > 0
        self.calls.append((method, params, on_done))

    def ask(self, *names: str) -> None:
        for name in names:
            self.lookups.look_up(name, lambda uri, name=name: self.told.append((name, uri)))  # type: ignore[misc]
        while self.soon:
            self.soon.popleft()()

    def names(self) -> list[str]:
        """Return what the last call asks for."""
        method, params, _ = self.calls[-1]
        if method == "lookupNode":
            assert params[0] == "/me"
            return [params[1]]
        return [call["params"][1] for call in params[0]]

    def answer(self, *replies: Any, error: Any = None) -> None:
        """Answer the last call: with a URI, or None for a node that the master does not know, for each name."""
        wrapped = [[1, "", uri] if uri else [-1, "unknown node", ""] for uri in replies]
        single = self.calls[-1][0] == "lookupNode"
        value = None if error else wrapped[0] if single else [[each] for each in wrapped]
        self.calls[-1][2](value, error)


@pytest.fixture
def bench() -> Bench:
    return Bench()


def test_all_that_are_wanted_together_are_one_call(bench: Bench) -> None:
    bench.ask("/a", "/b", "/a")
    assert bench.names() == ["/a", "/b"]
    bench.answer("A", None)
    assert bench.told == [("/a", "A"), ("/a", "A")], "nothing for the one that is not known"
    bench.ask("/c")
    assert bench.names() == ["/c"] and len(bench.calls) == 2
    bench.answer("C")
    assert bench.told[2:] == [("/c", "C")]


def test_what_is_wanted_meanwhile_waits_for_the_answer(bench: Bench) -> None:
    bench.ask("/a")
    for _ in range(100):
        bench.ask("/a", "/b")
    assert len(bench.calls) == 1
    bench.answer(error=DeadlineError("the master hangs"))
    assert bench.names() == ["/a", "/b"] and len(bench.calls) == 2 and not bench.told
    bench.answer("A", "B")
    assert {name for name, _ in bench.told} == {"/a", "/b"} and len(bench.calls) == 2


def test_a_master_without_multicall_is_asked_one_by_one(bench: Bench) -> None:
    bench.ask("/a", "/b", "/c")
    bench.answer(error=XmlRpcFault(1, "no such method"))
    for _ in range(3):
        (name,) = bench.names()
        bench.answer(name.upper())
    assert bench.told == [("/a", "/A"), ("/b", "/B"), ("/c", "/C")] and len(bench.calls) == 4


@pytest.mark.parametrize("reply", [None, 5, [], [[]], [[1, "", "A"]], [[[1, "", 5]], 5], [[[1, ""]], [[0, "", "A"]]]])
def test_answers_that_are_none(bench: Bench, reply: Any) -> None:
    bench.ask("/a", "/b")
    bench.calls[-1][2](reply, None)
    assert bench.told == []
    bench.ask("/a")
    assert bench.names() == ["/a"]
