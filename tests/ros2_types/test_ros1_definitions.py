"""ROS 1 definitions of types that only ROS 2 has."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from pyros1.finding.library import Library
from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.msgs import from_definition
from pyros1.msgs.digest import split_full_text
from pyros1.msgs.spec import MessageSpec, parse_message
from pyros1.ros2_types.counterparts import Counterparts
from pyros1.ros2_types.definitions import parse_types
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.model import STRUCT_CODES, Field, FieldType, Length, MessageType, Types
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.ros1_definitions import ros1_definition

SEPARATOR = "=" * 80


@pytest.fixture(scope="module")
def types() -> Types:
    return distribution_types()


@pytest.fixture(scope="module")
def library() -> Library:
    """The definitions that come with pyros1."""
    return Library({}, installs=[])


def nothing_installed(name: str) -> MessageSpec | None:
    return None


def test_fields(types: Types) -> None:
    name = "pkg/msg/T"
    text = """\
        std_msgs/Header header
        builtin_interfaces/Time t
        builtin_interfaces/Duration[] d
        byte b
        char c
        wstring<=3[] w
        string<=5 s
        int8[<=7] bounded
        float64[36] f
        Part part 5"""
    known = LayeredTypes(parse_types(name, f"{text}\n===\nMSG: pkg/Part\nbool x false"), types)
    definition = ros1_definition(name, known, Counterparts(types).to_ros1, nothing_installed)
    texts = split_full_text("pkg/T", definition)
    assert {name: text.strip().split("\n") for name, text in texts.items()} == {
        "pkg/T": [
            "std_msgs/Header header",
            "time t",
            "duration[] d",
            "byte b",
            "uint8 c",
            "string[] w",
            "string s",
            "int8[] bounded",
            "float64[36] f",
            "pkg/Part part",
        ],
        "std_msgs/Header": ["uint32 seq", "time stamp", "string frame_id"],
        "pkg/Part": ["bool x"],
    }
    assert f"\n{SEPARATOR}\nMSG: pkg/Part\n" in definition
    message: Any = from_definition("pkg/T", definition)()
    assert message.header.seq == 0 and message.part.x is False


def test_types_that_ros1_has_keep_their_definitions(types: Types, library: Library) -> None:
    """The md5 sums of messages that use them depend on constants and comments, which ROS 2's types do not have."""
    known = LayeredTypes(parse_types("pkg/msg/T", "sensor_msgs/PointCloud2 cloud\nvisualization_msgs/Marker m"), types)
    to_ros1 = Counterparts(types).to_ros1
    definition = ros1_definition("pkg/msg/T", known, to_ros1, library.find_message)
    expected = parse_message("pkg/T", "sensor_msgs/PointCloud2 cloud\nvisualization_msgs/Marker m\n")
    assert definition == library.digests.full_text(expected)
    assert from_definition("pkg/T", definition)._md5sum == library.digests.md5(expected)


@pytest.mark.parametrize("name", ["std_msgs/String", "nav_msgs/Odometry", "tf2_msgs/TFMessage", "std_msgs/Empty"])
def test_definitions_of_types_without_constants_have_the_md5_sums_of_ros1(
    types: Types, library: Library, name: str
) -> None:
    counterparts = Counterparts(types)
    definition = ros1_definition(counterparts.to_ros2(name), types, counterparts.to_ros1, nothing_installed)
    assert from_definition(name, definition)._md5sum == library.digests.md5(library.message(name))


def test_all_types_of_the_distribution_can_be_defined(types: Types, library: Library) -> None:
    to_ros1 = Counterparts(types).to_ros1
    for name in types:
        definition = ros1_definition(name, types, to_ros1, library.find_message)
        assert from_definition(to_ros1(name), definition)._type == to_ros1(name)


def test_parts_of_services(types: Types) -> None:
    services = parse_types("pkg/srv/S", "int8 a\n---\nint16 b")
    to_ros1 = Counterparts(types).to_ros1
    assert ros1_definition("pkg/srv/S_Request", services, to_ros1, nothing_installed).strip() == "int8 a"
    assert ros1_definition("pkg/srv/S_Response", services, to_ros1, nothing_installed).strip() == "int16 b"


def test_missing_types(types: Types, library: Library) -> None:
    to_ros1 = Counterparts(types).to_ros1
    with pytest.raises(UnknownTypeError, match=r"\[pkg/msg/B\] is missing"):
        ros1_definition("pkg/msg/A", parse_types("pkg/msg/A", "B b"), to_ros1, nothing_installed)

    def find_installed(name: str) -> MessageSpec | None:
        return parse_message(name, "Other other") if name == "pkg/A" else None

    with pytest.raises(UnknownTypeError, match=r"\[pkg/Other\] is missing"):
        ros1_definition("pkg/msg/A", parse_types("pkg/msg/A", "int8 a"), to_ros1, find_installed)


def test_types_that_contain_themselves(types: Types) -> None:
    circle = {"p/msg/A": MessageType("p/msg/A", (Field("a", FieldType("p/msg/A")),))}
    with pytest.raises(DefinitionError, match="contains itself"):
        ros1_definition("p/msg/A", circle, Counterparts(types).to_ros1, nothing_installed)


primitives = st.sampled_from([*sorted(STRUCT_CODES), "string", "std_msgs/msg/Header", "builtin_interfaces/msg/Time"])
lengths = st.sampled_from([(Length.SINGLE, 0), (Length.FIXED, 1), (Length.FIXED, 36), (Length.UNBOUNDED, 0)])
field_types = st.tuples(primitives, lengths).map(lambda each: FieldType(each[0], *each[1]))


@settings(max_examples=40, deadline=None)
@given(st.lists(field_types, max_size=8), st.lists(field_types, max_size=3))
def test_there_and_back(first: list[FieldType], second: list[FieldType]) -> None:
    """A type that ROS 1 can represent is the same after it was written as a ROS 1 definition and derived from it."""
    types = distribution_types()
    used = MessageType("pkg/msg/Used", tuple(Field(f"x{i}", each) for i, each in enumerate(second)))
    root = MessageType(
        "pkg/msg/T", (*(Field(f"x{i}", each) for i, each in enumerate(first)), Field("used", FieldType(used.name)))
    )
    counterparts = Counterparts(types)
    known = LayeredTypes({root.name: root, used.name: used}, types)
    texts = split_full_text("pkg/T", ros1_definition(root.name, known, counterparts.to_ros1, nothing_installed))
    specs = {name: parse_message(name, text) for name, text in texts.items()}
    assert counterparts.derive(specs["pkg/T"], specs.__getitem__) == {root.name: root, used.name: used}
