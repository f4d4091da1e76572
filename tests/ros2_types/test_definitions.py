"""The grammar of ROS 2's definitions."""

from __future__ import annotations

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pyros1.ground.errors import DefinitionError
from pyros1.ros2_types.definitions import MAX_FIELDS, MAX_TEXT_LENGTH, full_type_name, parse_types
from pyros1.ros2_types.model import STRUCT_CODES, Field, FieldType, Length, MessageType

PRIMITIVES = sorted(STRUCT_CODES)


def fields(text: str) -> dict[str, FieldType]:
    return dict(parse_types("pkg/msg/T", text)["pkg/msg/T"].fields)


def field_type(text: str) -> FieldType:
    return fields(f"{text} x")["x"]


def test_primitive_types() -> None:
    text = "".join(f"{name} {name}_value\n" for name in [*PRIMITIVES, "string", "wstring"])
    assert fields(text) == {f"{name}_value": FieldType(name) for name in [*PRIMITIVES, "string", "wstring"]}
    assert field_type("char") == FieldType("uint8")


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("int8[3]", FieldType("int8", Length.FIXED, 3)),
        ("int8[]", FieldType("int8", Length.UNBOUNDED)),
        ("int8[<=5]", FieldType("int8", Length.BOUNDED, 5)),
        ("char[<=5]", FieldType("uint8", Length.BOUNDED, 5)),
        ("string<=10", FieldType("string", string_bound=10)),
        ("wstring<=10[]", FieldType("wstring", Length.UNBOUNDED, 0, 10)),
        ("string<=10[<=5]", FieldType("string", Length.BOUNDED, 5, 10)),
        ("string<=4294967295[4294967295]", FieldType("string", Length.FIXED, 4294967295, 4294967295)),
        ("Other", FieldType("pkg/msg/Other")),
        ("other/Type[2]", FieldType("other/msg/Type", Length.FIXED, 2)),
        ("other/msg/Type[]", FieldType("other/msg/Type", Length.UNBOUNDED)),
        ("other/action/Fly_Goal", FieldType("other/action/Fly_Goal")),
        ("String", FieldType("pkg/msg/String")),
        ("Mocap/frame", FieldType("Mocap/msg/frame")),
    ],
)
def test_field_types(text: str, expected: FieldType) -> None:
    assert field_type(text) == expected


@pytest.mark.parametrize(
    "line",
    [
        "int8 x",
        "  int8   x  ",
        "\tint8\tx\t",
        "int8 x\r",
        "int8 x# comment",
        "int8 x #= comment",
        "int8 x 5",
        "int8 x -5 # comment",
        "int8 x 5#comment = 3",
        "int8 A=3\nint8 x",
        "int8 A = 3\nint8 x",
        "int8 x=3\nint8 x",  # a constant, whatever its capitals are
        "# int8 y\n\n   # int8 z\nint8 x",
        'string A="# not a comment"\nint8 x',
        "string<=5 A='b'\nint8 x",
    ],
)
def test_lines(line: str) -> None:
    assert fields(line) == {"x": FieldType("int8")}


@pytest.mark.parametrize(
    "default",
    ['"a b"', "'a # b'", '"a=b"', '"=== # = "', r'"\""', "[1, 2, 3]", '["a#", "=b"]', "ハロー"],
)
def test_defaults_are_skipped(default: str) -> None:
    assert fields(f"string x {default}\nint8 y") == {"x": FieldType("string"), "y": FieldType("int8")}


def test_dependencies() -> None:
    text = (
        "# comment\nHeader h\nstd_msgs/Header i\n"
        + "=" * 80
        + "\nMSG: pkg/msg/Header\nint8 a\r\n====\r\nMSG: std_msgs/Header \r\n"
        + "builtin_interfaces/Time stamp\n\n===\nMSG: builtin_interfaces/msg/Time\n"
    )
    assert parse_types("pkg/T", text) == {
        "pkg/msg/T": MessageType(
            "pkg/msg/T", (Field("h", FieldType("pkg/msg/Header")), Field("i", FieldType("std_msgs/msg/Header")))
        ),
        "pkg/msg/Header": MessageType("pkg/msg/Header", (Field("a", FieldType("int8")),)),
        "std_msgs/msg/Header": MessageType(
            "std_msgs/msg/Header", (Field("stamp", FieldType("builtin_interfaces/msg/Time")),)
        ),
        "builtin_interfaces/msg/Time": MessageType("builtin_interfaces/msg/Time", ()),
    }


