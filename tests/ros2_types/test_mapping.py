"""Types and fields that have other names in ROS 2: rules, and messages converted by them."""

from __future__ import annotations

import struct

import pytest

from pyros1.ground.errors import DefinitionError, MessageError
from pyros1.msgs.spec import MessageSpec, parse_message
from pyros1.ros2_types.counterparts import Counterparts
from pyros1.ros2_types.definitions import parse_types
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.mapping import FieldRule, PackageRule, TypeMapping, TypeRule
from pyros1.ros2_types.model import FieldType
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.transcoding.transcoder import Transcoder

STANDARD = distribution_types()
HEADER = "uint32 seq\ntime stamp\nstring frame_id\n"


def specs(**texts: str) -> dict[str, MessageSpec]:
    return {"std_msgs/Header": parse_message("std_msgs/Header", HEADER)} | {
        f"x/{name}": parse_message(f"x/{name}", text) for name, text in texts.items()
    }


def transcoder(ros1: str, ros2: str, fields: dict[str, str] | None = None, **nested: str) -> Transcoder:
    """Return what converts x/T and x/msg/T of these definitions; further ones of ROS 1 are nested."""
    types = LayeredTypes(parse_types("x/msg/T", ros2), STANDARD)
    rules = {} if fields is None else {("x/T", "x/msg/T"): FieldRule(fields, "map.yaml:3")}
    return Transcoder("x/T", specs(T=ros1, **nested), "x/msg/T", types, rules)


def test_names_by_rules() -> None:
    mapping = TypeMapping(
        [
            TypeRule("my_msgs/A", "other/msg/B"),
            TypeRule("my_msgs/A2", "other/msg/B"),
            TypeRule("my_msgs/Do", "other/srv/DoIt"),
        ],
        [PackageRule("my_msgs", "my_interfaces")],
    )
    counterparts = Counterparts(STANDARD, mapping)
    assert counterparts.to_ros2("my_msgs/A") == counterparts.to_ros2("my_msgs/A2") == "other/msg/B"
    assert counterparts.to_ros1("other/msg/B") == "my_msgs/A", "the first one"
    assert counterparts.to_ros2("my_msgs/C") == "my_interfaces/msg/C"
    assert counterparts.to_ros1("my_interfaces/msg/C") == "my_msgs/C"
    assert counterparts.service_to_ros2("my_msgs/Do") == "other/srv/DoIt"
    assert counterparts.service_to_ros2("my_msgs/A") == "my_interfaces/srv/A", "a rule for messages"
    assert counterparts.to_ros1("other/srv/DoIt_Request") == "my_msgs/DoRequest"
    assert counterparts.to_ros2("std_msgs/String") == "std_msgs/msg/String"


def test_packages_that_were_split_or_joined() -> None:
    packages = [PackageRule("old", "one"), PackageRule("old", "two"), PackageRule("older", "two")]
    types = LayeredTypes(parse_types("two/msg/A", "int8 a"), parse_types("two/srv/S", "---\n"), STANDARD)
    counterparts = Counterparts(types, TypeMapping((), packages), lambda name, is_service: name == "older/A")
    assert counterparts.to_ros2("old/A") == "two/msg/A", "it is known there"
    assert counterparts.service_to_ros2("old/S") == "two/srv/S"
    assert counterparts.to_ros2("old/B") == "one/msg/B"
    assert counterparts.to_ros1("one/msg/B") == "old/B"
    assert counterparts.to_ros1("two/msg/A") == "older/A", "it is known there"
    assert counterparts.to_ros1("two/msg/C") == "old/C"


def test_standard_names() -> None:
    counterparts = Counterparts(STANDARD)
    assert counterparts.to_ros2("rosgraph_msgs/Log") == "rcl_interfaces/msg/Log"
    assert counterparts.to_ros1("rcl_interfaces/msg/Log") == "rosgraph_msgs/Log"
    assert counterparts.service_to_ros2("rospy_tutorials/AddTwoInts") == "example_interfaces/srv/AddTwoInts"
    assert counterparts.to_ros1("example_interfaces/srv/AddTwoInts") == "roscpp_tutorials/TwoInts"
    mapping = TypeMapping([TypeRule("rosgraph_msgs/Log", "my/msg/Log")])
    assert Counterparts(STANDARD, mapping).to_ros2("rosgraph_msgs/Log") == "my/msg/Log", "a user's rules come first"


