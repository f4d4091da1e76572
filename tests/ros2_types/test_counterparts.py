"""Which ROS 1 type is which ROS 2 type."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable

import pytest

from pyros1.bag.export.rosbags_types import parse_types as parse_ros1_types
from pyros1.finding.library import Library
from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.msgs.spec import MessageSpec, parse_message, parse_service
from pyros1.ros2_types.counterparts import MAX_TYPES, Counterparts
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.legal_names import LegalNames
from pyros1.ros2_types.model import Field, FieldType, Length, MessageType, Types
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.type_hash import action_hash, service_hash, type_hash


@pytest.fixture(scope="module")
def types() -> Types:
    return distribution_types("kilted")


@pytest.fixture(scope="module")
def library() -> Library:
    """The definitions that come with pyros1."""
    return Library({}, installs=[])


@pytest.fixture
def counterparts(types: Types) -> Counterparts:
    return Counterparts(types)


def resolver(**texts: str) -> Callable[[str], MessageSpec]:
    """Return the function that finds the types of the package pkg."""

    def resolve(name: str) -> MessageSpec:
        return parse_message(name, texts[name.removeprefix("pkg/")])

    return resolve


@pytest.mark.parametrize(
    ("ros1", "ros2"),
    [
        ("std_msgs/String", "std_msgs/msg/String"),
        ("tf2_msgs/TFMessage", "tf2_msgs/msg/TFMessage"),
        ("Mocap/my_frame", "mocap/msg/MyFrame"),
        ("pkg/T", "pkg/msg/T"),
        ("pkg/Add_Request", "pkg/msg/AddRequest"),
    ],
)
def test_names(counterparts: Counterparts, ros1: str, ros2: str) -> None:
    assert counterparts.to_ros2(ros1) == ros2
    assert counterparts.to_ros1(ros2) == ros1


def test_a_moved_type_is_the_one_with_the_new_name(counterparts: Counterparts) -> None:
    assert counterparts.to_ros2("tf/tfMessage") == "tf2_msgs/msg/TFMessage"
    assert counterparts.to_ros1("tf2_msgs/msg/TFMessage") == "tf2_msgs/TFMessage"


def test_names_of_services_and_actions(counterparts: Counterparts) -> None:
    assert counterparts.service_to_ros2("std_srvs/SetBool") == "std_srvs/srv/SetBool"
    assert counterparts.service_to_ros2("Arm/grip_it") == "arm/srv/GripIt"
    assert counterparts.action_to_ros2("pkg/Fibonacci") == "pkg/action/Fibonacci"
    assert counterparts.to_ros1("std_srvs/srv/SetBool") == "std_srvs/SetBool"
    assert counterparts.to_ros1("std_srvs/srv/SetBool_Request") == "std_srvs/SetBoolRequest"
    assert counterparts.to_ros1("arm/srv/GripIt") == "Arm/grip_it"
    assert counterparts.to_ros1("arm/srv/GripIt_Response") == "Arm/grip_itResponse"
    assert counterparts.to_ros1("pkg/action/Fibonacci_Feedback") == "pkg/FibonacciFeedback"
    assert counterparts.to_ros1("pkg/msg/Odd_Feedback") == "pkg/Odd_Feedback"  # a message, not part of an action


def test_names_that_are_not_legal(counterparts: Counterparts) -> None:
    for convert in (counterparts.to_ros2, counterparts.service_to_ros2, counterparts.action_to_ros2):
        for name in ("", "T", "a/b/c", "a/é", "a/b\n"):
            with pytest.raises(DefinitionError, match="is not a type name"):
                convert(name)
    with pytest.raises(DefinitionError, match="is not a type name"):
        counterparts.to_ros1("nonsense")


def test_types_of_the_distribution_are_not_derived(counterparts: Counterparts, library: Library) -> None:
    assert counterparts.derive(library.message("nav_msgs/Odometry"), library.message) == {}
    assert counterparts.derive(library.message("tf/tfMessage"), library.message) == {}
    # Nor are the types that the one in ROS 1 uses, but not the one in ROS 2.
    assert counterparts.derive(parse_message("std_msgs/String", "pkg/Part part"), resolver(Part="int8 x")) == {}


def test_derived_fields(counterparts: Counterparts) -> None:
    text = """\
        Header header
        time t
        duration[] d
        byte b
        char[3] c
        bool flag
        string[] s
        float64[36] f
        geometry_msgs/Point p
        Part[] parts
        int8 CONSTANT=3"""
    resolve = resolver(Part="uint8[] data")
    standard = Library({}, installs=[]).message
    derived = counterparts.derive(
        parse_message("pkg/T", text), lambda name: resolve(name) if name.startswith("pkg/") else standard(name)
    )
    assert derived == {
        "pkg/msg/T": MessageType(
            "pkg/msg/T",
            (
                Field("header", FieldType("std_msgs/msg/Header")),
                Field("t", FieldType("builtin_interfaces/msg/Time")),
                Field("d", FieldType("builtin_interfaces/msg/Duration", Length.UNBOUNDED)),
                Field("b", FieldType("byte")),
                Field("c", FieldType("uint8", Length.FIXED, 3)),
                Field("flag", FieldType("bool")),
                Field("s", FieldType("string", Length.UNBOUNDED)),
                Field("f", FieldType("float64", Length.FIXED, 36)),
                Field("p", FieldType("geometry_msgs/msg/Point")),
                Field("parts", FieldType("pkg/msg/Part", Length.UNBOUNDED)),
            ),
        ),
        "pkg/msg/Part": MessageType("pkg/msg/Part", (Field("data", FieldType("uint8", Length.UNBOUNDED)),)),
    }


def test_names_are_those_of_converted_bags(counterparts: Counterparts, types: Types) -> None:
    parts = {"my_part": "int8 aB\nint8 a_b\nint8 A__b\n", "MyPart": "int8 x\n"}
    text = "my_part first\nMyPart second\nuint8 timeStamp\nuint8 X\n"
    derived = counterparts.derive(parse_message("pkg/T", text), lambda name: parse_message(name, parts[name[4:]]))
    names = LegalNames(types)
    full_text = text + "".join(f"{'=' * 80}\nMSG: pkg/{name}\n{part}" for name, part in parts.items())
    converted = names.legal_types(parse_ros1_types("pkg/T", full_text))
    assert {name: [field.name for field in each.fields] for name, each in derived.items()} == {
        name: [field for field, _ in fields] for name, (_, fields) in converted.items()
    }
    assert [field.type.base for field in derived["pkg/msg/T"].fields[:2]] == ["pkg/msg/MyPart2", "pkg/msg/MyPart"]
    assert [field.name for field in derived["pkg/msg/MyPart2"].fields] == ["a_b2", "a_b", "a_b3"]
    assert counterparts.to_ros1("pkg/msg/MyPart2") == "pkg/my_part"
    assert counterparts.to_ros1("pkg/msg/MyPart") == "pkg/MyPart"


def test_derived_messages_have_the_hashes_of_ros2(types: Types, library: Library) -> None:
    """Types that are the same in ROS 1 are derived as if ROS 2 did not have them."""
    base = {name: types[name] for name in types if name.startswith("builtin_") or name == "std_msgs/msg/Header"}
    counterparts = Counterparts(base)
    for name in (
        "nav_msgs/msg/Odometry",
        "diagnostic_msgs/msg/DiagnosticArray",
        "std_msgs/msg/Char",
        "std_msgs/msg/Empty",
    ):
        derived = counterparts.derive(library.message(counterparts.to_ros1(name)), library.message)
        assert name in derived and "std_msgs/msg/Header" not in derived
        assert type_hash(name, LayeredTypes(derived, base)) == type_hash(name, types)


@pytest.mark.parametrize(
    ("name", "digits"),
    [
        ("std_srvs/SetBool", "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a"),
        ("std_srvs/Trigger", "eeff2cd6fa5ad9d27cdf4dec64818317839b62f212a91e6b5304b634b2062c5f"),
        ("diagnostic_msgs/SelfTest", "df1e4e54a814a16ccc77471e9239618d46818e8d0e3b45ad6f8c34c6e2abfef6"),
        ("nav_msgs/GetPlan", "234f7aff100f5edb8150366601687b027bcdc253db47decb88fff846193fe5e8"),
    ],
)
def test_derived_services_have_the_hashes_of_ros2(
    counterparts: Counterparts, types: Types, library: Library, name: str, digits: str
) -> None:
    derived = counterparts.derive_service(library.service(name), library.message)
    ros2_name = counterparts.service_to_ros2(name)
    assert list(derived) == [f"{ros2_name}_Request", f"{ros2_name}_Response"]
    assert service_hash(ros2_name, LayeredTypes(derived, types)) == f"RIHS01_{digits}"


def test_services_with_types_and_names_of_their_own(counterparts: Counterparts) -> None:
    spec = parse_service("pkg/do_it", "Part myPart\n---\nNext next\n")
    derived = counterparts.derive_service(spec, resolver(Part="int8 x", Next="Part part"))
    assert {name: [*each.fields] for name, each in derived.items()} == {
        "pkg/srv/DoIt_Request": [Field("my_part", FieldType("pkg/msg/Part"))],
        "pkg/srv/DoIt_Response": [Field("next", FieldType("pkg/msg/Next"))],
        "pkg/msg/Part": [Field("x", FieldType("int8"))],
        "pkg/msg/Next": [Field("part", FieldType("pkg/msg/Part"))],
    }
    # A message with the name that genmsg gives to the request is another type.
    assert counterparts.to_ros2("pkg/DoItRequest") == "pkg/msg/DoItRequest"


def test_actions(counterparts: Counterparts) -> None:
    resolve = resolver(
        FibonacciGoal="int32 order", FibonacciResult="int32[] sequence", FibonacciFeedback="Part p", Part=""
    )
    derived = counterparts.derive_action("pkg/Fibonacci", resolve)
    assert list(derived) == [
        "pkg/msg/Part",
        *(f"pkg/action/Fibonacci_{part}" for part in ("Goal", "Result", "Feedback")),
    ]
    assert derived["pkg/action/Fibonacci_Goal"].fields == (Field("order", FieldType("int32")),)
    assert derived["pkg/action/Fibonacci_Feedback"].fields == (Field("p", FieldType("pkg/msg/Part")),)
    assert action_hash("pkg/action/Fibonacci", derived).startswith("RIHS01_")


@pytest.mark.parametrize(
    ("texts", "reason"),
    [
        ({"T": "T t"}, "contains itself"),
        ({"T": "A a", "A": "B b", "B": "A a"}, "contains itself"),
        ({f"T{i}" if i else "T": f"T{i + 1} t" for i in range(65)} | {"T65": ""}, "nested more than"),
        ({"T": "int8[0] x"}, "array of 0 elements"),
    ],
)
def test_types_that_ros2_cannot_have(counterparts: Counterparts, texts: dict[str, str], reason: str) -> None:
    resolve = resolver(**texts)
    with pytest.raises(DefinitionError, match=reason):
        counterparts.derive(resolve("pkg/T"), resolve)


@pytest.mark.parametrize("number", [MAX_TYPES, MAX_TYPES + 1])
def test_number_of_types(counterparts: Counterparts, number: int) -> None:
    texts = {f"T{i}": "" for i in range(1, number)}
    resolve = resolver(T="".join(f"{name} x{name}\n" for name in texts), **texts)
    if number == MAX_TYPES:
        assert len(counterparts.derive(resolve("pkg/T"), resolve)) == number
    else:
        with pytest.raises(DefinitionError, match="uses 1001 types; the limit is 1000"):
            counterparts.derive(resolve("pkg/T"), resolve)


def test_missing_types(counterparts: Counterparts, library: Library) -> None:
    with pytest.raises(UnknownTypeError):
        counterparts.derive(parse_message("pkg/T", "Missing m"), library.message)


def test_rosbags_is_imported_when_it_is_needed() -> None:
    program = "import sys, pyros1.ros2_types.counterparts as tried; assert 'rosbags' not in sys.modules"
    program += "; assert tried.Counterparts({}).to_ros2('a/B') == 'a/msg/B' and 'rosbags' in sys.modules"
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