def test_the_first_of_two_definitions_counts() -> None:
    types = parse_types("p/A", "B b\n===\nMSG: p/B\nint8 x\n===\nMSG: p/msg/B\nint16 x\n===\nMSG: p/A\nint8 y")
    assert types["p/msg/A"].fields == (Field("b", FieldType("p/msg/B")),)
    assert types["p/msg/B"].fields == (Field("x", FieldType("int8")),)


def test_a_second_definition_of_the_type_itself_does_not_count() -> None:
    assert parse_types("p/A", "int8 x\n===\nMSG: p/A\nint8 y")["p/msg/A"].fields == (Field("x", FieldType("int8")),)


def test_a_text_that_begins_with_a_title() -> None:
    types = parse_types("p/msg/A", "===\nMSG: p/A\nB b\n===\nMSG: p/B\nint8 x\n")
    assert types["p/msg/A"].fields == (Field("b", FieldType("p/msg/B")),)
    assert list(types) == ["p/msg/A", "p/msg/B"]


def test_an_empty_text() -> None:
    assert parse_types("p/msg/A", "") == {"p/msg/A": MessageType("p/msg/A", ())}


def test_services() -> None:
    assert parse_types("p/srv/S", "int8 a\nT t\n---\n===\nMSG: p/T\nbool b") == {
        "p/srv/S_Request": MessageType("p/srv/S_Request", (Field("a", FieldType("int8")), Field("t", T))),
        "p/srv/S_Response": MessageType("p/srv/S_Response", ()),
        "p/msg/T": MessageType("p/msg/T", (Field("b", FieldType("bool")),)),
    }
    assert list(parse_types("p/srv/S", "---")) == ["p/srv/S_Request", "p/srv/S_Response"]
    # The same name may be in request and response.
    assert len(parse_types("p/srv/S", "int8 a\n --- \nint8 a")) == 2


T = FieldType("p/msg/T")


def test_actions() -> None:
    types = parse_types("p/action/A", "int8 goal\n---\nint8 result\n---\nint8 feedback")
    assert {name: [field.name for field in each.fields] for name, each in types.items()} == {
        "p/action/A_Goal": ["goal"],
        "p/action/A_Result": ["result"],
        "p/action/A_Feedback": ["feedback"],
    }


def test_parts_of_services_and_actions_stored_like_messages() -> None:
    text = "unique_identifier_msgs/UUID goal_id\nA_Feedback feedback\n===\nMSG: p/action/A_Feedback\nint8 x\n"
    types = parse_types("p/action/A_FeedbackMessage", text.replace("A_F", "p/action/A_F", 1))
    assert list(types) == ["p/action/A_FeedbackMessage", "p/action/A_Feedback"]
    assert list(parse_types("p/srv/S_Request", "int8 x")) == ["p/srv/S_Request"]


