"""Maps types and fields that have other names in ROS 2, by standard rules and a user's. No I/O."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping
from types import MappingProxyType
from typing import NamedTuple

from pyros1.ros2_types.log_levels import LOG_LEVELS, ValueRule

MOVED_MESSAGES: Mapping[str, str] = MappingProxyType(
    {"tf/tfMessage": "tf2_msgs/msg/TFMessage", "rosgraph_msgs/Log": "rcl_interfaces/msg/Log"}
)
"""ROS 1 message types that have another name in ROS 2; for bags, too."""
MOVED_SERVICES: Mapping[str, str] = MappingProxyType(
    {
        "roscpp_tutorials/TwoInts": "example_interfaces/srv/AddTwoInts",
        "rospy_tutorials/AddTwoInts": "example_interfaces/srv/AddTwoInts",
    }
)
"""The same for services."""
MOVED_TO_ROS1: Mapping[str, str] = MappingProxyType(
    {"rcl_interfaces/msg/Log": "rosgraph_msgs/Log", "example_interfaces/srv/AddTwoInts": "roscpp_tutorials/TwoInts"}
)
"""ROS 2 types that have another name in ROS 1. tf2_msgs/msg/TFMessage has not: it is there under both names."""

_NO_VALUES: Mapping[str, ValueRule] = MappingProxyType({})


class FieldRule(NamedTuple):
    """The matching fields of two types; other fields do not match, even if they have the same names.

    Attributes:
        fields: dotted path of a field in ROS 1, such as ``header.stamp`` -> the one in ROS 2.
        place: file and line of the rule, for error messages; empty if it is not from a file.
        values: path of a field in ROS 1 -> how its values are converted, if not as they are.
    """

    fields: Mapping[str, str]
    place: str = ""
    values: Mapping[str, ValueRule] = _NO_VALUES


FieldRules = Mapping[tuple[str, str], FieldRule]
"""Names of two types, ``package/Type`` in ROS 1 and ``package/msg/Type`` in ROS 2 -> their rule."""

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
    """Two types that belong together.

    Attributes:
        ros1: name in ROS 1, ``package/Type``.
        ros2: name in ROS 2, ``package/msg/Type`` or ``package/srv/Type``.
        fields: which fields belong together; None for those of the same names. For a service, those of its request.
        response_fields: for a service, those of its response.
        place: file and line of the rule.
    """

    ros1: str
    ros2: str
    fields: Mapping[str, str] | None = None
    response_fields: Mapping[str, str] | None = None
    place: str = ""


class PackageRule(NamedTuple):
    """Two packages whose types of the same names belong together; and where that is said."""

    ros1: str
    ros2: str
    place: str = ""


class TypeMapping:
    """The rules of a user, and the standard ones where the user's say nothing.

    Args:
        rules: types that belong together. If several have the same type of one side, the first one counts when the
            other side's name is wanted.
        packages: packages that belong together; `rules` take precedence. A package may be several of the other side: a
            type is then the first one that is known there.

    Attributes:
        rules, packages: as given.
        fields: which fields belong together.
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
        """Return the name of a type in ROS 2, by the rules, or the same name if there is no rule.

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
        """Return the name of a type in ROS 1; None if the rules say nothing about it.

        Args:
            name: its name in ROS 2, ``package/msg/Type``.
            is_known: returns whether ROS 1 is known to have a type; not called if there is only one that it can be.
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
    """Return what rules say about fields, with the standard rules for values of the same fields."""
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
