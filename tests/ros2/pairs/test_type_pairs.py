"""Which ROS 2 type a ROS 1 type is: by names, definitions and hashes."""

from __future__ import annotations

import struct
from pathlib import Path

import pytest

from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.ground.errors import Error, UnknownTypeError
from pyros1.msgs import from_definition, load_message, load_service
from pyros1.ros2.pairs.lookup_cache import TimeBudget
from pyros1.ros2.pairs.type_pairs import DISTRIBUTIONS, TypePair, TypePairs
from pyros1.ros2.zenoh.names import HUMBLE_HASH
from pyros1.ros2_types.definitions import parse_types
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.mapping import PackageRule, TypeMapping, TypeRule
from pyros1.ros2_types.nesting import LayeredTypes
from pyros1.ros2_types.rclpy_packages import RclpyPackages
from pyros1.ros2_types.type_hash import service_hash, type_hash

STRING = "RIHS01_df668c740482bbd48fb39d76a70dfd4bd59db1288021743503259e948f6b1a18"
OWN_TEXT = "Header header\nint32 number\nstring text\n"


def of_ros1(pairs: TypePairs, name: str, hash: str | None = None) -> TypePair:
    message_class = load_message(name)
    return pairs.for_ros1(name, message_class._md5sum, message_class._full_text, hash)


def test_a_standard_type() -> None:
    pairs = TypePairs()
    pair = of_ros1(pairs, "std_msgs/String")
    assert (pair.ros1, pair.ros2, pair.hash) == ("std_msgs/String", "std_msgs/msg/String", STRING)
    assert pair.transcoder.to_cdr(b"\2\0\0\0hi") == b"\0\1\0\0\3\0\0\0hi\0"
    assert of_ros1(pairs, "std_msgs/String") is pair, "it is remembered"
    back = pairs.for_ros2("std_msgs/msg/String", STRING)
    assert (back.ros1, back.md5sum, back.definition) == (pair.ros1, pair.md5sum, "string data\n")


def test_a_type_that_was_moved() -> None:
    pair = of_ros1(TypePairs(), "tf/tfMessage")
    assert pair.ros2 == "tf2_msgs/msg/TFMessage"
    assert TypePairs().for_ros2(pair.ros2, pair.hash).ros1 == "tf2_msgs/TFMessage"


@pytest.mark.parametrize("distribution", DISTRIBUTIONS)
def test_the_hash_says_which_distribution_it_is(distribution: str) -> None:
    name = "sensor_msgs/msg/Range"  # its fields were not always the same
    types = distribution_types(distribution)
    hash = type_hash(name, types)
    pair = TypePairs("humble" if distribution != "humble" else "jazzy").for_ros2(name, hash)
    assert pair.hash == hash and pair.ros1 == "sensor_msgs/Range"
    has_variance = "variance" in [field.name for field in types[name].fields]
    assert pair.transcoder.only_ros2 == (["variance"] if has_variance else [])


def test_humble_has_no_hashes() -> None:
    pair = of_ros1(TypePairs(), "sensor_msgs/Range", HUMBLE_HASH)
    assert pair.hash == HUMBLE_HASH and not pair.transcoder.only_ros2
    assert TypePairs().for_ros2("std_msgs/msg/String", HUMBLE_HASH).ros1 == "std_msgs/String"


def own_topic() -> LocalTopic:
    text = f"{OWN_TEXT}{'=' * 80}\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\nstring frame_id\n"
    message_class = from_definition("my_msgs/Thing", text)
    return LocalTopic("/thing", "my_msgs/Thing", message_class._md5sum, text, False, ("/node",))


def test_a_type_of_the_users() -> None:
    pairs, topic = TypePairs(), own_topic()
    pair = pairs.for_ros1(topic.type, topic.md5sum, topic.definition)
    assert pair.ros2 == "my_msgs/msg/Thing" and pair.hash.startswith("RIHS01_")
    body = struct.pack("<IIII", 7, 1, 2, 0) + struct.pack("<iI", 5, 2) + b"hi"
    cdr = pair.transcoder.to_cdr(body)
    assert cdr == b"\0\1\0\0" + struct.pack("<iII", 1, 2, 1) + b"\0\0\0\0" + struct.pack("<iI", 5, 3) + b"hi\0"
    assert pair.transcoder.from_cdr(cdr, 7) == body
    with pytest.raises(UnknownTypeError, match="the definition of my_msgs/msg/Thing is not known here"):
        pairs.for_ros2(pair.ros2, pair.hash)
    assert pairs.for_ros2(pair.ros2, pair.hash, topic).transcoder is pair.transcoder, "a topic here has it"


def test_ros2_expects_another_definition() -> None:
    with pytest.raises(UnknownTypeError, match="ROS 2 expects a definition of std_msgs/msg/String"):
        of_ros1(TypePairs(), "std_msgs/String", "RIHS01_" + "0" * 64)


