"""The types of distributions."""

from __future__ import annotations

import subprocess
import sys

import pytest

from pyros1.ground.errors import UnknownTypeError
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.model import STRINGS, STRUCT_CODES, Field, FieldType, Length, MessageType
from pyros1.ros2_types.nesting import all_types


def test_types_are_converted() -> None:
    types = distribution_types("jazzy")
    assert types["builtin_interfaces/msg/Time"] == MessageType(
        "builtin_interfaces/msg/Time", (Field("sec", FieldType("int32")), Field("nanosec", FieldType("uint32")))
    )
    solid = dict(types["shape_msgs/msg/SolidPrimitive"].fields)
    assert solid["dimensions"] == FieldType("float64", Length.BOUNDED, 3)
    assert types["geometry_msgs/msg/TwistWithCovariance"].fields == (
        Field("twist", FieldType("geometry_msgs/msg/Twist")),
        Field("covariance", FieldType("float64", Length.FIXED, 36)),
    )
    assert types["tf2_msgs/msg/TFMessage"].fields == (
        Field("transforms", FieldType("geometry_msgs/msg/TransformStamped", Length.UNBOUNDED)),
    )
    assert types["std_msgs/msg/Empty"].fields == ()
    assert types["std_msgs/msg/Char"].fields == (Field("data", FieldType("uint8")),)


def test_bounded_strings() -> None:
    fields = dict(distribution_types("lyrical")["rmw_dds_common/msg/NodeEntitiesInfo"].fields)
    assert fields["node_name"] == FieldType("string", string_bound=256)


def test_a_distribution_is_a_mapping_that_converts_each_type_once() -> None:
    types = distribution_types()
    assert len(types) == len(list(types)) > 150
    assert "std_msgs/msg/String" in types and "std_msgs/String" not in types
    assert types["std_msgs/msg/String"] is types["std_msgs/msg/String"]
    with pytest.raises(KeyError):
        types["std_msgs/String"]


@pytest.mark.parametrize("name", ["foxy", "humble", "iron", "jazzy", "kilted", "lyrical"])
def test_distributions_are_complete_and_of_known_primitives(name: str) -> None:
    types = distribution_types(name)
    assert set(all_types(types, types)) == set(types)
    bases = {field.type.base for each in types.values() for field in each.fields if not field.type.is_nested}
    assert bases <= STRUCT_CODES.keys() | STRINGS


def test_unknown_distributions() -> None:
    with pytest.raises(UnknownTypeError, match=r"'jazy' are not known \(did you mean 'jazzy'\?\)"):
        distribution_types("jazy")
    with pytest.raises(UnknownTypeError, match=r"known: .*humble, iron, jazzy"):
        distribution_types("empty")


def test_rosbags_is_imported_when_it_is_needed() -> None:
    program = "import sys, pyros1.ros2_types.distribution as tried; assert 'rosbags' not in sys.modules"
    program += "; assert 'std_msgs/msg/Bool' in tried.distribution_types()"
    subprocess.run([sys.executable, "-c", program], check=True, timeout=60)