def test_derived_types_have_the_other_names() -> None:
    rule = TypeRule("x/T", "y/msg/U", {"b": "second", "a": "first"})
    counterparts = Counterparts(STANDARD, TypeMapping([rule], [PackageRule("x", "z")]))
    found = specs(T="int32 a\nPart b", Part="int8 c")
    types = counterparts.derive(found["x/T"], found.__getitem__)
    assert [*types["y/msg/U"].fields] == [("first", FieldType("int32")), ("second", FieldType("z/msg/Part"))]
    assert "z/msg/Part" in types
    for fields in ({"a": "in.first"}, {"a.b": "first"}, {"missing": "first"}):
        counterparts = Counterparts(STANDARD, TypeMapping([TypeRule("x/T", "y/msg/U", fields, place="map.yaml:7")]))
        with pytest.raises(DefinitionError, match=r"map.yaml:7: the definition of y/msg/U is needed"):
            counterparts.derive(found["x/T"], found.__getitem__)


def test_renamed_fields_in_another_order() -> None:
    convert = transcoder("uint8 a\nstring b\nfloat64 c", "float64 z\nuint8 x\nstring y", {"a": "x", "b": "y", "c": "z"})
    body = b"\7\2\0\0\0hi" + struct.pack("<d", 1.5)
    cdr = b"\0\1\0\0" + struct.pack("<dB3xI", 1.5, 7, 3) + b"hi\0"
    assert convert.to_cdr(body) == cdr and convert.from_cdr(cdr) == body
    assert convert.only_ros1 == convert.only_ros2 == []


def test_only_listed_fields_belong_together() -> None:
    convert = transcoder("uint8 a\nuint8 b", "uint8 b\nuint8 c", {"a": "c"})
    assert convert.to_cdr(b"\1\2") == b"\0\1\0\0\0\1" and convert.from_cdr(b"\0\1\0\0\3\4") == b"\4\0"
    assert (convert.only_ros1, convert.only_ros2) == (["b"], ["b"])


def test_fields_of_nested_messages() -> None:
    convert = transcoder(
        "Header header\nuint8 a\nInner v",
        "float64 w\nbuiltin_interfaces/Time stamp\nuint8 a\nstd_msgs/Header head",
        {"header.stamp": "stamp", "v.deep.w": "w", "a": "a", "header.frame_id": "head.frame_id"},
        Inner="uint8 n\nDeep deep",
        Deep="float64 w",
    )
    body = struct.pack("<IIiI", 9, 1, 2, 1) + b"f" + b"\5" + b"\6" + struct.pack("<d", 2.5)
    cdr = b"\0\1\0\0" + struct.pack("<diIB3xiII", 2.5, 1, 2, 5, 0, 0, 2) + b"f\0"
    assert convert.to_cdr(body) == cdr
    assert convert.from_cdr(cdr, 9) == body.replace(b"\5\6", b"\5\0")
    assert convert.only_ros1 == ["v.n"] and convert.only_ros2 == ["head.stamp"]


def test_rules_are_for_nested_types_too() -> None:
    types = parse_types("x/msg/T", "Part[] parts\n===\nMSG: x/Part\nuint16 second\nuint8 first")
    rules = {("x/Part", "x/msg/Part"): FieldRule({"a": "first", "b": "second"})}
    found = specs(T="Part[] parts", Part="uint8 a\nuint16 b")
    convert = Transcoder("x/T", found, "x/msg/T", types, rules)
    body, cdr = b"\2\0\0\0\1\2\0\3\4\0", b"\0\1\0\0\2\0\0\0\2\0\1\0\4\0\3"
    assert convert.to_cdr(body) == cdr and convert.from_cdr(cdr) == body


@pytest.mark.parametrize(
    ("fields", "complaint"),
    [
        ({"nope": "x"}, "map.yaml:3: x/T has no field 'nope'; it has header, a, list"),
        ({"a": "nope"}, "map.yaml:3: x/msg/T has no field 'nope'; it has x, t"),
        ({"header.nope": "x"}, "std_msgs/Header has no field 'nope'; it has seq, stamp, frame_id"),
        ({"a.b": "x"}, "'a' of x/T is not a single message"),
        ({"list.stamp": "x"}, "'list' of x/T is not a single message"),
        ({"header.stamp.sec": "x"}, "'stamp' of std_msgs/Header is not a single message"),
        ({"header": "t", "header.stamp": "x"}, "'header' is already used as a whole"),
        ({"a": "t"}, "uint8 of ROS 1 is not builtin_interfaces/msg/Time of ROS 2"),
        ({".".join(["header"] * 500): "x"}, "std_msgs/Header has no field 'header'"),
    ],
)
def test_rules_that_do_not_fit(fields: dict[str, str], complaint: str) -> None:
    with pytest.raises(DefinitionError) as caught:
        transcoder("Header header\nuint8 a\nHeader[] list", "uint8 x\nbuiltin_interfaces/Time t", fields)
    assert complaint in str(caught.value) and len(str(caught.value)) < 1000


