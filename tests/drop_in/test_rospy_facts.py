"""Each fact on rospy has a test: ``rospy_facts.txt`` says which."""

from __future__ import annotations

import ast
import functools
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
ROWS = [
    [part.strip() for part in line.split("|")]
    for line in Path(__file__).with_name("rospy_facts.txt").read_text(encoding="utf-8").splitlines()
    if not line.startswith("#")
]


@functools.cache
def functions_of(file: str) -> frozenset[str]:
    """Return the names of the functions of a file."""
    nodes = ast.parse((ROOT / file).read_text(encoding="utf-8")).body
    return frozenset(node.name for node in nodes if isinstance(node, ast.FunctionDef))


def test_each_fact_has_a_test() -> None:
    numbers = [number for number, _, _ in ROWS]
    assert list(dict.fromkeys(numbers)) == [f"P{number:02}" for number in range(1, 50)]
    assert len({(number, test) for number, test, _ in ROWS}) == len(ROWS)


@pytest.mark.parametrize(("number", "test", "fact"), ROWS, ids=[f"{row[0]}-{index}" for index, row in enumerate(ROWS)])
def test_the_test_of_a_fact_exists(number: str, test: str, fact: str) -> None:
    file, _, name = test.partition("::")
    assert name.startswith("test_") and name in functions_of(file), f"{number} ({fact})"
