"""Record what rosbridge_suite does with messages of clients, and with questions to rosapi.

`tests/web/rosbridge/test_suite.py` compares ours with it. Run by hand, with Debian's rospy, and with rosbridge_suite
(branch ros1) and its messages on PYTHONPATH::

    PYTHONPATH=... /usr/bin/python3 interop/web/record_rosbridge.py > tests/web/rosbridge/suite.json
"""

from __future__ import annotations

import io
import json
import random
from typing import Any

import genpy
import rospy
from rosapi import objectutils, params
from rosbridge_library.internal import message_conversion, ros_loader, services

NOW = (1_700_000_000, 250)
SEED = 28
TYPES = (
    "std_msgs/Header",
    "std_msgs/Time",
    "std_msgs/Duration",
    "std_msgs/UInt8MultiArray",
    "geometry_msgs/PoseStamped",
    "nav_msgs/Path",
    "nav_msgs/Odometry",
    "sensor_msgs/CompressedImage",
    "sensor_msgs/JointState",
    "sensor_msgs/PointCloud2",
    "stereo_msgs/DisparityImage",
    "tf2_msgs/TFMessage",
    "tf2_msgs/LookupTransformActionGoal",
    "trajectory_msgs/JointTrajectory",
    "visualization_msgs/MarkerArray",
    "visualization_msgs/InteractiveMarker",
    "diagnostic_msgs/DiagnosticArray",
    "actionlib_msgs/GoalStatusArray",
)
SERVICES = (
    "nav_msgs/GetPlan",
    "nav_msgs/SetMap",
    "sensor_msgs/SetCameraInfo",
    "std_srvs/SetBool",
    "std_srvs/Empty",
)
HEADERS: tuple[Any, ...] = (
    {},
    {"frame_id": "map"},
    {"seq": 3, "frame_id": ""},
    {"stamp": {}},
    {"stamp": {"secs": 5}},
    {"stamp": {"nsecs": 7}},
    {"stamp": {"secs": 0, "nsecs": 0}},
    {"stamp": {"secs": 5, "nsecs": 7}, "frame_id": "map"},
    {"stamp": {"sec": 5, "nanosec": 7}},
    {"stamp": "now"},
    {"stamp": "later"},
    {"stamp": None},
    {"stamp": 5},
    {"stamp": [5, 7]},
)
TIMES: tuple[Any, ...] = tuple(header["stamp"] for header in HEADERS if "stamp" in header)
PLAIN: dict[str, tuple[Any, ...]] = {
    "bool": (True, False),
    "string": ("", "map", "ä€", "now"),
    "float": (0, 1, -2.5, 1e300),
    "int": (0, 1, 5, 100),
}
BYTES: tuple[Any, ...] = ("", "YWJj", "YW Jj\n", "YWJjZA==", "YWJjZA", "?", [1, 2, 255], [])
OTHER_TYPES = ("std_msgs/Byte", "std_msgs/Empty", "rosgraph_msgs/Log", "time", "duration", "uint8", "string", "Header")
DEFAULTS = ("", "5", '"x"', "x", "{", "null", "[1,2]", "1.5", '{"a":1}', "'x'", "true", "  5 ", "ä", "1 2")


def value(chance: random.Random, kind: str, depth: int = 0) -> Any:  # noqa: PLR0911 - one kind, one line
    """Return a random value for a field, mostly one that fits."""
    base, bracket, length = kind.partition("[")
    if base in ("uint8", "char") and bracket:
        return chance.choice(BYTES)
    if bracket:
        count = int(length[:-1]) if length != "]" else chance.choice((0, 1, 2))
        return [value(chance, base, depth + 1) for _ in range(count)]
    if base in ("time", "duration"):
        return chance.choice(TIMES)
    if base in PLAIN:
        return chance.choice(PLAIN[base])
    if base.startswith(("int", "uint", "byte", "char")):
        return chance.choice(PLAIN["int"])
    if base.startswith("float"):
        return chance.choice(PLAIN["float"])
    if base == "std_msgs/Header":
        return dict(chance.choice(HEADERS))
    return fields(chance, ros_loader.get_message_instance(base), depth + 1)


