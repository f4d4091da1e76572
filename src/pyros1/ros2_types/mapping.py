"""Maps types and fields that have different names in ROS 2, by standard and user-defined rules. No I/O."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from pyros1.ros2_types.log_levels import LOG_LEVELS, ValueRule

MOVED_MESSAGES: Mapping[str, str] = MappingProxyType(
    {"tf/tfMessage": "tf2_msgs/msg/TFMessage", "rosgraph_msgs/Log": "rcl_interfaces/msg/Log"}
)
"""ROS 1 message types that have another name in ROS 2; also used for bags."""
MOVED_SERVICES: Mapping[str, str] = MappingProxyType(
    {
        "roscpp_tutorials/TwoInts": "example_interfaces/srv/AddTwoInts",
        "rospy_tutorials/AddTwoInts": "example_interfaces/srv/AddTwoInts",
    }
)
"""ROS 1 service types that have another name in ROS 2."""
MOVED_TO_ROS1: Mapping[str, str] = MappingProxyType(
    {"rcl_interfaces/msg/Log": "rosgraph_msgs/Log", "example_interfaces/srv/AddTwoInts": "roscpp_tutorials/TwoInts"}
)
"""ROS 2 types that have another name in ROS 1. Not tf2_msgs/msg/TFMessage: ROS 1 has it under both names."""

_NO_VALUES: Mapping[str, ValueRule] = MappingProxyType({})


class FieldRule(NamedTuple):
    """The matching fields of two types; other fields do not match, even if they have the same names.

    Attributes:
        fields: dotted path of a field in ROS 1, such as ``header.stamp`` -> its path in ROS 2.
        place: file and line of the rule, for error messages; empty if it is not from a file.
        values: path of a field in ROS 1 -> how its values are converted; others are kept.
    """

    fields: Mapping[str, str]
    place: str = ""
    values: Mapping[str, ValueRule] = _NO_VALUES


FieldRules = Mapping[tuple[str, str], FieldRule]
"""(``package/Type`` in ROS 1, ``package/msg/Type`` in ROS 2) -> their rule."""

STANDARD_FIELDS: FieldRules = MappingProxyType(
    {
        ("rosgraph_msgs/Log", "rcl_interfaces/msg/Log"): FieldRule(
            MappingProxyType(
                {
                    "header.stamp": "stamp",
                    "level": "level",
                    "name": "name",
                    "msg": "msg",
                    "file": "file",
                    "function": "function",
                    "line": "line",
                }
            ),
            values=MappingProxyType({"level": LOG_LEVELS}),
        )
    }
)
"""The rules for standard types."""


class TypeRule(NamedTuple):
    """Maps one type to another.

    Attributes:
        ros1: name in ROS 1, ``package/Type``.
        ros2: name in ROS 2, ``package/msg/Type`` or ``package/srv/Type``.
        fields: the matching fields; None to match by name. For a service, those of its request.
        response_fields: for a service, the matching fields of its response.
        place: file and line of the rule.
    """

    ros1: str
    ros2: str
    fields: Mapping[str, str] | None = None
    response_fields: Mapping[str, str] | None = None
    place: str = ""


class PackageRule(NamedTuple):
    """Maps a package to another: their types with the same name match. `place` is the rule's file and line."""

    ros1: str
    ros2: str
    place: str = ""


class TypeMapping:
    """A user's rules, and the standard rules for the types that those do not cover.

    Args:
        rules: matching types. If several rules are for the same type, the first one gives its name on the other side.
        packages: matching packages; `rules` take precedence. A package may match several on the other side: each of its
            types is then looked up in all of them, in order.

    Attributes:
        rules, packages: as given.
        fields: the matching fields.
    """

    def __init__(self, rules: Iterable[TypeRule] = (), packages: Iterable[PackageRule] = ()) -> None:
        self.rules = tuple(rules)
        self.packages = tuple(packages)
        self._to_ros2: dict[tuple[str, str], str] = {}
        self._to_ros1: dict[str, str] = {}
        for rule in self.rules:
            folder = rule.ros2.split("/")[1]
            self._to_ros2.setdefault((folder, rule.ros1), rule.ros2)
            self._to_ros1.setdefault(rule.ros2, rule.ros1)
        self._packages_to_ros2: dict[str, list[str]] = {}
        self._packages_to_ros1: dict[str, list[str]] = {}
        for package in self.packages:
            self._packages_to_ros2.setdefault(package.ros1, []).append(package.ros2)
            self._packages_to_ros1.setdefault(package.ros2, []).append(package.ros1)
        self.fields: FieldRules = {**STANDARD_FIELDS, **_field_rules(self.rules)}

    def to_ros2(self, name: str, folder: str, known: Container[str] = ()) -> str:
        """Return the name of a type in ROS 2 according to the rules; the same name if there is no rule.

        Args:
            name: its name in ROS 1, ``package/Type``.
            folder: ``msg``, ``srv`` or ``action``.
            known: the types that ROS 2 is known to have, and the parts of services and actions.
        """
        found = self._to_ros2.get((folder, name))
        if found is not None:
            return found
        package, _, short = name.partition("/")
        candidates = [f"{each}/{folder}/{short}" for each in self._packages_to_ros2.get(package, ())]
        if candidates:
            part = {"srv": "_Request", "action": "_Goal"}.get(folder, "")
            return next((each for each in candidates if each + part in known), candidates[0])
        standard = {"msg": MOVED_MESSAGES, "srv": MOVED_SERVICES}.get(folder, {})
        return standard.get(name, f"{package}/{folder}/{short}")

    def to_ros1(self, name: str, is_known: Callable[[str], bool] = bool) -> str | None:
        """Return the name of a type in ROS 1 according to the rules; None if there is no rule.

        Args:
            name: its name in ROS 2, ``package/msg/Type``.
            is_known: returns whether ROS 1 is known to have a type; not called if there is only one candidate.
        """
        found = self._to_ros1.get(name)
        if found is not None:
            return found
        package, _, short = name.split("/")
        candidates = [f"{each}/{short}" for each in self._packages_to_ros1.get(package, ())]
        if len(candidates) > 1:
            return next((each for each in candidates if is_known(each)), candidates[0])
        if candidates:
            return candidates[0]
        return MOVED_TO_ROS1.get(name)


def _field_rules(rules: Iterable[TypeRule]) -> dict[tuple[str, str], FieldRule]:
    """Return the field rules of type rules. Fields that match as in a standard rule get its value conversions."""
    found: dict[tuple[str, str], FieldRule] = {}
    for rule in rules:
        if rule.ros2.split("/")[1] == "msg":
            parts = [("", "", rule.fields)]
        else:
            parts = [("Request", "_Request", rule.fields), ("Response", "_Response", rule.response_fields)]
        for suffix1, suffix2, fields in parts:
            if fields is not None:
                names = rule.ros1 + suffix1, rule.ros2 + suffix2
                standard = STANDARD_FIELDS.get(names)
                values = {
                    path: value
                    for path, value in (standard.values if standard else _NO_VALUES).items()
                    if standard is not None and fields.get(path) == standard.fields[path]
                }
                found.setdefault(names, FieldRule(fields, rule.place, values))
    return found
