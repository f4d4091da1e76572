"""Messages as text (G25, L38, L40, L41) and the YAML forms of strings."""

from __future__ import annotations

from typing import Any

import pytest
import yaml
from hypothesis import example, given
from hypothesis import strategies as st
from message_strategies import messages

from pyros1.ground.timing import Duration, Time
from pyros1.msgs import from_definition
from pyros1.msgs.base import nested_classes
from pyros1.msgs.text import emit_message, format_message
from pyros1.msgs.yamltext import item_pieces, quoted_pieces

SEPARATOR = "=" * 80
cls: Any = from_definition(
    "p/T",
    "bool b\nfloat64 f\nstring s\ntime t\nuint8[] u\nint32[] i\nfloat64[2] g\nstring[] l\ntime[] ts\nA a\nA[] aa\nE e\n"
    f"{SEPARATOR}\nMSG: p/A\nint32 v\nstring[] w\n{SEPARATOR}\nMSG: p/E\n",
)
A: Any = nested_classes(cls)["p/A"]

FULL = """\
b: True
f: 1.5e+300
s: "h\\"i\\n: x"
t:~
  secs: 5
  nsecs:         3
u: [97, 255]
i: [1, -2]
g: [1.0, 2.5]
l:~
  - a
  - b c
  - ''
  - '1'
ts:~
  -~
    secs: 1
    nsecs:         0
a:~
  v: 0
  w: []
aa:~
  -~
    v: 1
    w:~
      - x
  -~
    v: 0
    w: []
e:~
""".replace("~", " ")  # trailing blanks are part of it


def full() -> Any:
    message = cls(b=True, f=1.5e300, s='h"i\n: x', t=Time(5, 3), u=b"a\xff", i=(1, -2), g=[1.0, 2.5])
    message.l = ["a", "b c", "", "1"]
    message.ts = [Time(1)]
    message.aa = [A(1, ["x"]), A()]
    return message


def test_g25_str_and_repr() -> None:
    assert str(full()) == repr(full()) == format_message(full()) == FULL
    assert str(from_definition("p/E", "")()) == ""


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1, "1"),
        (True, "True"),
        (-0.0, "-0.0"),
        ("a b", '"a b"'),
        ("", "''"),
        ("ü\x01", '"\\xFC\\x01"'),
        ([], "[]"),
        ((1.5, 2), "[1.5, 2]"),
        (["a"], "\n- a"),
        ([Time(1)], "\n- \n  secs: 1\n  nsecs:         0"),
        (Duration(-2, 5), "\nsecs: -2\nnsecs:         5"),
        (None, "None"),
        (b"ab", "b'ab'"),
    ],
)
def test_values(value: Any, text: str) -> None:
    assert format_message(value) == text


def test_l38_width() -> None:
    assert format_message(7, width=4) == "   7"
    assert format_message(1.23456, width=4) == "1.23"
    assert format_message(-12345.678, width=4) == "-12345"
    assert format_message([1, 2.5], width=5) == "[    1, 2.500]"
    assert format_message(True, width=5) == "True"
    assert format_message(Time(1, 2), width=3) == "\nsecs:   1\nnsecs:   2"


def test_l40_no_string() -> None:
    lines = format_message(full(), no_string=True).split("\n")
    assert 's: "<string length: 7>"' in lines
    assert 'l: "<array type: string, length: 4>"' in lines
    assert '  w: "<array type: string, length: 0>"' in lines  # in a nested message
    assert "      - x" in lines  # but not in an array of messages: stock does not look there


def test_l41_no_array() -> None:
    lines = format_message(full(), no_array=True).split("\n")
    assert 'u: "<array type: uint8, length: 2>"' in lines
    assert 'g: "<array type: float64[2, length: 2>"' in lines  # as stock prints it
    assert 'aa: "<array type: p/A, length: 2>"' in lines
    assert format_message([1, 2], no_array=True, type_name="int32[]") == '"<array type: int32, length: 2>"'
    assert format_message(b"ab", type_name="uint8[]") == "[97, 98]"


def test_offset_and_filter() -> None:
    assert format_message(Time(5, 3), time_offset=Time(1, 1)) == "\nsecs: 4\nnsecs:         2"
    assert format_message(full(), field_filter=lambda message: ["b"] if type(message) is cls else []) == "b: True"


def test_folding_of_long_strings() -> None:
    assert "".join(quoted_pieces("word " * 20)) == '"' + "word " * 16 + 'word\\\n  \\ word word word "'
    assert "".join(item_pieces("word " * 20 + "end")) == "word " * 15 + "word\n  word word word word end"


def test_large_texts_and_arrays_come_in_small_pieces() -> None:
    long = "a" * 25_000
    assert "".join(quoted_pieces(f"{long} b")) == f'"{long}\\\n  \\ b"'
    assert "".join(item_pieces(f"{long} b")) == f"{long}\n  b"
    assert max(map(len, (*quoted_pieces(long), *item_pieces(long)))) < 10_000
    numbers = from_definition("p/N", "uint8[] u\nint32[] i")(u=bytes(50_000), i=list(range(50_000)))
    pieces: list[str] = []
    emit_message(pieces.append, numbers)
    assert "".join(pieces) == str(numbers) == f"u: {[0] * 50_000}\ni: {list(range(50_000))}"
    assert max(map(len, pieces)) < 200_000


odd = st.text(" \n\t:'\"\\#%-?[]{},&*!|>=~.0123456789_eExXonyOffNULlTrue\xe9\u2028\U0001f600", max_size=200)


@example("\xe9" * 19 + "ab" + "\xe9" * 20 + "cd")
@example("\xe9" * 20 + "ab" + "\xe9" * 19 + "c d")
@example("- " + "word " * 40)
@example("it's " * 16 + " 'word " * 16 + "a" * 200)
@example("'" + "a" * 100 + " b")
@example("'" + "a" * 100 + " ")
@example("'a\n\n" + "b" * 78 + " c d\n" + "e" * 79 + " f")
@given(odd | st.lists(odd | st.sampled_from(["word", "a" * 80, " "])).map(" ".join) | st.text(max_size=200))
def test_strings_are_those_of_pyyaml(text: str) -> None:
    text = text.encode("utf-8", "replace").decode()  # without halves of surrogate pairs
    assert "".join(quoted_pieces(text)) + "\n" == yaml.safe_dump(text, default_style='"')
    assert "- " + "".join(item_pieces(text)) + "\n" == yaml.safe_dump([text])


@pytest.mark.slow
@given(messages(cls))
def test_any_message_can_be_printed(message: Any) -> None:
    for options in ({}, {"no_string": True}, {"no_array": True}, {"width": 8}):
        assert format_message(message, **options).startswith("b: ")  # type: ignore[arg-type]  # keyword options
