"""By hand: type hashes, definitions and encoded messages beside those of ROS 2 itself; see interop/ros2.md.

ROS 2 comes as wheels, for Linux on x86_64::

    python -m venv ros2
    ros2/bin/pip install ros-kilted-rclpy ros-kilted-rmw-fastrtps-cpp ros-kilted-common-interfaces ros-kilted-test-msgs
    ros2/bin/pip install -e .
    ros2/bin/python interop/ros2/compare_rclpy.py
"""

from __future__ import annotations

import importlib
import io
import json
import random
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from pairs import find_pairs, ros1_library

from pyros1.ground.errors import Error
from pyros1.msgs import from_definition
from pyros1.msgs.digest import split_full_text
from pyros1.msgs.spec import parse_message
from pyros1.ros2_types.counterparts import Counterparts
from pyros1.ros2_types.definitions import parse_types
from pyros1.ros2_types.distribution import distribution_types
from pyros1.ros2_types.model import FieldType, Length, MessageType
from pyros1.ros2_types.ros1_definitions import ros1_definition
from pyros1.ros2_types.transcoding.transcoder import Transcoder
from pyros1.ros2_types.type_hash import action_hash, service_hash, type_hash

SHARE = Path(sys.prefix) / "share"
MESSAGES = 20
CHARACTERS = "abcäö€"


def read_types() -> dict[str, MessageType]:
    """Return the types in all definitions of the wheels."""
    found: dict[str, MessageType] = {}
    for kind in ("msg", "srv", "action"):
        for path in sorted(SHARE.glob(f"*/{kind}/*.{kind}")):
            name = f"{path.parts[-3]}/{kind}/{path.stem}"
            found.update(parse_types(name, path.read_text(encoding="utf-8")))
    return found


def hashes() -> dict[str, str]:
    """Return the hashes that the wheels have, by the names of types."""
    found = {}
    for path in sorted(SHARE.glob("*/*/*.json")):
        for entry in json.loads(path.read_text(encoding="utf-8")).get("type_hashes", ()):
            found[entry["type_name"]] = entry["hash_string"]
    return found


def compare_hashes(types: dict[str, MessageType]) -> None:
    """Print how many hashes are equal."""
    computed: dict[str, Callable[[str, Any], str]] = {"msg": type_hash, "srv": service_hash, "action": action_hash}
    equal, different, unknown = 0, [], 0
    for name, expected in hashes().items():
        _, kind, short = name.split("/")
        is_whole = "_" not in short
        if is_whole and (kind != "msg") and f"{name}_{'Request' if kind == 'srv' else 'Goal'}" not in types:
            unknown += 1
            continue
        if (kind == "msg" or not is_whole) and name not in types:
            unknown += 1  # a part that is composed, of which the whole is compared, or without a text
            continue
        if (computed[kind] if is_whole else type_hash)(name, types) == expected:
            equal += 1
        else:
            different.append(name)
    print(f"hashes: {equal} equal, {len(different)} different {different}; {unknown} without a definition of their own")


