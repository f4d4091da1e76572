"""Mutants: which ones there are, and that each is a module of its own."""

from __future__ import annotations

import ast
import re
from operator import methodcaller
from pathlib import Path

import pytest

from .equivalent import name_of, names_in
from .mutate import choose, mutants

ROOT = Path(__file__).resolve().parents[2]
SOURCES = ROOT / "src" / "pyros1"


def after(source: str) -> list[str]:
    """Return the texts that stand in place of another one."""
    return [mutant.after for mutant in mutants(source.encode())]


@pytest.mark.parametrize(
    ("source", "changed"),
    [
        ("a < b", ["(a <= b)"]),
        ("a is None or b", ["(a is None and b)", "(a is not None)", "(a is None)", "(b)"]),
        ("not a", ["(a)"]),
        ("frames[index:]", ["(frames[:index])"]),
        ("x = 2", ["(3)"]),
        ("f(a, delay=b)", ["pass", "(f(a))"]),
        ("a if b else c", ["(c if b else a)"]),
        ("def f():\n    return a", ["return None"]),
        ("raise ValueError", ["pass"]),
        ("while a:\n    break", ["continue"]),
        ("n += m", ["n -= m"]),
    ],
)
def test_each_kind(source: str, changed: list[str]) -> None:
    assert sorted(after(source)) == sorted(changed)


@pytest.mark.parametrize(
    "source",
    ['"""Text."""', "x: 'int | 3'", "@cached(1)\ndef f():\n    pass", "f'{a + 1}'", "log.info('%d', n)", "'a' + b"],
)
def test_what_no_test_needs_to_notice_is_left_alone(source: str) -> None:
    assert not after(source)


@pytest.mark.slow
def test_every_mutant_is_another_module() -> None:
    for path in (SOURCES / "wire" / "framing.py", SOURCES / "node" / "clock.py"):
        source = path.read_bytes()
        unchanged = ast.dump(ast.parse(source))
        found = mutants(source)
        assert len(found) > 30
        for mutant in found:
            assert ast.dump(ast.parse(mutant.apply(source))) != unchanged, mutant


def test_offsets_count_bytes_of_utf8() -> None:
    source = "x = 'ü' if a < b else c"
    assert {mutant.apply(source.encode()).decode() for mutant in mutants(source.encode())} == {
        "x = 'ü' if (a <= b) else c",
        "x = (c if a < b else 'ü')",
    }


def test_the_list_of_equivalent_mutants_is_read() -> None:
    text = (
        "# About the list.\n\n# Two lines\n# of reason.\na | b | c\n\n# Another.\nd | e | f\ng | h | i\n\nj | k | l\n"
    )
    assert names_in(text) == {
        "a | b | c": "Two lines of reason.",
        "d | e | f": "Another.",
        "g | h | i": "Another.",
        "j | k | l": "",
    }


@pytest.mark.slow
def test_each_equivalent_mutant_exists_and_has_a_reason() -> None:
    named = names_in((Path(__file__).parent / "equivalent.txt").read_text())
    existing = set()
    for path in {name.partition(" | ")[0] for name in named}:
        source = (ROOT / path).read_bytes()
        beginnings = enumerate((f"{path} | {line.strip()} | " for line in re.split("\r?\n", source.decode())), 1)
        numbers = {number for number, beginning in beginnings if any(map(methodcaller("startswith", beginning), named))}
        existing |= {name_of(path, source.decode(), mutant) for mutant in mutants(source, numbers)}
    assert [name for name in named if name not in existing] == []
    assert [name for name, reason in named.items() if not reason] == []


def test_a_sample_changes_only_where_the_code_changes() -> None:
    names = [f"module.py | line {number} | 1 -> 2" for number in range(1000)]
    chosen = choose(names, 100, seed=1)
    assert len(set(chosen)) == 100
    assert chosen != choose(names, 100, seed=2)
    changed = ["a new line", *names[:500], *names[501:]]
    before, after = ({each[position] for position in choose(each, 100, 1)} for each in (names, changed))
    assert len(before & after) >= 98
