"""private: private parameters on the command line mean what YAML says they mean (N13)."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from pyros1.ground.errors import Error
from pyros1.node.parameters.private import leftover_warning, parse_private_parameter
from pyros1.values import load_yaml


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("10", 10), ("-3", -3), ("+4", 4), ("0", 0), ("2.5", 2.5), ("-0.5", -0.5), ("1.", 1.0), ("1e3", "1e3"),
        ("0x10", 16), ("true", True), ("yes", True), ("off", False), ("map", "map"), ("/a/b", "/a/b"),
        ("a b", "a b"), ("'5'", "5"), ("[1, x]", [1, "x"]), ("{a: 1}", {"a": 1}), ("", ""), ("null", ""),
        ("[unclosed", "[unclosed"), ("http://host:1/", "http://host:1/"), ("a.b-c", "a.b-c"), ("~", ""),
    ],
)  # fmt: skip
def test_examples(text: str, value: Any) -> None:
    result = parse_private_parameter(text)
    assert result == value and type(result) is type(value)


def by_yaml(text: str) -> Any:
    try:
        value = load_yaml(text)
    except Error:
        return text
    return "" if value is None else value


@pytest.mark.slow
@settings(max_examples=300, deadline=None)
@given(
    st.one_of(
        st.text(max_size=12),
        st.text("0123456789+-._eExXoabn:", max_size=10),
        st.text("yesnotrufalYESNOTRUFALl~", max_size=6),
        st.integers().map(str),
        st.floats().map(str),
    )
)
@example("010")
@example("1_000")
@example("12:30:45")
@example("2001-01-01")
@example("No")
@example("nUll")
@example("1.5\n")
@example("a: b")
@example("/x:")
@example("=")
@example("<<")
@example("...")
@example("---")
def test_the_short_cuts_agree_with_yaml(text: str) -> None:
    expected = by_yaml(text)
    result = parse_private_parameter(text)
    assert type(result) is type(expected)
    assert repr(result) == repr(expected)


def test_what_an_earlier_start_left_on_the_master_is_said(make_node: Any, capsys: pytest.CaptureFixture[str]) -> None:
    def said(*argv: str) -> str:
        with make_node("n", rosout=False, argv=list(argv)):
            pass
        return capsys.readouterr().out

    assert said("_rate:=0") == "", "the command line says it"
    assert said().endswith(
        "]: already set before the node started: ~rate is 0 (to delete it: pyros1 param delete /n/rate)\n"
    )
    assert said("_rate:=5") == ""
    assert "~rate is 5 (" in said("_gain:=1")
    assert "~rate is 5, ~gain is 1 (to delete one: pyros1 param delete /n/rate)" in said()
    assert said("__log:=/dev/null") == "", "a launcher sets parameters itself"


def test_a_long_list_is_cut() -> None:
    tree = {"a": {"b": {str(number): "x" * 100 for number in range(7)}}, "given": 1, "empty": {}}
    (line,) = leftover_warning("/ns/n", tree, {"given": "1"})
    assert line.startswith("already set before the node started: ~a/b/0 is 'xxx") and line.endswith(
        " and 3 more (to delete one: pyros1 param delete /ns/n/a/b/0)"
    )
    assert len(line) < 500
    (line,) = leftover_warning("/n", dict.fromkeys("abcde", 1), {})
    assert "~d is 1, ~e is 1 (to delete one:" in line
    assert leftover_warning("/n", ValueError("not set"), {}) == leftover_warning("/n", {}, {}) == []