def test_integers_of_other_sizes() -> None:
    convert = transcoder("int32 a\nuint8[] b\nint64[2] c", "int64 a\nuint16[] b\nint8[2] c")
    body = struct.pack("<iI2B2q", -5, 2, 1, 255, -128, 127)
    cdr = b"\0\1\0\0" + struct.pack("<qI2H2b", -5, 2, 1, 255, -128, 127)
    assert convert.to_cdr(body) == cdr and convert.from_cdr(cdr) == body
    with pytest.raises(MessageError, match="c is 128, which is not a value of int8"):
        convert.to_cdr(struct.pack("<iI2q", 0, 0, 0, 128))
    with pytest.raises(MessageError, match="a is 2147483648, which is not a value of int32"):
        convert.from_cdr(b"\0\1\0\0" + struct.pack("<qI2b", 1 << 31, 0, 0, 0))
    assert convert.from_cdr(b"\0\0\0\0" + struct.pack(">qIH2b", 7, 1, 300 - 45, 0, 0))[:4] == b"\7\0\0\0"


def test_floats_of_other_sizes() -> None:
    convert = transcoder("float32 a\nfloat64 b", "float64 a\nfloat32 b")
    body = struct.pack("<fd", 0.5, 0.25)
    cdr = b"\0\1\0\0" + struct.pack("<df", 0.5, 0.25)
    assert convert.to_cdr(body) == cdr and convert.from_cdr(cdr) == body
    for value in (float("inf"), float("-inf"), float("nan")):
        assert convert.to_cdr(struct.pack("<fd", 0, value))[-4:] == struct.pack("<f", value)
    for value in (0.1, 1e300):
        with pytest.raises(MessageError, match="which float32 cannot hold without loss"):
            convert.to_cdr(struct.pack("<fd", 0, value))


@pytest.mark.parametrize(
    ("ros1", "ros2"),
    [("int32", "uint32"), ("int8", "uint16"), ("bool", "int8"), ("int32", "float64"), ("byte", "bool")],
)
def test_numbers_that_would_lose_something(ros1: str, ros2: str) -> None:
    with pytest.raises(DefinitionError, match=f"a: {ros1} of ROS 1 is not {ros2} of ROS 2"):
        transcoder(f"{ros1} a", f"{ros2} a")


def test_skipped_elements_with_other_numbers() -> None:
    convert = transcoder(
        "Part[] parts\nuint8 end",
        "uint8 end\nPart2[] parts\n===\nMSG: x/Part2\nint64 a\nuint8 b",
        Part="int32 a\nuint8 b",
    )
    body = struct.pack("<IiBiBB", 2, -1, 2, 3, 4, 9)
    cdr = b"\0\1\0\0" + struct.pack("<B3xIqB7xqB", 9, 2, -1, 2, 3, 4)
    assert convert.to_cdr(body) == cdr and convert.from_cdr(cdr) == body


def test_log_messages() -> None:
    ros1 = (
        "Header header\nbyte level\nstring name\nstring msg\nstring file\nstring function\nuint32 line\nstring[] topics"
    )
    found = specs() | {"rosgraph_msgs/Log": parse_message("rosgraph_msgs/Log", ros1)}
    convert = Transcoder("rosgraph_msgs/Log", found, "rcl_interfaces/msg/Log", STANDARD)
    assert (convert.only_ros1, convert.only_ros2) == (["header.frame_id", "topics"], [])
    for level1, level2 in ((1, 10), (2, 20), (4, 30), (8, 40), (16, 50)):
        body = struct.pack("<IIII", 3, 5, 6, 0) + bytes([level1]) + b"\1\0\0\0n" + bytes(12) + struct.pack("<II", 8, 0)
        cdr = convert.to_cdr(body)
        assert cdr[:15] == b"\0\1\0\0" + struct.pack("<iIB", 5, 6, level2) + b"\0\0"
        assert convert.from_cdr(cdr, 3) == body
    mapping = TypeMapping([TypeRule("rosgraph_msgs/Log", "rcl_interfaces/msg/Log", {"level": "level", "msg": "name"})])
    own = Transcoder("rosgraph_msgs/Log", found, "rcl_interfaces/msg/Log", STANDARD, mapping.fields)
    assert own.to_cdr(body)[12] == 50, "a user's rule for the fields does not change what levels mean"
    for level2, level1 in ((0, 1), (19, 1), (25, 2), (255, 16)):  # others than those that have names
        assert convert.from_cdr(b"\0\1\0\0" + bytes(8) + bytes([level2]) + bytes(27))[16] == level1
