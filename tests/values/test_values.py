# ruff: noqa: E501 - tables
"""YAML values: reading by YAML 1.1 with ROS 1's angles (X77), writing as the stock tools write."""

from __future__ import annotations

import datetime
import enum
import math
import re
from collections import OrderedDict
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import Error
from pyros1.values import YamlError, dump_yaml, load_all_yaml, load_yaml
from pyros1.values.writing import dump

READ = [
    ("", None), ("~", None), ("null", None), ("yes", True), ("On", True), ("off", False), ("y", "y"), ("truE", "truE"),
    ("1", 1), ("-7", -7), ("+1", 1), ("010", 8), ("0x10", 16), ("0b11", 3), ("1:30", 90), ("1_000", 1000), ("08", "08"),
    ("1.5", 1.5), ("1.", 1.0), (".5", 0.5), ("-.5", "-.5"), ("1e3", "1e3"), ("1.5e3", "1.5e3"), ("1.5e+3", 1500.0), ("-.Inf", -math.inf),
    ("deg(90)", math.pi / 2), ("deg(-1e2)", math.radians(-100)), ("deg(-90.5)", -1.579522973054868), ("rad(2*pi)", 2 * math.pi), ("rad( -pi/2 )", -math.pi / 2),
    ("!degrees 90", math.pi / 2), ("!radians 3", 3.0), ("'deg(90)'", "deg(90)"), ("rad(sin(1))", "rad(sin(1))"), ("Rad(1)", "Rad(1)"),
    ("2001-01-01", datetime.date(2001, 1, 1)), ("2001-01-01 10:00:00", datetime.datetime(2001, 1, 1, 10)), ("!!binary aGk=", b"hi"),
    ("{a: 1, a: 2}", {"a": 2}), ("a: &x {b: 1}\nc: {<<: *x, d: 2}", {"a": {"b": 1}, "c": {"b": 1, "d": 2}}), ("!!str 1", "1"),
    ("%YAML 1.2\n---\nyes", True), ("{? a, ? b}", {"a": None, "b": None}), ("!!set {a}", {"a"}), ("/a/b", "/a/b"), (" 42 ", 42),
    ("|\n a\n b\n", "a\nb\n"), ("[a:1]", ["a:1"]),
]  # fmt: skip


@pytest.mark.parametrize(("text", "value"), READ)
def test_reading_follows_yaml_1_1_and_ros_angles_x77(text: str, value: Any) -> None:
    read = load_yaml(text)
    assert read == value
    assert type(read) is type(value)


def test_nan() -> None:
    assert math.isnan(load_yaml(".nan"))


BAD = ["[1,2", "a: b: c", "!foo x", "=", "deg(a)", "rad(2pi)", "rad(__i)", "rad(1/0)", "rad(9**9**9)", "&a [*a]", "--- 1\n--- 2", "!!int x",
       "!!python/object:os.system {}", "{[1]: 2}", "!!str [1]", "\x07", "2001-13-01", "!!bool maybe", "*nope", "!!binary '*a'", "[" * 5000]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("text", BAD)
def test_bad_texts_are_refused(text: str) -> None:
    with pytest.raises(YamlError):
        load_yaml(text)


def test_a_number_that_would_take_long_to_read_is_refused() -> None:
    assert load_yaml("1" * 200) == int("1" * 200)
    with pytest.raises(YamlError, match="invalid int: 1111"):
        load_yaml("1" * 201)


@pytest.mark.parametrize("text", ["!!int [1]", "!!float {a: 1}", "!!null []", "!degrees [90]"])
def test_a_list_is_no_number(text: str) -> None:
    with pytest.raises(YamlError, match="expected a scalar node, but found"):
        load_yaml(text)


@pytest.mark.slow
def test_nesting_has_a_limit_also_through_aliases() -> None:
    with pytest.raises(YamlError, match="nested too deeply"):
        load_yaml("[" * 5000 + "]" * 5000)
    parts = ["a0: &a0 []", *(f"a{i}: &a{i} [*a{i - 1}]" for i in range(1, 2000))]
    with pytest.raises(YamlError, match="nested too deeply"):
        load_yaml("\n".join(parts))


def test_errors_name_file_and_line() -> None:
    with pytest.raises(YamlError, match=r"^robot\.yaml:2: ") as caught:
        load_yaml("a: 1\nb: [2", "robot.yaml")
    assert (caught.value.where, caught.value.line) == ("robot.yaml", 2)
    with pytest.raises(YamlError, match=r"^robot\.yaml:2: invalid degrees"):
        load_yaml("a: 1\nb: deg(x)", "robot.yaml")
    with pytest.raises(YamlError, match=r"^robot\.yaml:2: unacceptable character #x0007"):
        load_yaml("a: 1\nb: \a", "robot.yaml")


def test_several_documents() -> None:
    assert load_all_yaml("--- 1\n--- [2]\n") == [1, [2]]
    assert load_all_yaml("") == []


