"""What is said about the rules of mapping files."""

from __future__ import annotations

from pyros1.ros2.pairs.mapping_check import check_mapping
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2_types.mapping import PackageRule, TypeMapping, TypeRule


def check(*rules: TypeRule) -> list[tuple[str, bool]]:
    mapping = TypeMapping(rules, [PackageRule("a_msgs", "b_msgs", "f:1")])
    (package, is_usable), *lines = check_mapping(mapping, TypePairs("jazzy", mapping))
    assert package == "f:1: a_msgs is b_msgs in ROS 2" and is_usable
    return lines


def test_rules_that_can_be_used() -> None:
    lines = check(
        TypeRule("geometry_msgs/Point", "geometry_msgs/msg/Vector3", {"x": "y"}, None, "f:3"),
        TypeRule("std_srvs/Empty", "my_srvs/srv/Nothing", None, None, "f:5"),
    )
    assert lines == [
        ("f:3: geometry_msgs/Point is geometry_msgs/msg/Vector3", True),
        (
            "    geometry_msgs/Point is geometry_msgs/msg/Vector3, but only ROS 1 has y, z, only ROS 2 has x, z: "
            "left out on the way there, zero or empty on the way back",
            True,
        ),
        (
            "f:5: std_srvs/Empty is my_srvs/srv/Nothing, with the ROS 1 fields, since its definition is not here",
            True,
        ),
    ]


def test_a_name_that_is_misspelt() -> None:
    ((line, is_usable),) = check(TypeRule("std_msgs/String", "std_msgs/msg/Strin", place="f:3"))
    assert line == (
        "f:3: std_msgs/String is std_msgs/msg/Strin, with the ROS 1 fields, but ROS 2 has no known type "
        "Strin in std_msgs/msg (did you mean 'String'?)"
    )
    assert not is_usable


def test_rules_that_cannot_be_used() -> None:
    lines = check(
        TypeRule("nowhere_msgs/A", "std_msgs/msg/String", place="f:3"),
        TypeRule("std_msgs/String", "std_msgs/msg/Int8", place="f:5"),
        TypeRule("std_msgs/Int8", "std_msgs/msg/Int16", {"x": "data"}, place="f:7"),
    )
    assert [is_usable for _, is_usable in lines] == [False] * 3
    unknown, mismatch, wrong = [line for line, _ in lines]
    assert unknown.startswith("f:3: nowhere_msgs/A is std_msgs/msg/String, once a ROS 1 node publishes it; not yet: ")
    assert mismatch.startswith("f:5: std_msgs/String and std_msgs/msg/Int8 are not exchanged: ")
    assert "string of ROS 1 is not int8 of ROS 2" in mismatch
    assert "f:7: std_msgs/Int8 has no field 'x'; it has data" in wrong
