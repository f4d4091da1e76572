"""Definitions as the page's forms need them."""

from __future__ import annotations

import math
from typing import Any

import pytest

from pyros1.ground.errors import MessageError
from pyros1.msgs import from_definition, load_message
from pyros1.msgs.geometry_msgs.msg import PoseStamped
from pyros1.msgs.json_form import from_json, to_json
from pyros1.msgs.sensor_msgs.msg import BatteryState, LaserScan
from pyros1.values import load_yaml
from pyros1.web.models.forms import choices, form, from_yaml, numeric_paths, to_yaml


def test_a_form_has_fields_and_defaults() -> None:
    found = form(PoseStamped)
    assert found["type"] == "geometry_msgs/PoseStamped" and "Quaternion orientation" in found["text"]
    header, pose = found["fields"]
    assert header[:2] == ["header", "std_msgs/Header"]
    assert [each[0] for each in pose[2][0][2]] == ["x", "y", "z"]
    assert found["default"]["pose"]["orientation"]["w"] == 1.0  # no rotation


@pytest.mark.parametrize(
    ("kind", "field", "words"),
    [
        ("diagnostic_msgs/DiagnosticStatus", "level", ["OK", "WARN", "ERROR", "STALE"]),
        ("actionlib_msgs/GoalStatus", "status", ["PENDING", "ACTIVE"]),
        ("sensor_msgs/PointField", "datatype", ["INT8", "UINT8"]),
        ("visualization_msgs/Marker", "type", ["ARROW", "CUBE"]),
        ("visualization_msgs/Marker", "action", ["ADD", "MODIFY", "DELETE", "DELETEALL"]),
    ],
)
def test_constants_are_offered_where_they_fit(kind: str, field: str, words: list[str]) -> None:
    found = choices(load_message(kind))
    assert [name for name, _ in found[field]][: len(words)] == words
    assert not {"id", "text"} & found.keys() and ("DELETE" in words) == (found[field][-1][0] == "DELETEALL")


def test_constants_with_a_fields_name_belong_to_it() -> None:
    found = choices(BatteryState)
    assert found["power_supply_status"][1] == ["POWER_SUPPLY_STATUS_CHARGING", 1]
    assert all(name.startswith("POWER_SUPPLY_HEALTH_") for name, _ in found["power_supply_health"])
    assert "voltage" not in found
    assert choices(PoseStamped) == {}
    odd = from_definition("p/Odd", "float32 x\nfloat32 X_NO=inf\nuint64 mask\nuint64 MASK_ALL=18446744073709551615\n")
    assert choices(odd) == {"x": [["X_NO", "Infinity"]], "mask": [["MASK_ALL", str(2**64 - 1)]]}


def test_numbers_of_a_message() -> None:
    assert "/scan/ranges[0]" in list(numeric_paths(LaserScan, "/scan"))


def test_yaml_and_form_say_the_same() -> None:
    pose = to_json(PoseStamped())
    pose["header"]["stamp"] = "now"
    pose["pose"]["position"]["x"] = 1.5
    text = to_yaml(pose)
    assert text.splitlines()[:3] == ["header:", "  seq: 0", "  stamp: now"]
    assert from_yaml(PoseStamped, load_yaml(text)) == pose


def test_yaml_may_leave_fields_out() -> None:
    assert from_yaml(PoseStamped, None) == to_json(PoseStamped())
    found = from_yaml(PoseStamped, load_yaml("pose: {position: {y: 2}}"))
    assert found["pose"] == {"position": {"x": 0.0, "y": 2, "z": 0.0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 0}}
    scan = from_yaml(LaserScan, load_yaml("ranges: [1, .nan, .inf, -.inf]"))
    assert scan["ranges"] == [1, "NaN", "Infinity", "-Infinity"]
    message: Any = from_json(LaserScan, scan)
    assert math.isnan(message.ranges[1])


@pytest.mark.parametrize("text", ["x: 1", "5", "[1, 2]", "pose: {position: {a: 1}}"])
def test_yaml_that_is_no_such_message(text: str) -> None:
    with pytest.raises(MessageError):
        from_yaml(PoseStamped, load_yaml(text))
