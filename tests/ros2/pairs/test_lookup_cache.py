"""What is remembered of types that were looked up, however many a ROS 2 program names."""

from __future__ import annotations

import gc
import weakref

import pytest

from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.ros2.pairs import lookup_cache
from pyros1.ros2.pairs.lookup_cache import LookupCache, TimeBudget


class Lookup:
    """A lookup that takes time, on a clock of its own."""

    def __init__(self) -> None:
        self.now = self.spent = 0.0
        self.calls = 0
        self.known = LookupCache[str](TimeBudget(5.0, 0.2, lambda: self.now, lambda: self.spent))

    def find(self) -> str:
        self.calls += 1
        self.spent += 1.0
        return "found"

    def fail(self) -> str:
        self.find()
        raise DefinitionError("it is bad")

    def get(self, name: str) -> str:
        return self.known.get((name,), self.find, is_limited=True)


def test_each_is_looked_up_once() -> None:
    lookup = Lookup()
    assert [lookup.get("a") for _ in range(2)] == ["found"] * 2 and lookup.calls == 1
    for _ in range(2):
        with pytest.raises(UnknownTypeError, match="it is bad"):
            lookup.known.get(("b",), lookup.fail, is_limited=True)
    assert lookup.calls == 2


def test_only_so_much_time_is_spent_for_ros2() -> None:
    lookup = Lookup()
    for number in range(5):
        with pytest.raises(UnknownTypeError, match="it is bad"):
            lookup.known.get((f"bad{number}",), lookup.fail, is_limited=True)
    with pytest.raises(UnknownTypeError, match="looked up later"):
        lookup.get("a")
    assert lookup.known.get(("ours",), lookup.find, is_limited=False) == "found"
    lookup.now += 1.0
    assert lookup.get("a") == "found", "this was not remembered as a failure"
    lookup.now += 4.0
    with pytest.raises(UnknownTypeError, match="looked up later"):
        lookup.get("b")
    lookup.now += 0.1
    assert lookup.get("b") == "found"


def test_failures_are_bounded_and_do_not_push_out_what_was_found(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lookup_cache, "MAX_FAILURES", 10)
    lookup = Lookup()
    assert lookup.get("good") == "found"
    for number in range(11):
        with pytest.raises(UnknownTypeError):
            lookup.known.get((f"bad{number}",), lookup.fail, is_limited=False)
    calls = lookup.calls
    assert lookup.get("good") == "found"
    with pytest.raises(UnknownTypeError):
        lookup.known.get(("bad1",), lookup.fail, is_limited=False)
    assert lookup.calls == calls
    with pytest.raises(UnknownTypeError):
        lookup.known.get(("bad0",), lookup.fail, is_limited=False)
    assert lookup.calls == calls + 1


@pytest.mark.slow
def test_a_failure_does_not_keep_what_its_caller_had() -> None:
    class Plan:
        pass

    lookup = Lookup()

    def plan() -> weakref.ref[Plan]:
        mine = Plan()
        with pytest.raises(UnknownTypeError):
            lookup.known.get(("bad",), lookup.fail, is_limited=True)
        return weakref.ref(mine)

    reference = plan()
    gc.collect()
    assert reference() is None
