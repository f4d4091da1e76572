# ruff: noqa: E501 - tables
"""The safe interpreter: Python's values, its limits, and what its users add to it."""

from __future__ import annotations

import contextlib
import math
import subprocess
import sys
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import LaunchError
from pyros1.ground.expressions import MAX_BITS, MAX_ITEMS, MAX_TEXT, ExpressionError, Interpreter, check_value, size
from pyros1.launch.reading.expression import evaluate
from pyros1.observe.expression import Expression
from pyros1.values import YamlError, load_yaml

NAMES = {"i": 3, "f": 0.5, "s": "text", "t": True, "l": [1, 2]}


def value(text: str) -> Any:
    """What the interpreter itself makes of a text, to see that the bounds hold without any help of a subclass."""
    return Interpreter(text).evaluate({**NAMES, "str": str, "dict": dict})


@pytest.mark.parametrize(
    "text",
    [
        "1 + 2 * 3 - 4 / 5 // 6 % 7", "2 ** 10", "2 ** -1", "1 ** 99999", "(-1) ** 99999", "1 << 4 >> 1", "6 & 3 | 8 ^ 1", "-i", "+f", "~i", "not t",
        "i == 3 != 4", "1 < i <= 3", "3 < i < 9", "i is None", "i is not None", "1 in l", "9 not in l", "i and s or 0", "0 and x", "1 or x",
        "'a' if t else 'b'", "s[1:3]", "s[::-1]", "l[-1]", "[i, f]", "(i, f)", "{'a': i}['a']", "s.upper()", "dict(a=1)", "str(i) * 3", "'%s/%d' % (s, i)",
        "'%.2f, %5d' % (f, i)", "'robot1/%s' % s", "'%s * %s' % (i, i)", "'100%%' % ()", "...", "b'ab' * 2", "1j * 1j", "[] * 99999",
        "[x for x in l]", "{x for x in l}", "{1}", "{x: 1 for x in l}", "f'{i}'", "s.lower()", "math.sqrt(i)",
    ],
)  # fmt: skip
def test_value_is_that_of_python(text: str) -> None:
    expected = eval(text, {**NAMES, "math": math})  # noqa: S307 - the texts above
    assert value(text) == expected
    assert type(value(text)) is type(expected)


@pytest.mark.parametrize(
    "text",
    [
        "", "(", "1 +", "x", "x = 1", "(x := 1)", "lambda: 1", "*l", "str(*5)", "dict(**{})", "{**{}}",
        "await i", "i @ i", "s.__class__", "s._x", "s.format_map({})", "f.real", "math", "math.prod([1])", "(lambda: 1)()", "str(i)()", "l[0]()", "i()", "1 / 0", "l[7]", "'a' + 1", "\0", "\ud800", "1\n2",
        "l[:i:0]", "-s", "{l: 1}", "b'%d' % 1", "(" * 5000, "-" * 9000 + "1", "1" + "+1" * 4900, "[" * 80 + "]" * 80 + "[0]" * 900,
    ],
    ids=lambda text: ascii(text[:30]),
)  # fmt: skip
def test_what_is_not_allowed_or_fails_is_the_documented_error(text: str) -> None:
    with pytest.raises(ExpressionError):
        value(text)


@pytest.mark.parametrize(
    "text",
    [
        # numbers
        "9 ** 9 ** 9", "2 ** 4096", "(-2) ** 9999", "1 << 4096", "1 << 10 ** 9", "2 ** 4000 * 2 ** 4000", "2 ** 4095 + 2 ** 4095", "-(2 ** 4095) * 2",
        "0x" + "f" * 2000, "2 ** 4095 | 1 << 4095 << 1",
        # texts and lists
        "'a' * 10001", "10 ** 9 * 'a'", "'a' * 9000 + 'b' * 9000", "[0] * 10 ** 9", "(0,) * 10 ** 9", "b'a' * 10 ** 9", "[0] * 9000 + [1] * 9000",
        "s * 10 ** 99",
        # lists in lists are as long as all that is in them
        "[[0] * 1000] * 1000", "[['a' * 1000] * 9] * 9", "['a' * 9000, 'b' * 9000]", "('a' * 9000, 'b' * 9000)", "{'a' * 9000: 'b' * 9000}",
        "[{'a': 'b' * 5000}.items()] * 3",
        # formatting
        "'%99999d' % 1", "'%0999999999d' % 1", "'%00000000000000000999999999d' % 1", "'%.99999f' % 1", "'%*d' % (99999, 1)", "'%-*d' % (99999, 1)",
        "'%.*f' % (99999, 1)", "'%5000d%5000d%5000d' % (1, 1, 1)", "'%(a)99999d' % {'a': 1}", "'%((a))99999d' % {'(a)': 1}", "'%(a)s' * 9 % {'a': 'x' * 5000}",
        # calls
        "str('x' * 5000 + 'y' * 5001)",
        # the text
        "1" + " " * MAX_TEXT + "+ 1",
    ],
    ids=lambda text: text[:40],
)  # fmt: skip
def test_results_are_bounded(text: str) -> None:
    with pytest.raises(ExpressionError, match=r"too large|more than|width"):
        value(text)


def test_bounds_are_those_documented() -> None:
    assert value(f"2 ** {MAX_BITS - 2}").bit_length() == MAX_BITS - 1
    assert value(f"1 << {MAX_BITS - 1}").bit_length() == MAX_BITS
    assert len(value(f"'a' * {MAX_ITEMS}")) == MAX_ITEMS
    assert len(value(f"'%{MAX_ITEMS}d' % 1")) == MAX_ITEMS
    with pytest.raises(ExpressionError, match="too large"):
        check_value(1 << MAX_BITS)


