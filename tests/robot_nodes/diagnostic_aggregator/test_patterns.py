from __future__ import annotations

import random
import re
import time

import pytest

from pyros1.robot_nodes.diagnostic_aggregator.match_ways import MAX_NAME_LENGTH, max_name_length
from pyros1.robot_nodes.diagnostic_aggregator.patterns import MIN_NAME_LENGTH, NamePattern, PatternError


@pytest.mark.parametrize(
    "expression",
    [
        *["(a+)+$", "(a|a)*b", "(a*)*", "a*a*a*a*a*a*b", "(a?){30}a{30}", r"(\w+\s?)*", "(?=(a+)+b)a", "(?:a|b?)*c"],
        *["(a*){600}b", "(a+)+b{450}", "a*a*a*a*a*a*b{400}", "(?=(a+)+b{490}).*", "(?<=" + "(a|a)" * 30 + ").*"],
    ],
)
def test_expressions_that_could_take_hours_are_refused(expression: str) -> None:
    with pytest.raises(PatternError, match="could take hours"):
        NamePattern(expression)


@pytest.mark.parametrize("part", ["(a|bc)*", "(a?b?)*", "(?:ab?)+"])
def test_it_does_not_take_long_to_refuse_an_expression(part: str) -> None:
    start = time.process_time()
    with pytest.raises(PatternError):
        NamePattern(part * (1000 // len(part)))
    assert time.process_time() - start < 1.0


@pytest.mark.parametrize("expression", ["((", "a{99999999999999}", "x" * 1001])
def test_what_is_no_expression_is_refused(expression: str) -> None:
    with pytest.raises(PatternError):
        NamePattern(expression)


@pytest.mark.parametrize(
    ("expression", "length"),
    [
        ("Joint.*", 500),
        (r"(CPU|HD)_?\d+: .*", 500),
        (r".*motor.*: [a-z]{2,5}", 500),
        (".*a.*b.*", 180),
        ("(?!.*a.*b.*).*", 180),
    ],
)
def test_usual_expressions_match_long_names(expression: str, length: int) -> None:
    assert max_name_length(expression) >= length
    assert NamePattern(".*node.*").matches("x" * 490 + "node") and not NamePattern("x*").matches("x" * 501)


@pytest.mark.slow
def test_expressions_that_are_accepted_are_fast_and_match_as_in_python() -> None:
    chance, accepted = random.Random(7), 0

    def part(depth: int) -> str:
        kind = chance.random()
        if depth == 0 or kind < 0.4:
            return chance.choice(["a", "b", ".", "[ab]", "", r"\w", "ab", "b{60}"])
        inside = "".join(part(depth - 1) for _ in range(chance.randint(1, 3)))
        if kind < 0.75:
            return f"(?:{inside}){chance.choice(['*', '+', '?', '*?', '{1,3}', '{2}'])}"
        return f"({inside}|{part(depth - 1)})"

    for _ in range(60):
        expression = "".join(part(2) for _ in range(chance.randint(1, 4)))
        try:
            pattern = NamePattern(expression)
        except PatternError:
            continue
        accepted += 1
        start = time.process_time()
        assert not pattern.matches("a" * (pattern.max_length - 1) + "!") or "." in expression
        assert time.process_time() - start < 1.0, expression
        for _ in range(5):
            name = "".join(chance.choices("ab", k=chance.randint(0, 8)))
            assert pattern.matches(name) is pattern.matches(name) is (re.fullmatch(expression, name) is not None)
        assert MIN_NAME_LENGTH <= pattern.max_length <= MAX_NAME_LENGTH
    assert accepted > 15