@pytest.mark.parametrize(
    ("text", "line", "reason"),
    [
        ("int8", 1, "not of the form"),
        ("int8 x\n\nint8 #y", 3, "not a legal name"),
        ("#\nint8# y", 2, "not of the form"),
        ("int8 x\nint8 x", 2, "occurs twice"),
        ("int8 x-y", 1, "not a legal name"),
        ("int8 _x", 1, "not a legal name"),
        ("int8 x_", 1, "not a legal name"),
        ("int8 x__y", 1, "not a legal name"),
        ("int8 1x", 1, "not a legal name"),
        ("int8 é", 1, "not a legal name"),
        ("int8 =3", 1, "not of the form"),
        ("int8[3 x", 1, "not a legal field type"),
        ("int8[<=] x", 1, "lacks the maximum"),
        ("int8[0] x", 1, "sizes are from 1"),
        ("int8[<=0] x", 1, "sizes are from 1"),
        ("int8[4294967296] x", 1, "sizes are from 1"),
        (f"int8[{'9' * 5000}] x", 1, "not a legal field type"),
        ("int8[-1] x", 1, "not a legal field type"),
        ("int8[1][2] x", 1, "not a legal field type"),
        ("int8[٣] x", 1, "not a legal field type"),
        ("string<=0 x", 1, "sizes are from 1"),
        ("string<= x", 1, "not a legal field type"),
        ("int8<=3 x", 1, "only strings"),
        ("Other<=3 x", 1, "only strings"),
        ("a/b/c x", 1, "not a legal type name"),
        ("a/msg/b/c x", 1, "not a legal type name"),
        ("a// x", 1, "not a legal type name"),
        ("__x x", 1, "not a legal type name"),
        ("int8[2] A=3", 1, "not a legal constant type"),
        ("Other A=3", 1, "not a legal constant type"),
        ("int8 x\n---\nint8 y", 2, "a line '---' too many"),
        ("int8 x\n===\nint8 y", 3, "no 'MSG: type' line"),
        ("int8 x\n===", 3, "no 'MSG: type' line"),
        ("int8 x\n===\nIDL: p/msg/T\nmodule p {", 3, "IDL is not supported"),
        ("int8 x\n===\nMSG: T", 3, "not a type name"),
        ("int8 x\n===\nMSG: p/srv/T", 3, r"\[p/srv/T\] lacks 1 of its lines '---'"),
        ("int8 x\n===\nMSG: p/B\nint8", 4, "not of the form"),
        ("\0", 1, "not of the form"),
    ],
)
def test_errors_name_the_line(text: str, line: int, reason: str) -> None:
    with pytest.raises(DefinitionError, match=reason) as caught:
        parse_types("pkg/msg/T", text)
    assert (caught.value.where, caught.value.line) == ("pkg/msg/T", line)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize(("name", "text"), [("p/srv/S", ""), ("p/action/A", "---"), ("p/action/A", "---\n---\n---")])
def test_a_wrong_number_of_parts(name: str, text: str) -> None:
    with pytest.raises(DefinitionError, match="'---'"):
        parse_types(name, text)


@pytest.mark.parametrize("name", ["", "T", "a/b/c", "a/msg/T/", "a/msg/", "/T", "a/T\n", "a b/T", "a/msg/T_", "a__b/T"])
def test_names_that_are_not_legal(name: str) -> None:
    with pytest.raises(DefinitionError, match="is not a type name"):
        parse_types(name, "")


def test_full_names() -> None:
    assert full_type_name("std_msgs/String") == full_type_name("std_msgs/msg/String") == "std_msgs/msg/String"
    assert full_type_name("std_srvs/srv/SetBool_Request") == "std_srvs/srv/SetBool_Request"


@pytest.mark.parametrize(
    ("text", "circle"),
    [
        ("T t", "pkg/msg/T -> pkg/msg/T"),
        ("int8 x\npkg/msg/T[] t", "pkg/msg/T -> pkg/msg/T"),
        ("A a\n===\nMSG: pkg/A\nB b\n===\nMSG: pkg/B\nA a", "pkg/msg/A -> pkg/msg/B -> pkg/msg/A"),
        ("int8 x\n===\nMSG: pkg/A\nA a", "pkg/msg/A -> pkg/msg/A"),  # not used by T
    ],
)
def test_types_that_contain_themselves(text: str, circle: str) -> None:
    with pytest.raises(DefinitionError, match=f"contains itself: {circle}"):
        parse_types("pkg/msg/T", text)


