# ruff: noqa: E501 - tables and programs in one line
"""The safe interpreter of $(eval ...) (X71)."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.expression import evaluate

VARIABLES = {"i": 3, "f": 0.5, "s": "text", "t": True}
FUNCTIONS = {"arg": VARIABLES.__getitem__, "env": lambda name: "/home/me"}


def test_arguments_have_priority_over_builtins_but_not_over_math_and_functions() -> None:
    names = ("map", "list", "max", "str", "range", "filter", "format")
    variables = {name: f"my {name}" for name in (*names, "pi", "true", "find")}
    for name in names:
        assert evaluate(f"{name} + '.yaml'", variables, {}) == f"my {name}.yaml"
    assert evaluate("pi > 3", variables, {}) == evaluate("true", variables, {}) == "True"
    assert evaluate("find('p')", variables, {"find": lambda package: f"/{package}"}) == "/p"
    assert evaluate("', '.join(list(map(lambda i: 'r' + i, ['1', '2'])))", {}, {}) == "r1, r2"


@pytest.mark.parametrize(
    ("text", "result"),
    [
        ("i + 1", "4"), ("i * f", "1.5"), ("7 // 2 % 2", "1"), ("2 ** 10", "1024"), ("not t", "False"), ("i == 3 and s or 'x'", "text"),
        ("'a' if t else 'b'", "a"), ("1 < i <= 3", "True"), ("'ex' in s", "True"), ("[1, 2, 3][-1]", "3"), ("s[1:3].upper()", "EX"),
        ("sqrt(16) + math.pi * 0", "4.0"), ("arg('s') + env('HOME')", "text/home/me"), ("list(map(str, [1, 2]))", "['1', '2']"),
        ("{'a': 1}['a']", "1"), ("-i", "-3"), ("str(1) + str(true)", "1True"), ("int('7') / 2", "3.5"), ("','.join(['a', 'b'])", "a,b"),
        ("i is not None", "True"), ("dict(a=1).get('a')", "1"),
        ("[x * 2 for x in range(3) if x]", "[2, 4]"), ("''.join(str(x) for x in [1, 2])", "12"), ("{k: v for k, v in zip('ab', [1, 2])}", "{'a': 1, 'b': 2}"),
        ("[(x, y) for x in range(2) for y in range(x)]", "[(1, 0)]"), ("sorted({x % 2 for x in range(9)})", "[0, 1]"), ("[i for i, in [(7,)]][0] + i", "10"),
        ("hex(255) + chr(65) + str(ord('A'))", "0xffA65"), ("format(3, '03d') + repr('a')", "003'a'"), ("divmod(7, 2)", "(3, 1)"), ("isinstance(i, int)", "True"),
        ("list(enumerate('ab'))", "[(0, 'a'), (1, 'b')]"), ("''.join(reversed('abc'))", "cba"), ("{1, 1}", "{1}"),
    ],
)  # fmt: skip
def test_what_launch_files_use(text: str, result: str) -> None:
    assert evaluate(text, VARIABLES, FUNCTIONS) == result


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    [
        "", "1 +", "foo", "open('x')", "().__class__", "'{0.real}'.format(i)", "'{:{}}'.format(i, 9)", "'{:999999}'.format(i)", "f'{i:999999}'", "'a'.zfill(10 ** 6)", "s.encode('idna')", "(lambda: 1)()", "9 ** 9 ** 9", "1 << 99999",
        "'a' * 10 ** 8", "exec('1')", "math", "i.real", "[1][5]", "1 / 0", "'%99999999d' % 1", "dict(**{})", "(i := 4)",
        "arg('nope')", "'a' + 1", "factorial(10000)", "print(1)", "{**{}}", "await i", "int('9' * 9000)", "[x for x in range(99999)]", "[0 for x in range(9999) for y in range(9999) if 0]", "[x.__class__ for x in [1]]", "x for x in [1]",
        "format(1, '999999')", "[a for a, b in [(1,)]]", "[v for s.x in [1]]",
    ],
)  # fmt: skip
def test_what_is_refused(text: str) -> None:
    with pytest.raises(LaunchError):
        evaluate(text, VARIABLES, FUNCTIONS)


@given(st.text(alphabet="ist01+-*/%()[]{}'\",.:=<> andorifelsmth", max_size=40))
def test_any_text_gives_a_string_or_the_documented_error(text: str) -> None:
    with contextlib.suppress(LaunchError):
        assert isinstance(evaluate(text, VARIABLES, FUNCTIONS), str)


@pytest.mark.parametrize("text", ["chr(0)", "'a' + chr(0xd800)", "chr(0xdfff) + s"])
def test_characters_that_no_file_can_have_are_refused(text: str) -> None:
    with pytest.raises(LaunchError, match="a character that is not allowed in files and parameters"):
        evaluate(text, VARIABLES, FUNCTIONS)


def test_bytes_of_the_environment_that_are_no_text_stay() -> None:
    assert evaluate("env('X')", VARIABLES, {"env": lambda name: "\udcff"}) == "\udcff"
