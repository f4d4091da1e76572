"""The definition grammar (G01-G10)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pyros1.ground.errors import DefinitionError
from pyros1.msgs.spec import Constant, Field, action_messages, parse_message, parse_service


def fields(text: str) -> list[tuple[str, str]]:
    return [(field.name, field.type) for field in parse_message("pkg/T", text).fields]


def test_g01_g02_g03_fields_arrays_comments() -> None:
    text = "int8 a# comment\n  float64[]   b  \n\n # only a comment\nstring[3] c\r\ntime t #=\nuint8[0] z\n"
    assert fields(text) == [("a", "int8"), ("b", "float64[]"), ("c", "string[3]"), ("t", "time"), ("z", "uint8[0]")]


def test_g02_lengths() -> None:
    spec = parse_message("pkg/T", "int8 a\nint8[] b\nint8[4] c")
    assert spec.fields == (
        Field("a", "int8", None, ""),
        Field("b", "int8", -1, "[]"),
        Field("c", "int8", 4, "[4]"),
    )


def test_g05_header_names() -> None:
    assert fields("Header header")[0] == ("header", "std_msgs/Header")
    assert fields("roslib/Header[] h")[0] == ("h", "std_msgs/Header[]")
    assert fields("Header[] h")[0] == ("h", "pkg/Header[]")  # as stock: only the bare word is special
    assert parse_message("pkg/T", "Header header\nint8 a").has_header
    assert not parse_message("pkg/T", "Header h").has_header
    assert not parse_message("pkg/T", "int8 a\nHeader header").has_header


def test_g06_unqualified_types_are_of_the_same_package() -> None:
    assert fields("Foo a\nother/Bar[2] b") == [("a", "pkg/Foo"), ("b", "other/Bar[2]")]


def test_g07_empty() -> None:
    assert parse_message("pkg/T", "# nothing\n\n").fields == ()


def constant(line: str) -> Constant:
    return parse_message("pkg/T", line).constants[0]


@pytest.mark.parametrize(
    ("line", "type_name", "name", "value", "text"),
    [
        ("string X= a # b ", "string", "X", "a # b", "a # b"),
        ('string X="q"', "string", "X", '"q"', '"q"'),
        ("string  X  =  a = b", "string", "X", "a = b", "a = b"),
        ("  string X=a\r", "string", "X", "a", "a"),
        ("string E=", "string", "E", "", ""),
        ("float32 F=1.5e3 # c", "float32", "F", 1500.0, "1.5e3"),
        ("int32  Y  = 5 # =3", "int32", "Y", 5, "5"),
        ("int32 X=+5", "int32", "X", 5, "+5"),
        ("int32 X =\t7", "int32", "X", 7, "7"),
        ("int8 X=-128", "int8", "X", -128, "-128"),
        ("byte B=-1", "byte", "B", -1, "-1"),
        ("char C=255", "char", "C", 255, "255"),
        ("uint64 X=18446744073709551615", "uint64", "X", 2**64 - 1, "18446744073709551615"),
        ("bool B=True", "bool", "B", True, "True"),
        ("bool B=0", "bool", "B", False, "0"),
    ],
)
def test_g04_constants(line: str, type_name: str, name: str, value: object, text: str) -> None:
    assert constant(line) == Constant(name, type_name, value, text)  # type: ignore[arg-type]  # any value is compared
    assert type(constant(line).value) is type(value)


@pytest.mark.parametrize(
    "line",
    [
        "int32 H=0x10",
        "byte B=128",
        "char C=-1",
        "uint8 X=256",
        "int64 X=9223372036854775808",
        "bool B=x",
        "int32 x=1=2",
        "time T=1",
        "duration D=1",
        "Foo X=1",
        "string\tX=1",
        "=",
        "int32 =1",
        "string =x",
        "string a b=c",
        "int32\tx",
        "int32 x y",
        "int32",
        "int32 1x",
        "int32 _x",
        "int32 x-y",
        "int32 é",
        "int32[-1] a",
        "int32[x] a",
        "int32[][] a",
        "int32[ 3] a",
        "string<=3 x",
        "q/r/Foo x",
        "1Foo x",
        "_foo x",
        "foo/bar.baz x",
        "int32 x; y",
    ],
)
def test_errors_name_file_and_line(line: str) -> None:
    with pytest.raises(DefinitionError, match=r"^dir/T\.msg:3: .") as caught:
        parse_message("pkg/T", f"int8 before\n\n{line}\n", "dir/T.msg")
    assert (caught.value.where, caught.value.line) == ("dir/T.msg", 3)


def test_g03_duplicates() -> None:
    with pytest.raises(DefinitionError, match=r"pkg/T:2: field \[x\] occurs twice"):
        parse_message("pkg/T", "int8 x\nint8 x")
    assert len(parse_message("pkg/T", "int8 X=1\nint8 X=2").constants) == 2  # legal for stock


@pytest.mark.parametrize("name", ["T", "a/b/c", "/T", "a/", "1a/T", "a/T\n", "a b/T", ""])
def test_bad_type_names(name: str) -> None:
    with pytest.raises(DefinitionError):
        parse_message(name, "")


def test_g08_services() -> None:
    spec = parse_service("pkg/S", "int8 a\n--- anything\nstring b\n")
    assert [field.name for field in spec.request.fields] == ["a"]
    assert [field.name for field in spec.response.fields] == ["b"]
    assert (spec.request.name, spec.response.name) == ("pkg/SRequest", "pkg/SResponse")
    assert parse_service("pkg/S", "---").response.fields == ()
    for text, names in (
        ("", ""),
        ("int8 a", "a"),
        ("#---\nint8 a", "a"),
        ("---\n---\n", ""),
        ("int8 a\n---\nint8 b\n---\nint8 c", "abc"),
    ):
        spec = parse_service("pkg/S", text)
        assert "".join(field.name for part in (spec.request, spec.response) for field in part.fields) == names
        assert len(spec.request.fields) == ("a" in names)
    with pytest.raises(DefinitionError, match=r"pkg/SRequest:1: \[---\]"):
        parse_service("pkg/S", " ---\n")
    with pytest.raises(DefinitionError, match=r"x\.srv:4: "):
        parse_service("pkg/S", "int8 a\n---\nint8 b\nwrong\n", "x.srv")


def test_g09_action_texts_as_stock_writes_them() -> None:
    note = "# ====== DO NOT MODIFY! AUTOGENERATED FROM AN ACTION DEFINITION ======\n"
    texts = action_messages("pkg/Do", "# c\nint32 a\n\n---\n---\n\n# no feedback")
    assert texts == {
        "pkg/DoGoal": note + "# c\nint32 a\n\n",
        "pkg/DoResult": note,
        "pkg/DoFeedback": note + "\n# no feedback\n",
        "pkg/DoAction": note
        + "\nDoActionGoal action_goal\nDoActionResult action_result\nDoActionFeedback action_feedback\n",
        "pkg/DoActionGoal": note + "\nHeader header\nactionlib_msgs/GoalID goal_id\nDoGoal goal\n",
        "pkg/DoActionResult": note + "\nHeader header\nactionlib_msgs/GoalStatus status\nDoResult result\n",
        "pkg/DoActionFeedback": note + "\nHeader header\nactionlib_msgs/GoalStatus status\nDoFeedback feedback\n",
    }
    with pytest.raises(DefinitionError, match="two '---' lines, found 1"):
        action_messages("pkg/Do", "---")


PIECES = [
    "int8",
    "string",
    "time",
    "Header",
    "pkg/T",
    "x",
    "X",
    "=",
    "#",
    "[",
    "]",
    "3",
    "-1",
    " ",
    "\t",
    "\r",
    "\n",
    "é",
]


@given(st.one_of(st.text(), st.lists(st.sampled_from(PIECES)).map("".join)))
def test_any_text_gives_a_spec_or_the_documented_error(text: str) -> None:
    for parse in (parse_message, parse_service, action_messages):
        try:
            parse("pkg/T", text)  # type: ignore[operator]  # three functions of one shape
        except DefinitionError as error:
            assert str(error)


@pytest.mark.parametrize("bits", [8, 16, 32, 64])
def test_constants_at_the_ends_of_their_range(bits: int) -> None:
    for kind, low, high in ((f"int{bits}", -(2 ** (bits - 1)), 2 ** (bits - 1) - 1), (f"uint{bits}", 0, 2**bits - 1)):
        assert [constant(f"{kind} X={value}").value for value in (low, high)] == [low, high]
        for value in (low - 1, high + 1):
            with pytest.raises(DefinitionError, match=f"{value} does not fit in {kind}"):
                constant(f"{kind} X={value}")
