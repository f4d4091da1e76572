"""Type hashes, against those in the packages of ROS 2 Kilted."""

from __future__ import annotations

import pytest

from pyros1.ground.errors import DefinitionError, UnknownTypeError
from pyros1.ros2_types.definitions import parse_types
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.interfaces import action_types, service_types
from pyros1.ros2_types.model import Field, FieldType, MessageType
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.type_hash import action_hash, service_hash, type_hash

KNOWN = {
    "std_msgs/msg/String": "df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18",
    "std_msgs/msg/Char": "3ad2d04dd29ba19d04b16659afa3ccaedd691914b02a64e82e252f2fa6a586a9",
    "std_msgs/msg/Byte": "41e1a3345f73fe93ede006da826a6ee274af23dd4653976ff249b0f44e3e798f",
    "std_msgs/msg/Empty": "20b625256f32d5dbc0d04fee44f43c41e51c70d3502f84b4a08e7a9c26a96312",
    "nav_msgs/msg/Odometry": "3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0",
    "sensor_msgs/msg/Image": "d31d41a9a4c4bc8eae9be757b0beed306564f7526c88ea6a4588fb9582527d47",
    "sensor_msgs/msg/JointState": "a13ee3a330e346c9d87b5aa18d24e11690752bd33a0350f11c5882bc9179260e",
    "service_msgs/msg/ServiceEventInfo": "41bcbbe07a75c9b52bc96bfd5c24d7f0fc0a08c0cb7921b3373c5732345a6f45",
    "shape_msgs/msg/SolidPrimitive": "2802a15190aadc3f496584df4b0b4c5824d8a0b31aaef839faa75bc34dda38ac",  # [<=3]
    "tf2_msgs/msg/TFMessage": "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087",
    "visualization_msgs/msg/Marker": "45b13ccf791f225962bf74e746f9644518855d783a6f42ba0cc14fde2b4f3ce0",
}

STRINGS = """\
string string_value
string string_value_default1 "Hello world!"
string string_value_default2 "Hello'world!"
string string_value_default3 'Hello"world!'
string string_value_default4 'Hello\\'world!'
string string_value_default5 "Hello\\"world!"
string STRING_CONST="Hello world!"
string<=22 bounded_string_value
string<=22 bounded_string_value_default1 "Hello world!"
string<=22 bounded_string_value_default2 "Hello'world!"
string<=22 bounded_string_value_default3 'Hello"world!'
string<=22 bounded_string_value_default4 'Hello\\'world!'
string<=22 bounded_string_value_default5 "Hello\\"world!"
"""
WSTRINGS = """\
wstring wstring_value
wstring wstring_value_default1 "Hello world!"
wstring wstring_value_default2 "Hellö wörld!"
wstring wstring_value_default3 "ハローワールド"
#wstring WSTRING_CONST="Hello world!"
wstring[3] array_of_wstrings
wstring[<=3] bounded_sequence_of_wstrings
wstring[] unbounded_sequence_of_wstrings
"""
FIBONACCI = "#goal definition\nint32 order\n---\n#result\nint32[] sequence\n---\n#feedback\nint32[] sequence\n"


@pytest.mark.parametrize(("name", "digits"), KNOWN.items())
def test_messages_of_a_distribution(name: str, digits: str) -> None:
    assert type_hash(name, distribution_types("kilted")) == f"RIHS01_{digits}"


@pytest.mark.parametrize(
    ("name", "text", "digits"),
    [
        ("Strings", STRINGS, "eee55533636293ac7c94c62432eedb5777eb849847d2a17b4dcead8c4a20ab32"),
        ("WStrings", WSTRINGS, "5a2c8ddb2054600023b9a180652f2ba895373217cad4b1f0fc1258c9e4424a79"),
    ],
)
def test_strings(name: str, text: str, digits: str) -> None:
    name = f"test_msgs/msg/{name}"
    assert type_hash(name, parse_types(name, text)) == f"RIHS01_{digits}"


@pytest.mark.parametrize(
    ("name", "text", "digits"),
    [
        (
            "std_srvs/srv/SetBool",
            "bool data # e.g.\n---\nbool success\nstring message\n",
            "abe9e4bb6b41b40e6789712c00ec8871923e089af3f667a79992a428cff2da0a",
        ),
        ("std_srvs/srv/Empty", "---\n", "5888399dedec5ccc85ea6451949fd2c9f97bfdf963f9a588821639fcd31b5d19"),
        (
            "example_interfaces/srv/AddTwoInts",
            "int64 a\nint64 b\n---\nint64 sum\n",
            "e118de6bf5eeb66a2491b5bda11202e7b68f198d6f67922cf30364858239c81a",
        ),
    ],
)
def test_services(name: str, text: str, digits: str) -> None:
    types = parse_types(name, text)
    assert service_hash(name, types) == f"RIHS01_{digits}"
    assert service_hash(name, LayeredTypes(types, distribution_types())) == f"RIHS01_{digits}"


def test_parts_of_a_service() -> None:
    name = "std_srvs/srv/Trigger"
    types = parse_types(name, "---\nbool success\nstring message\n")
    all_types = LayeredTypes(types, service_types(name, types))
    assert {name for name in all_types if "/srv/" in name} == {name, *(f"{name}_{part}" for part in TRIGGER)}
    for part, digits in TRIGGER.items():
        assert type_hash(f"{name}_{part}", all_types) == f"RIHS01_{digits}"


