from __future__ import annotations

import pytest

from pyros1.robot_nodes.diagnostic_aggregator.matching import Matcher, join_path, output_name
from pyros1.robot_nodes.diagnostic_aggregator.patterns import NamePattern


@pytest.mark.parametrize(
    ("matcher", "taken", "left"),
    [
        (Matcher(names=frozenset(["a b"])), ["a b"], ["a", "a b c", ""]),
        (Matcher(prefixes=("imu", "gps")), ["imu", "imu: x", "gps2"], ["an imu", ""]),
        (Matcher(parts=("Temp", "x")), ["CPU Temp", "box"], ["temp", ""]),
        (Matcher(patterns=(NamePattern("ab+c"),)), ["abc", "abbc"], ["xabc", "abcx", "ac"]),
        (Matcher(prefixes=("",)), ["", "a"], []),
        (Matcher(), [], ["", "a"]),
    ],
)
def test_names_that_match(matcher: Matcher, taken: list[str], left: list[str]) -> None:
    assert all(map(matcher.matches, taken)) and not any(map(matcher.matches, left))
    assert bool(matcher) is (matcher != Matcher())


@pytest.mark.parametrize(
    ("name", "prefixes", "expected"),
    [
        ("imu: left", ["imu"], "left"),
        ("imu/a/b:c", ["imu"], "a b:c"),
        ("imu:: x", ["imu"], ": x"),
        ("imu   x", ["imu"], "x"),
        ("imu", ["imu"], ""),
        ("an imu", ["imu"], "an imu"),
        (" :a", ["imu"], ":a"),
        (":a", ["imu"], "a"),
        (" /a", [], "  a"),
        (" /a", [""], "  a"),
        ("QPRb", ["Q", "R", "P"], "Rb"),
        ("a/b/c", ["a/b"], "c"),
        ("::", ["P", "Q"], ""),
    ],
)
def test_names_of_items_in_the_tree(name: str, prefixes: list[str], expected: str) -> None:
    assert output_name(name, prefixes) == expected


def test_paths() -> None:
    assert join_path("/", "A") == "/A" and join_path("/r", "A/b") == "/r/A/b"
    assert join_path("/", "") == join_path("/", "/") == "/" and join_path("/r/", "/A") == "/r///A"
