"""The log that is kept."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1 import Time
from pyros1.msgs.rosgraph_msgs.msg import Log
from pyros1.web.server import wire
from pyros1.web.transforms.console import Console


def log(text: str) -> Log:
    message = Log(name="/node", level=4, msg=text, file="f.py", function="main", line=7, topics=["/a"])
    message.header.stamp = Time(12, 500_000_000)
    return message


def test_an_entry() -> None:
    console = Console()
    console.add(log("hello"))
    ((entry,), dropped) = console.entries_after(0, 10)
    assert tuple(entry) == (1, 12.5, 4, "/node", "hello", "f.py", "main", 7, ["/a"], 500_000_000)
    assert dropped == 0
    assert console.entries_after(1, 10) == ([], 0)


@given(st.integers(0, 60), st.integers(0, 80), st.integers(1, 70))
def test_what_comes_after_one(count: int, known: int, most: int) -> None:
    console = Console(size=20)
    for number in range(count):
        console.add(log(str(number + 1)))
    entries, dropped = console.entries_after(known, most)
    kept = [number for number in range(1, count + 1) if number > count - 20 and number > known]
    assert [entry.number for entry in entries] == kept[:most]
    assert [entry.text for entry in entries] == [str(number) for number in kept[:most]]
    assert dropped == max(0, max(0, count - 20) - min(known, count))


def test_long_and_strange_texts_are_bounded() -> None:
    console = Console()
    console.add(log("x" * 1_000_000))
    console.add(log("\udcff\x00"))
    (long, strange), _ = console.entries_after(0, 10)
    assert len(long.text) < 21_000
    json.loads(wire.result(1, strange))


def test_of_long_texts_fewer_are_kept_the_newest(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.web.transforms.console.MAX_CHARACTERS", 5_000)
    console = Console()
    for number in range(50):
        console.add(log(f"{number:02}" + "x" * 1_000))
    entries, dropped = console.entries_after(0, 100)
    assert [entry.text[:2] for entry in entries] == ["46", "47", "48", "49"]
    assert dropped == 46


def test_what_is_told_at_once_is_bounded() -> None:
    console = Console()
    for text in ("a" * 500, "b" * 500, "c" * 2_000, "d"):
        console.add(log(text))
    assert [[entry.text[0] for entry in console.entries_after(known, 10, 1_100)[0]] for known in range(4)] == [
        ["a", "b"],
        ["b"],
        ["c"],  # too long, but else nothing would ever come
        ["d"],
    ]


def test_listeners_hear_of_each_until_they_leave() -> None:
    console = Console()
    heard: list[int] = []
    end = console.listen(lambda: heard.append(1))
    console.add(log("a"))
    end()
    console.add(log("b"))
    assert heard == [1]