def test_size_counts_what_is_inside() -> None:
    inner = ["abc", b"de"]
    assert size(inner) == 7
    assert size({"k": inner, "l": (inner, 5)}) == 2 + 2 + 7 + 2 + 7
    assert size([inner] * 10**6) > MAX_ITEMS
    assert size(7) == size(None) == 0


PARTS = [
    "i", "f", "s", "t", "l", "1", "7", "99", "'a'", "''", "None", "(", ")", "[", "]", "{", "}", ",", ":", ".upper", "str", "+", "-", "*", "/", "//", "%",
    "**", "<<", ">>", "&", "|", "~", "<", "==", " in ", " is ", " not ", " and ", " or ", " if ", " else ", " for ", "'%s'", "lambda ", "_", "__class__",
]  # fmt: skip


@given(st.text(max_size=40) | st.lists(st.sampled_from(PARTS), max_size=14).map("".join))
def test_any_text_gives_a_bounded_value_or_the_documented_error(text: str) -> None:
    with contextlib.suppress(ExpressionError):
        result = value(text)
        assert size(result) <= MAX_ITEMS
        assert not isinstance(result, int) or result.bit_length() <= MAX_BITS


terms = st.recursive(
    st.sampled_from(["i", "f", "s", "l", "2", "99", "'ab'", "[s]", "'%9d'"]),
    lambda inner: st.tuples(inner, st.sampled_from(["+", "-", "*", "**", "<<", "%", "//"]), inner).map(
        lambda parts: "({}{}{})".format(*parts)
    ),
    max_leaves=8,
)


@given(terms)
def test_what_is_calculated_is_what_python_calculates_or_too_large(text: str) -> None:
    with contextlib.suppress(ExpressionError):
        result = value(text)
        assert result == eval(text, {**NAMES}) or result != result  # noqa: S307, PLR0124 - built from the terms above


@given(st.lists(st.sampled_from([*PARTS, "pi", "2.5"]), max_size=14).map("".join))
def test_users_of_the_interpreter_give_a_value_or_their_own_error(text: str) -> None:
    with contextlib.suppress(ExpressionError):
        Expression(text)(NAMES)
    with contextlib.suppress(LaunchError):
        assert isinstance(evaluate(text, NAMES, {}), str)
    with contextlib.suppress(YamlError):
        assert isinstance(load_yaml(f"!radians {text!a}"), float)


@pytest.mark.parametrize(
    "text",
    [
        "prod([2 ** 4000] * 5000)", "math.prod([9, 9])", "'a'.join(['b' * 9] * 9000)", "('a' * 5000).join(['', '', '', ''])",
        "('a' * 9000).replace('a', 'b' * 9000)", "list(map(('ab' * 40).join, map(('ab' * 40).join, ['ab' * 9])))", "math", "math()", "str(math)",
        "[[['a'] * 900] * 900] * 900", "'%99999d' % 1",
        "len(sorted([9999] * 9999, key=range))", "min([9999] * 9, key='{:>9999}'.format)",
    ],
)  # fmt: skip
def test_launch_files_keep_the_bounds_in_calls_too(text: str) -> None:
    with pytest.raises(LaunchError):
        evaluate(text, {}, {})


def test_launch_files_join_replace_and_format() -> None:
    assert evaluate("'-'.join(map(str, [1, 2])).replace('-', '/') + '/%.1f' % x", {"x": 2.0}, {}) == "1/2/2.0"


@pytest.mark.slow
@pytest.mark.parametrize(
    "text",
    ["round(1, -999999999)", "sum([[1]] * 400000, [])", "str([0] * 400000) * 9", "sorted([2, 10 ** 6 - 3], key=range)"],
)
def test_filters_keep_the_bounds_in_calls_too(text: str) -> None:
    with pytest.raises(ExpressionError):
        Expression(text)({})


def test_filters_name_the_expression_and_what_there_is() -> None:
    with pytest.raises(ExpressionError, match=r"^\[nope\(1\)\]: unknown function nope; known functions: abs, "):
        Expression("nope(1)")
    with pytest.raises(ExpressionError, match=r"^\[nope\]: unknown name 'nope'; known names: m$"):
        Expression("nope")({"m": 1})
    assert Expression("round(2.345, 1) + sum([1, 2]) + round(0.2)")({}) == pytest.approx(5.3)


@pytest.mark.parametrize(
    ("text", "number"),
    [("2**3", 8.0), ("7//2", 3.0), ("-(pi)%2", -math.pi % 2), ("1.5**100", 1.5**100), ("+1e3", 1000.0)],
)
def test_angles_are_calculated_in_floating_point(text: str, number: float) -> None:
    assert load_yaml(f"!radians {text}") == number


@pytest.mark.parametrize(
    "text",
    ["(-8)**0.5", "10**999", "9**9**9", "1<<2", "~1", "not 1", "True", "'1'", "1j", "e", "pi()", "1 if 1 else 2", "[1][0]"],
)  # fmt: skip
def test_angles_are_arithmetic_only(text: str) -> None:
    with pytest.raises(YamlError, match="invalid radians"):
        load_yaml(f"!radians {text!a}" if text.startswith("'") else f'!radians "{text}"')


def test_values_load_the_parser_only_for_arithmetic() -> None:
    """Loading Python's parser would delay the start of every tool."""
    program = """
import sys
from pyros1.values import load_yaml
load_yaml("{a: deg(90), b: [1.5, on]}")
assert "ast" not in sys.modules and "pyros1.ground.expressions" not in sys.modules
load_yaml("rad(pi/2)")
assert "pyros1.ground.expressions" in sys.modules
"""
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
