"""The list of all pairs of types."""

from __future__ import annotations

from math import inf

import pytest

from pyros1.ros2.pairs.lookup_cache import TimeBudget
from pyros1.ros2.pairs.pair_list import ListedPair, list_messages, list_services
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.model import Field, FieldType, MessageType

INSTALLED = ["std_msgs/String", "tf/tfMessage", "actionlib/TestGoal", "nowhere/Nothing"]
ALL = {name: distribution_types()[name] for name in ("std_msgs/msg/String", "rcl_interfaces/msg/FloatingPointRange")}
THERE = {**ALL, "std_msgs/msg/Header": distribution_types()["std_msgs/msg/Header"]}
NESTED = {**ALL, "own/msg/Wide": MessageType("own/msg/Wide", (Field("part", FieldType("own/msg/Missing")),))}


@pytest.fixture
def pairs() -> TypePairs:
    return TypePairs(budget=TimeBudget(inf))


def test_messages(pairs: TypePairs) -> None:
    there = {**ALL, "tf2_msgs/msg/TFMessage": distribution_types()["tf2_msgs/msg/TFMessage"]}
    string, moved, derived, missing, log = list_messages(pairs, INSTALLED, there)
    assert (string, moved) == (
        ListedPair("std_msgs/String", "std_msgs/msg/String"),
        ListedPair("tf/tfMessage", "tf2_msgs/msg/TFMessage"),
    )
    assert str(derived) == "actionlib/TestGoal <-> actionlib/msg/TestGoal: as it is defined in ROS 1"
    assert missing[:2] == ("nowhere/Nothing", "") and "nowhere" in missing.note
    assert str(missing).startswith("nowhere/Nothing: ")
    assert log == (
        "rcl_interfaces/FloatingPointRange",
        "rcl_interfaces/msg/FloatingPointRange",
        "as it is defined in ROS 2",
    )


def test_why_a_type_of_ros2_has_no_counterpart(pairs: TypePairs) -> None:
    (wide,) = list_messages(pairs, [], NESTED, ["own/msg/Wide"])
    assert wide[:2] == ("", "own/msg/Wide") and "own/msg/Missing" in wide.note


@pytest.mark.parametrize("name", ["std_msgs/String", "std_msgs/msg/String"])
def test_only_what_is_named(pairs: TypePairs, name: str) -> None:
    assert [each.ros2 for each in list_messages(pairs, INSTALLED, THERE, [name])] == ["std_msgs/msg/String"]


def test_services(pairs: TypePairs) -> None:
    installed = ["std_srvs/SetBool", "std_srvs/Empty", "nowhere/Nothing"]
    assert [*map(str, list_services(pairs, installed))][:2] == [
        "std_srvs/SetBool <-> std_srvs/srv/SetBool",
        "std_srvs/Empty <-> std_srvs/srv/Empty",
    ]
    (missing,) = list_services(pairs, installed, ["nowhere/srv/Nothing"])
    assert missing[:2] == ("nowhere/Nothing", "") and missing.note