class Values:
    """Random messages of rclpy's classes."""

    def __init__(self, types: dict[str, MessageType]) -> None:
        self._types = types
        self._random = random.Random(1)

    def message(self, name: str) -> Any:
        """Return a message of a type."""
        package, kind, short = name.split("/")
        message = getattr(importlib.import_module(f"{package}.{kind}"), short)()
        for field in self._types[name].fields:
            setattr(message, field.name, self._value(field.type))
        return message

    def _value(self, type: FieldType) -> Any:
        if type.length is Length.SINGLE:
            return self._element(type)
        limit = min(type.size or 4, 4)
        count = type.size if type.length is Length.FIXED else self._random.randrange(limit + 1)
        return [self._element(type) for _ in range(count)]

    def _element(self, type: FieldType) -> Any:
        draw = self._random
        if type.base in ("string", "wstring"):
            text = "".join(draw.choices(CHARACTERS, k=draw.randrange(8)))
            return text[: type.string_bound // 3] if type.string_bound else text
        if type.is_nested:
            return self.message(type.base)
        if type.base in ("float32", "float64"):
            return float(draw.randrange(1000))
        return {"bool": draw.random() < 0.5, "byte": bytes([draw.randrange(256)])}.get(type.base, draw.randrange(100))


def message_types(types: dict[str, MessageType]) -> Iterator[str]:
    """Yield the names of the message types that rclpy has."""
    for name in sorted(types):
        package, kind, short = name.split("/")
        try:
            module = importlib.import_module(f"{package}.{kind}")
        except ImportError:
            continue
        if kind == "msg" and hasattr(module, short):
            yield name


def compare_messages(types: dict[str, MessageType]) -> None:
    """Print how many messages of rclpy are the same after a way through ROS 1's encoding."""
    from rclpy.serialization import deserialize_message, serialize_message  # type: ignore[import-not-found]

    values, counterparts = Values(types), Counterparts(distribution_types())
    equal, different, refused = 0, [], []
    for name in message_types(types):
        ros1 = counterparts.to_ros1(name)
        try:
            text = ros1_definition(name, types, counterparts.to_ros1, lambda _: None)
            specs = {each: parse_message(each, part) for each, part in split_full_text(ros1, text).items()}
            transcoder = Transcoder(ros1, specs, name, types, {})
        except Error as error:
            refused.append(f"{name}: {error}")
            continue
        for _ in range(MESSAGES):
            message = values.message(name)
            body = transcoder.from_cdr(serialize_message(message))
            back = deserialize_message(transcoder.to_cdr(body), type(message))
            if repr(back) == repr(message):
                equal += 1
            else:
                different.append(name)
    print(f"messages: {equal} equal, {len(different)} different {sorted({*different})}; refused types: {refused}")


def is_same(ros1: Any, ros2: Any) -> bool:
    """Return whether a value of ROS 1 is one of ROS 2, in the fields that both have."""
    if hasattr(ros1, "secs"):
        return bool((ros1.secs, ros1.nsecs) == (ros2.sec, ros2.nanosec))
    if hasattr(ros1, "__slots__") and hasattr(ros2, "get_fields_and_field_types"):
        fields = ros2.get_fields_and_field_types()
        pairs = [(name, name if name in fields else name.lower()) for name in ros1.__slots__]
        return all(is_same(getattr(ros1, name), getattr(ros2, other)) for name, other in pairs if other in fields)
    if isinstance(ros2, bytes) and isinstance(ros1, int):
        return ros1 & 0xFF == ros2[0]
    if isinstance(ros1, (str, int, float)):
        return bool(ros1 == ros2)
    values1, values2 = list(ros1), list(ros2)
    return len(values1) == len(values2) and all(map(is_same, values1, values2))


def compare_pairs(types: dict[str, MessageType]) -> None:
    """Print how many messages of types that ROS 1 has, too, have the same values on both sides, each decoded by its own
    codec; also those that differ in their fields.
    """
    from rclpy.serialization import deserialize_message, serialize_message

    values, names, library = Values(types), {*message_types(types)}, ros1_library()
    equal, wrong, differing, refused = 0, [], 0, []
    for pair in find_pairs(types):
        if pair.ros2 not in names:
            continue
        if pair.transcoder is None:
            refused.append(pair.problem)
            continue
        differing += bool(pair.difference())
        text = library.digests.full_text(library.message(pair.ros1))
        message_class: Any = from_definition(pair.ros1, text)
        for _ in range(MESSAGES):
            message = values.message(pair.ros2)
            if pair.ros1 == "rosgraph_msgs/Log":
                message.level = 30
            ros1 = message_class().deserialize(pair.transcoder.from_cdr(serialize_message(message)))
            back = deserialize_message(pair.transcoder.to_cdr(encode(ros1)), type(message))
            if pair.ros1 == "rosgraph_msgs/Log":
                is_right = (ros1.level, back.level, ros1.header.stamp.secs) == (4, 30, message.stamp.sec)
                ros1.level = 30
            else:
                is_right = True
            if is_right and is_same(ros1, message) and is_same(ros1, back):
                equal += 1
            else:
                wrong.append(pair.ros2)
    print(
        f"types of both: {equal} messages equal, {len(wrong)} different {sorted({*wrong})}; {differing} types with "
        f"other fields; refused types: {refused}"
    )


def encode(message: Any) -> bytes:
    """Return a ROS 1 message as bytes."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return buffer.getvalue()


if __name__ == "__main__":
    all_types = read_types()
    compare_hashes(all_types)
    compare_messages(all_types)
    compare_pairs(all_types)