def test_limits() -> None:
    assert len(fields("".join(f"int8 x{i}\n" for i in range(MAX_FIELDS)))) == MAX_FIELDS
    half = "".join(f"int8 x{i}\n" for i in range(MAX_FIELDS // 2))
    with pytest.raises(DefinitionError, match=f"more than {MAX_FIELDS} fields") as caught:
        parse_types("p/T", f"{half}===\nMSG: p/U\n{half}int8 y")
    assert caught.value.line == MAX_FIELDS + 3
    assert fields("#" * MAX_TEXT_LENGTH) == {}
    with pytest.raises(DefinitionError, match="the limit is"):
        fields("#" * (MAX_TEXT_LENGTH + 1))


def test_deep_nesting() -> None:
    text = "T1 x\n" + "".join(f"===\nMSG: p/T{i}\nT{i + 1} x\n" for i in range(1, 5000))
    with pytest.raises(DefinitionError, match="nested more than 64 deep"):
        parse_types("p/T0", text)


@pytest.mark.parametrize(
    "text", ["int8 " + "a_" * 500_000, "a" * 1_000_000, "int8 x\n" + "=" * 1_000_000, "a/" * 500_000 + " x"]
)
def test_long_lines_take_no_long_time(text: str) -> None:
    with pytest.raises(DefinitionError):
        parse_types("p/T", text)


names = st.from_regex(re.compile(r"[a-z](_?[a-z0-9]){0,6}"), fullmatch=True)
type_names = st.from_regex(re.compile(r"[A-Z][A-Za-z0-9]{0,6}"), fullmatch=True)
sizes = st.sampled_from([1, 2, 36, 2**32 - 1])
USED = ["pkg/msg/Used", "other/msg/Used", "other/msg/Unknown"]


@st.composite
def field_types(draw: st.DrawFn) -> FieldType:
    base = draw(st.sampled_from([*PRIMITIVES, "string", "wstring", *USED]))
    length = draw(st.sampled_from(Length))
    size = draw(sizes) if length in (Length.FIXED, Length.BOUNDED) else 0
    bound = draw(st.sampled_from([0, 1, 10, 2**32 - 1])) if base.endswith("string") else 0
    return FieldType(base, length, size, bound)


message_types = st.builds(
    lambda name, types: MessageType(f"pkg/msg/{name}", tuple(Field(*each) for each in types.items())),
    type_names.filter(lambda name: name != "Used"),
    st.dictionaries(names, field_types(), max_size=6),
)


def render(draw: st.DataObject, field: Field) -> str:
    """Return a field as a line, written in one of the ways that the grammar allows."""

    def choose(*texts: str) -> str:
        return draw.draw(st.sampled_from(texts))

    base = field.type.base
    if "/" in base:
        base = choose(base, base.replace("/msg/", "/"), *([base[8:]] if base.startswith("pkg/") else []))
    elif base == "uint8":
        base = choose("uint8", "char")
    bound = f"<={field.type.string_bound}" if field.type.string_bound else ""
    size = field.type.size
    brackets = {
        Length.SINGLE: "",
        Length.FIXED: f"[{size}]",
        Length.BOUNDED: f"[<={size}]",
        Length.UNBOUNDED: "[]",
    }[field.type.length]
    before = choose("", "# a = 3\n", "int8 A=1\n", "\n", "string B='#'\n")
    default = choose("", " 1", ' "# a = b"', "# =", "\t[1, 2]", "\r")
    return f"{before}{base}{bound}{brackets}{choose(' ', '   ', chr(9))}{field.name}{default}\n"


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(message_types, message_types, st.data())
def test_random_definitions(root: MessageType, other: MessageType, draw: st.DataObject) -> None:
    used = MessageType("pkg/msg/Used", ())
    text = "".join(render(draw, field) for field in root.fields)
    for each in (used, other):
        title = draw.draw(st.sampled_from([each.name, each.name.replace("/msg/", "/")]))
        text += f"{'=' * 80}\nMSG: {title}\n" + "".join(render(draw, field) for field in each.fields)
    assert parse_types(root.name, text) == {other.name: other, used.name: used} | {root.name: root}


@settings(max_examples=100, deadline=None)
@given(st.text("abMSG:=#/ \n\t-<[]0'\"_int8", max_size=60), st.sampled_from(["p/msg/T", "p/srv/T", "p/action/T"]))
def test_random_texts(text: str, name: str) -> None:
    try:
        types = parse_types(name, text)
    except DefinitionError:
        return
    assert all(name == each.name for name, each in types.items())