def fields(chance: random.Random, instance: Any, depth: int = 0) -> dict[str, Any]:
    """Return random values for some fields of a message."""
    given = 0.8 if depth < 2 else 0.4
    return {
        name: value(chance, kind, depth)
        for name, kind in zip(instance.__slots__, instance._slot_types, strict=True)
        if chance.random() < given
    }


def result(instance: Any, given: Any, fill: Any) -> Any:
    """Return the message that a value becomes, as JSON; None if it is refused."""
    try:
        fill(given, instance)
        body = io.BytesIO()
        instance.serialize(body)
        return message_conversion.extract_values(type(instance)().deserialize(body.getvalue()))
    except Exception:  # noqa: BLE001 - it raises many kinds
        return None


def conversions() -> list[Any]:
    """Return [type, kind, value, message or None] for many values."""
    chance = random.Random(SEED)
    found: list[Any] = []

    def add(kind: str, given: Any, service: bool) -> None:
        make = ros_loader.get_service_request_instance if service else ros_loader.get_message_instance
        if service:
            message = result(
                make(kind), given, lambda each, instance: services.args_to_service_request_instance("", instance, each)
            )
        else:
            message = result(make(kind), given, message_conversion.populate_instance)
        found.append([kind, "service" if service else "message", given, message])

    for header in HEADERS:
        add("std_msgs/Header", header, False)
        add("geometry_msgs/PoseStamped", {"header": header}, False)
        add("nav_msgs/Path", {"poses": [{"header": header}, {}]}, False)
        add("tf2_msgs/LookupTransformActionGoal", {"goal_id": {"id": "a"}, "header": header, "goal": {}}, False)
        add("nav_msgs/GetPlan", {"start": {"header": header}}, True)
        add("nav_msgs/GetPlan", [{"header": header}], True)
    for time in TIMES:
        add("std_msgs/Time", {"data": time}, False)
        add("std_msgs/Duration", {"data": time}, False)
    for data in BYTES:
        add("sensor_msgs/CompressedImage", {"data": data}, False)
    for args in (None, [], {}, [True], [True, 2], "x", 5, True, {"data": True}):
        add("std_srvs/SetBool", args, True)
    for kind in TYPES:
        for _ in range(12):
            add(kind, fields(chance, ros_loader.get_message_instance(kind)), False)
    for kind in SERVICES:
        for _ in range(6):
            request = fields(chance, ros_loader.get_service_request_instance(kind))
            add(kind, chance.choice((request, list(request.values())[:1])), True)
    return found


def definitions() -> list[Any]:
    """Return [service of rosapi, type, typedefs or None] for many types."""
    asked = [("message_details", objectutils.get_typedef_recursive, kind) for kind in (*TYPES, *OTHER_TYPES)]
    for kind in (*SERVICES, "no_msgs/Type", ""):
        asked.append(("service_request_details", objectutils.get_service_request_typedef_recursive, kind))
        asked.append(("service_response_details", objectutils.get_service_response_typedef_recursive, kind))
    found: list[Any] = []
    for name, ask, kind in asked:
        try:
            found.append([name, kind, ask(kind)])
        except Exception:  # noqa: BLE001 - it raises many kinds
            found.append([name, kind, None])
    return found


def main() -> None:
    """Print the record."""
    rospy.get_rostime = lambda: genpy.Time(*NOW)
    rospy.get_param = lambda name, default: default
    message_conversion.binary_encoder = message_conversion.standard_b64encode
    message_conversion.bson_only_mode = False
    record = {
        "now": NOW,
        "conversions": conversions(),
        "definitions": definitions(),
        "defaults": [[default, params.get_param("unset", default, None)] for default in DEFAULTS],
    }
    parts = (f"{json.dumps(name)}: [\n{_lines(entries)}\n]" for name, entries in record.items())
    print("{" + ",\n".join(parts) + "}")


def _lines(entries: Any) -> str:
    return ",\n".join(json.dumps(entry) for entry in entries)


if __name__ == "__main__":
    main()