def test_a_type_that_only_ros2_has() -> None:
    pair = TypePairs().for_ros2(
        "geometry_msgs/msg/VelocityStamped", type_hash("geometry_msgs/msg/VelocityStamped", distribution_types())
    )
    assert pair.ros1 == "geometry_msgs/VelocityStamped"
    message_class = from_definition(pair.ros1, pair.definition)
    assert message_class._md5sum == pair.md5sum and "body_frame_id" in message_class.__slots__


def test_a_definition_that_lies() -> None:
    with pytest.raises(Error, match="does not match its md5sum"):
        TypePairs().for_ros1("my_msgs/Thing", "0" * 32, OWN_TEXT + "int8 more\n")


def test_failures_are_remembered_without_growing() -> None:
    pairs = TypePairs()
    raised = []
    for _ in range(3):
        with pytest.raises(UnknownTypeError) as caught:
            pairs.for_ros2("no_msgs/msg/Such", STRING)
        depth, trace = 0, caught.value.__traceback__
        while trace is not None:
            depth, trace = depth + 1, trace.tb_next
        raised.append((str(caught.value), depth))
    assert raised[1] == raised[2] and raised[0][0] == raised[1][0]


def test_a_distribution_that_is_not_known() -> None:
    with pytest.raises(UnknownTypeError, match=r"'jassy' are not known; known: .*jazzy"):
        TypePairs("jassy")


def test_a_bad_definition_does_not_spoil_a_good_one() -> None:
    topic = own_topic()
    pairs = TypePairs()
    for bad in ("", "int32 other\n"):
        with pytest.raises(Error):
            pairs.for_ros1(topic.type, topic.md5sum, bad)
    assert pairs.for_ros1(topic.type, topic.md5sum, topic.definition).md5sum == topic.md5sum


def test_unknown_types_of_ros2_do_not_take_all_the_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.ros2.pairs.type_pairs.TimeBudget", lambda: TimeBudget(0.02))
    pairs = TypePairs()
    texts = []
    for number in range(100):
        with pytest.raises(Error) as caught:
            pairs.for_ros2(f"strange_msgs/msg/Type{number}", STRING)
        texts.append(str(caught.value))
    assert "not known here" in texts[0] and "looked up later" in texts[-1]
    assert of_ros1(pairs, "std_msgs/String").hash == STRING, "ROS 1's own types are always found"


@pytest.mark.parametrize("name", ["std_msgs/" + "A" * 201, "a" * 201 + "/Type"])
def test_a_name_that_no_key_can_have(name: str) -> None:
    message_class = from_definition(name, "int32 number\n")
    with pytest.raises(Error, match="is not the name of a ROS 2 type"):
        TypePairs().for_ros1(name, message_class._md5sum, message_class._full_text)


@pytest.fixture
def beside_rclpy(tmp_path: Path) -> TypePairs:
    """Pairs with the types of two packages that are installed beside rclpy."""
    texts = {
        "std_msgs/msg/String.msg": "string data\n",
        "std_srvs/srv/SetBool.srv": "bool data\n---\nbool success\nstring message\n",
        "std_srvs/srv/Trigger.srv": "---\nbool success\nstring message\nint32 added\n",
    }
    for name, text in texts.items():
        path = tmp_path / "share" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return TypePairs(beside_rclpy=RclpyPackages([tmp_path]))


def test_installed_types(beside_rclpy: TypePairs) -> None:
    assert of_ros1(beside_rclpy, "std_msgs/String").hash == STRING
    assert beside_rclpy.for_ros2("std_msgs/msg/String", STRING).ros1 == "std_msgs/String"
    default = TypePairs().service_for_ros1("std_srvs/SetBool", "*")
    assert beside_rclpy.service_for_ros1("std_srvs/SetBool", "*").hash == default.hash
    added = beside_rclpy.service_for_ros2(
        "std_srvs/srv/Trigger", beside_rclpy.service_for_ros1("std_srvs/Trigger", "*").hash
    )
    assert added.response.from_cdr(b"\0\1\0\0\1\0\0\0\1\0\0\0\0\0\0\0\5\0\0\0") == b"\1\0\0\0\0"


def test_types_that_are_not_installed(beside_rclpy: TypePairs) -> None:
    missing = "package geometry_msgs is not installed in this ROS 2 installation"
    with pytest.raises(UnknownTypeError, match=missing):
        of_ros1(beside_rclpy, "geometry_msgs/Point")
    with pytest.raises(UnknownTypeError, match=missing):
        beside_rclpy.for_ros2("geometry_msgs/msg/Point", HUMBLE_HASH)
    with pytest.raises(UnknownTypeError, match="package nav_msgs is not installed in this ROS 2 installation"):
        beside_rclpy.service_for_ros1("nav_msgs/GetMap", "*")
    with pytest.raises(UnknownTypeError, match="ROS 2 expects a definition of std_msgs/msg/String"):
        of_ros1(beside_rclpy, "std_msgs/String", STRING[:-1] + "0")


