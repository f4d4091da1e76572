"""md5 sums and full texts (G11-G14)."""

from __future__ import annotations

import hashlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import DefinitionError
from pyros1.msgs.digest import SEPARATOR, Digests, split_full_text
from pyros1.msgs.spec import parse_message, parse_service


def digests(**texts: str) -> Digests:
    return Digests(lambda name: parse_message(name, texts[name.partition("/")[2]]))


def md5(text: str) -> str:
    return hashlib.md5(text.encode()).hexdigest()


def test_g11_constants_first_then_fields_comments_and_spaces_gone() -> None:
    text = "int8   a # c\nstring X =  v # kept \nfloat32 F=1.50 # gone\nuint8[4]  b\n"
    expected = "string X=v # kept\nfloat32 F=1.50\nint8 a\nuint8[4] b"
    assert digests().md5(parse_message("p/T", text)) == md5(expected)


def test_g11_message_fields_by_md5_without_brackets() -> None:
    spec = parse_message("p/T", "A[] many\nA one\nint8[] n")
    inner = md5("int8 x")
    assert digests(A="int8 x").md5(spec) == md5(f"{inner} many\n{inner} one\nint8[] n")


def test_g11_lengths_of_arrays_as_they_are_written() -> None:
    assert digests().md5(parse_message("p/T", "int8[03] a")) == md5("int8[03] a")


def test_g11_text_is_stripped_as_a_whole() -> None:
    assert digests().md5(parse_message("p/T", "string X=")) == md5("string X=")
    assert digests().md5(parse_message("p/T", "")) == "d41d8cd98f00b204e9800998ecf8427e"


def test_g12_services_join_without_separator() -> None:
    assert digests().md5(parse_service("p/S", "int8 a\n---\nint8 b")) == md5("int8 aint8 b")


def test_g14_full_text_depth_first_each_once() -> None:
    spec = parse_message("p/T", "B b\nC c # end\n")
    full = digests(B="D d\n", C="D d\nB b", D="int8 x").full_text(spec)
    parts = ["B b\nC c # end\n\n", "MSG: p/B\nD d\n\n", "MSG: p/D\nint8 x\n", "MSG: p/C\nD d\nB b"]
    assert full == (SEPARATOR + "\n").join(parts)
    texts = split_full_text("p/T", full)
    assert texts == {"p/T": "B b\nC c # end\n", "p/B": "D d\n", "p/D": "int8 x", "p/C": "D d\nB b"}
    assert list(texts) == ["p/T", "p/B", "p/D", "p/C"]


def test_a_full_text_may_end_with_a_type_without_fields() -> None:
    assert split_full_text("p/T", f"Empty e\n{SEPARATOR}\nMSG: p/Empty") == {"p/T": "Empty e", "p/Empty": ""}
    with pytest.raises(DefinitionError, match="no 'MSG: type' line after a separator"):
        split_full_text("p/T", f"Empty e\n{SEPARATOR}")


def test_a_type_that_contains_itself_is_an_error() -> None:
    texts = {"A": "B b", "B": "A[] a", "S": "S s"}
    for name, text in texts.items():
        spec = parse_message(f"p/{name}", text)
        with pytest.raises(DefinitionError, match="contains itself: p/"):
            digests(**texts).md5(spec)
        with pytest.raises(DefinitionError, match="contains itself: p/"):
            digests(**texts).dependencies(spec)


def test_very_deep_nesting_is_an_error() -> None:
    texts = {f"T{i}": f"T{i + 1} x" for i in range(5000)} | {"T5000": "int8 x"}
    with pytest.raises(DefinitionError, match="deep"):
        digests(**texts).md5(parse_message("p/T0", texts["T0"]))
    one_by_one = digests(**texts)
    with pytest.raises(DefinitionError, match="deep"):
        for i in range(5000, 0, -1):
            one_by_one.md5(parse_message(f"p/T{i}", texts[f"T{i}"]))


def test_nesting_that_is_not_too_deep() -> None:
    texts = {f"T{i}": f"T{i + 1} x" for i in range(63)} | {"T63": "int8 x"}
    assert len(digests(**texts).dependencies(parse_message("p/T0", texts["T0"]))) == 63


@given(
    st.one_of(st.text(), st.lists(st.sampled_from([SEPARATOR, "MSG:", " ", "p/A", "\n", "int8 x", "="])).map("".join))
)
def test_any_full_text_is_cut_or_refused(text: str) -> None:
    try:
        parts = split_full_text("p/T", text)
    except DefinitionError:
        return
    assert next(iter(parts)) == "p/T"