TRIGGER = {
    "Request": "d010825374ce8918e72bfd826c82603e60f45419e932ea976f807b74a863a199",
    "Response": "2d946c21e2fc3f1e9ca6986a8191d85fcc70097a8bb7771a053564bc47009cdf",
    "Event": "ec4a1d26b0575e61906890342aba9523a2360e9845857c5590fa6e23bc39e1c2",
}


def test_actions() -> None:
    name = "test_msgs/action/Fibonacci"
    types = parse_types(name, FIBONACCI)
    assert action_hash(name, types) == "RIHS01_be9273e3557225044b4a040811112491f7079326e3a573f83258b0b4c30bd069"
    services = {
        "SendGoal": "d807633803e38e164276573cd97e9fbd71e109c290bbf4cc312a0a1c9da7bbd9",
        "GetResult": "5d30fdeb21d20e117aa5f36c7b4f0b6874f1a8cf7a9c038d58f1156c5737b209",
    }
    for service, digits in services.items():
        assert service_hash(f"{name}_{service}", types) == f"RIHS01_{digits}"
    sent = {
        "FeedbackMessage": "37487bae8cea358366b97003c1ef1ca7ce7c08df36f9e8cca496624226aee64e",
        "SendGoal_Request": "dfe75c73dc2c090cbc8fd8c45039bfa279d16aa6aadd348f812c6adad26e669e",
        "SendGoal_Response": "1e7e84f7edf1fb020d9e51c7842bceef4cbdbd847f354125f3227cf4f314a683",
        "GetResult_Request": "c65e93c4c4328d7f1abd6ace83dba8e5fa0f32de76b4d2c96b5c655d94803b92",
        "GetResult_Response": "ef88159d47a3d21d9bf4bec690cf668939d9542db28a9cfd77dbcd97eaf1add2",
    }
    derived = action_types(name, types)
    assert {each for each in derived if "/action/" in each} == {f"{name}_{part}" for part in sent}
    for part, digits in sent.items():
        assert type_hash(f"{name}_{part}", LayeredTypes(types, derived)) == f"RIHS01_{digits}"


def test_a_service_that_is_named_like_a_part_of_an_action() -> None:
    types = parse_types("p/srv/Drop_SendGoal", "int8 a\n---\nint8 b")
    assert [each.name for each in service_types("p/srv/Drop_SendGoal", types)["p/srv/Drop_SendGoal"].fields] == [
        "request_message",
        "response_message",
        "event_message",
    ]


def test_standard_types_are_added_only_if_they_are_missing() -> None:
    types = parse_types("a/action/A", FIBONACCI)
    assert "unique_identifier_msgs/msg/UUID" in action_types("a/action/A", types)
    layered = LayeredTypes(types, distribution_types())
    assert all("/action/" in name for name in action_types("a/action/A", layered))
    assert all("/action/" in name for name in service_types("a/action/A_SendGoal", layered))


def test_missing_types() -> None:
    types = parse_types("a/msg/A", "B b")
    with pytest.raises(UnknownTypeError, match=r"\[a/msg/B\] is missing"):
        type_hash("a/msg/A", types)
    with pytest.raises(UnknownTypeError, match=r"\[a/srv/A_Request\] is missing"):
        service_hash("a/srv/A", types)
    with pytest.raises(UnknownTypeError, match=r"\[a/action/A_Goal\] is missing"):
        service_hash("a/action/A_SendGoal", types)
    with pytest.raises(UnknownTypeError, match=r"\[a/action/A_Goal\] is missing"):
        action_hash("a/action/A", types)
    with pytest.raises(UnknownTypeError, match=r"\[nonsense_Request\] is missing"):
        service_hash("nonsense", types)


def test_types_that_contain_themselves() -> None:
    types = {
        f"p/msg/{name}": MessageType(f"p/msg/{name}", (Field("field", FieldType(f"p/msg/{used}")),))
        for name, used in [("A", "B"), ("B", "C"), ("C", "B")]
    }
    with pytest.raises(DefinitionError, match="contains itself: p/msg/B -> p/msg/C -> p/msg/B"):
        type_hash("p/msg/A", types)


@pytest.mark.slow
@pytest.mark.parametrize(("depth", "is_legal"), [(64, True), (65, False), (20_000, False)])
def test_depth(depth: int, is_legal: bool) -> None:
    leaf = Field("leaf", FieldType("p/msg/Leaf"))
    types = {
        f"p/msg/T{i}": MessageType(f"p/msg/T{i}", (leaf, Field("x", FieldType(f"p/msg/T{i + 1}"))))
        for i in range(1, depth)
    }
    types |= {name: MessageType(name, ()) for name in ("p/msg/Leaf", f"p/msg/T{depth}")}
    if is_legal:
        assert type_hash("p/msg/T1", types).startswith("RIHS01_")
    else:
        with pytest.raises(DefinitionError, match="nested more than 64 deep"):
            type_hash("p/msg/T1", types)


def test_layers() -> None:
    first, second = MessageType("a/msg/A", ()), MessageType("a/msg/A", (Field("x", FieldType("bool")),))
    layered = LayeredTypes({"a/msg/A": first}, {"a/msg/A": second, "b/msg/B": second})
    assert layered["a/msg/A"] is first
    assert list(layered) == ["a/msg/A", "b/msg/B"]
    assert len(layered) == 2
    assert "c" not in layered
    with pytest.raises(KeyError):
        layered["c"]