FLAT = "builtin_interfaces/Time stamp\nfloat64 x\nfloat64 y\nstring extra\n"


def flat_pairs(installed: bool = True, distribution: str = "jazzy") -> TypePairs:
    rule = TypeRule(
        "geometry_msgs/PointStamped",
        "flat_msgs/msg/Flat",
        {"header.stamp": "stamp", "point.x": "y", "point.y": "x"},
        place="map.yaml:1",
    )
    mapping = TypeMapping([rule], [PackageRule("std_srvs", "my_srvs")])
    return TypePairs(distribution, mapping, parse_types("flat_msgs/msg/Flat", FLAT) if installed else {})


def test_a_type_of_a_mapping_file() -> None:
    types = LayeredTypes(parse_types("flat_msgs/msg/Flat", FLAT), distribution_types())
    pair = of_ros1(flat_pairs(), "geometry_msgs/PointStamped")
    assert (pair.ros2, pair.hash) == ("flat_msgs/msg/Flat", type_hash("flat_msgs/msg/Flat", types))
    body = struct.pack("<IIII3d", 7, 1, 2, 0, 3.0, 4.0, 5.0)
    cdr = b"\0\1\0\0" + struct.pack("<iI2dI", 1, 2, 4.0, 3.0, 1) + b"\0"
    assert pair.transcoder.to_cdr(body) == cdr
    assert pair.transcoder.from_cdr(cdr, 7) == body[:-8] + bytes(8)
    back = flat_pairs().for_ros2(pair.ros2, pair.hash)
    assert (back.ros1, back.md5sum) == ("geometry_msgs/PointStamped", pair.md5sum)
    with pytest.raises(Error, match="the definition of flat_msgs/msg/Flat is needed"):
        of_ros1(flat_pairs(installed=False), "geometry_msgs/PointStamped")


def test_a_type_of_ros1_that_is_not_known_here() -> None:
    rule = TypeRule("nowhere_msgs/A", "std_msgs/msg/String", {"text": "data"})
    pairs = TypePairs("jazzy", TypeMapping([rule]))
    with pytest.raises(UnknownTypeError, match="the definition of nowhere_msgs/A is not known here"):
        pairs.for_ros2("std_msgs/msg/String", STRING)
    message_class = from_definition("nowhere_msgs/A", "string text\n")
    local = LocalTopic("/a", "nowhere_msgs/A", message_class._md5sum, message_class._full_text, False, ("/n",))
    assert pairs.for_ros2("std_msgs/msg/String", STRING, local).ros1 == "nowhere_msgs/A", "a topic here has it"


def test_services_of_a_mapping_file() -> None:
    rule = TypeRule("std_srvs/SetBool", "my_interfaces/srv/Switch", {"data": "on"}, None)
    pairs = TypePairs("jazzy", TypeMapping([rule]))
    message_class = load_service("std_srvs/SetBool")
    pair = pairs.service_for_ros1("std_srvs/SetBool", message_class._md5sum)
    text = "bool on\n---\nbool success\nstring message\n"
    types = LayeredTypes(parse_types("my_interfaces/srv/Switch", text), distribution_types())
    assert (pair.ros2, pair.hash) == ("my_interfaces/srv/Switch", service_hash("my_interfaces/srv/Switch", types))
    assert pair.request.to_cdr(b"\1") == b"\0\1\0\0\1"
    assert pairs.service_for_ros2(pair.ros2, pair.hash).ros1 == "std_srvs/SetBool"
    text = "string more\nbool on\n---\nbool success\nstring message\n"
    installed = parse_types("my_interfaces/srv/Switch", text)
    pair = TypePairs("jazzy", TypeMapping([rule]), installed).service_for_ros1(
        "std_srvs/SetBool", message_class._md5sum
    )
    assert pair.request.to_cdr(b"\1") == b"\0\1\0\0\1\0\0\0\0\1" and pair.request.only_ros2 == ["more"]
    assert flat_pairs().service_for_ros1("std_srvs/SetBool", message_class._md5sum).ros2 == "my_srvs/srv/SetBool"


def test_definitions_of_ros2_on_this_machine() -> None:
    installed = parse_types("my_msgs/msg/Thing", "int32 number\nstring<=5 text\n")
    pairs = TypePairs("jazzy", installed=installed)
    hash = type_hash("my_msgs/msg/Thing", installed)
    assert pairs.for_ros2("my_msgs/msg/Thing", hash).definition == "int32 number\nstring text\n"
    pair = pairs.for_ros2("my_msgs/msg/Thing", hash, own_topic())
    assert (pair.md5sum, pair.transcoder.only_ros1) == (own_topic().md5sum, ["header"])