WRITTEN = [
    (1, "1\n...\n"), ("a", "a\n...\n"), ("yes", "'yes'\n"), ("", "''\n"), ("a: b", "'a: b'\n"), ("é", '"\\xE9"\n'), (1e17, "1.0e+17\n...\n"),
    ("multi\nline\n", "'multi\n\n  line\n\n  '\n"), ("don't", "don't\n...\n"), ("'", "''''\n"), (None, "null\n...\n"),
    ({"b": [1, 2, {"c": []}], "a": {"x": {"y": "z"}}}, "a:\n  x:\n    y: z\nb:\n- 1\n- 2\n- c: []\n"), ([[1, 2], [3]], "- - 1\n  - 2\n- - 3\n"),
    ({"k": "word " * 20}, "k: '" + ("word " * 16)[:-1] + "\n  " + "word " * 4 + "'\n"), (b"hi", "!!binary |\n  aGk=\n"),
    ("a\tb", '"a\\tb"\n'), (True, "true\n...\n"), (math.inf, ".inf\n...\n"),
]  # fmt: skip


def in_brackets(value: Any) -> str:
    return dump(value, is_inline=lambda part: True)


@pytest.mark.parametrize(("value", "text"), WRITTEN)
def test_writing_in_block_style(value: Any, text: str) -> None:
    assert dump_yaml(value) == text


def test_writing_in_brackets() -> None:
    value = {"b": [1, {"c": []}], "a": "x, y"}
    assert in_brackets(value) == "{a: 'x, y', b: [1, {c: []}]}\n"
    assert dump(value, is_inline=lambda part: isinstance(part, list), ordered=True) == "b: [1, {c: []}]\na: x, y\n"


def test_what_cannot_be_written() -> None:
    loop: list[Any] = []
    loop.append(loop)
    for value in (loop, object(), [complex(1, 2)]):
        with pytest.raises(YamlError):
            dump_yaml(value)


scalars = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text() | st.binary()
values = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(), inner, max_size=4), max_leaves=12
)


@pytest.mark.slow
@given(values)
def test_what_is_written_is_read_back(value: Any) -> None:
    assert load_yaml(dump_yaml(value)) == value
    assert load_yaml(in_brackets(value)) == value


@given(st.text(alphabet="ab1.-:[]{}&*!#'\"|>%@?,~<= \n\t()degrapi_0x", max_size=30))
def test_any_text_gives_a_value_or_the_documented_error(text: str) -> None:
    try:
        load_all_yaml(text)
        load_yaml(text)
    except YamlError as error:
        assert isinstance(error, Error)


@given(st.one_of(st.integers(), st.floats(), st.from_regex(r"[A-Za-z_/.]{0,5}[\w/.-]{0,3}", fullmatch=True)))
def test_what_is_written_without_pyyaml_is_as_it_would_write_it(value: Any) -> None:
    assert dump_yaml(value) == yaml.safe_dump(value)
    assert dump_yaml([value]) == yaml.safe_dump([value])


@pytest.mark.parametrize(
    "value", ["gain", "/scan", "yes", "0.5", "5", "1e5", "", "noetic\n", 5, -1, 0.5, -0.0, 1e30, True]
)
def test_one_word_or_number(value: Any) -> None:
    assert dump_yaml(value) == yaml.safe_dump(value)


def test_texts_that_look_like_angles_stay_texts() -> None:
    for text in ("deg(90)", "rad(pi)", "deg(", "rad (1)"):
        assert load_yaml(dump_yaml(text)) == text
        assert load_yaml(in_brackets([text])) == [text]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("a: 1\nb: !!timestamp x", "2: invalid timestamp: x"),
        ("!!timestamp 2001-1-1 1:1:1", "1: invalid timestamp"),
        ("!!int '-'", "1: invalid int: -"),
        ("!!int {=: '" + "1:" * 200_000 + "1'}", "expected a scalar node, but found mapping"),
        ("[" * 60 + "]" * 60, "1: nested too deeply"),
        ("\n".join(" " * level + "a:" for level in range(60)), "nested too deeply"),
    ],
    ids=range(6),
)
def test_what_is_wrong_is_said_with_its_line(text: str, reason: str) -> None:
    with pytest.raises(YamlError, match=re.escape(reason)):
        load_yaml(text)


def test_kinds_of_values_are_written_as_what_they_are() -> None:
    class Words(list[str]):
        pass

    class Level(enum.IntEnum):
        HIGH = 2

    value = {"a": OrderedDict(b=Words(["c"])), "d": Level.HIGH, "e": np.float64(0.5), "f": bytearray(b"g")}
    assert load_yaml(dump_yaml(value)) == {"a": {"b": ["c"]}, "d": 2, "e": 0.5, "f": b"g"}


def test_aliases_do_not_multiply_without_end() -> None:
    lines = ["a: &a [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]"]
    for name, before in zip("bcdefghij", "abcdefghi", strict=True):
        lines.append(f"{name}: &{name} [{', '.join([f'*{before}'] * 10)}]")
    assert load_yaml("\n".join(lines[:3]))["c"][9][9] == [*range(10)]
    with pytest.raises(YamlError, match="the aliases represent more than"):
        load_yaml("\n".join(lines))


def test_a_value_cannot_contain_itself() -> None:
    with pytest.raises(YamlError, match="1: a value cannot contain itself"):
        load_yaml("&a [1, *a]")
