"""Reads the files that say which types and fields have other names in ROS 2, in the format of ros1_bridge
(https://github.com/ros2/ros1_bridge/blob/master/doc/index.rst).

A file is a list of rules. Each names a ROS 1 package and a ROS 2 package, optionally a message or service in each, and
optionally the matching fields::

    - ros1_package_name: my_msgs
      ros1_message_name: Pose2
      ros2_package_name: my_interfaces
      ros2_message_name: FlatPose
      fields_1_to_2:
        header.stamp: stamp
        pos: position
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from typing import Any

from pyros1.bridge.rules.file_reader import FileReader, Path, RulesError
from pyros1.ros2_types.mapping import PackageRule, TypeMapping, TypeRule

MAX_SIZE = 1 << 20
"""Maximum size of a file in bytes."""
_PACKAGES = ("ros1_package_name", "ros2_package_name")
_MESSAGES = ("ros1_message_name", "ros2_message_name")
_SERVICES = ("ros1_service_name", "ros2_service_name")
_FIELDS = "fields_1_to_2"
_SERVICE_FIELDS = ("request_fields_1_to_2", "response_fields_1_to_2")
_KEYS = (*_PACKAGES, *_MESSAGES, _FIELDS, *_SERVICES, *_SERVICE_FIELDS, "enable_foreign_mappings")
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
_PATH = re.compile(r"[A-Za-z][A-Za-z0-9_]*(\.[A-Za-z][A-Za-z0-9_]*)*\Z")


def read_mappings(paths: Iterable[str | os.PathLike[str]]) -> TypeMapping:
    """Return the rules in files.

    Raises:
        OSError: a file cannot be read.
        YamlError: a file is not YAML.
        RulesError: a rule is not valid, or two contradict each other; the error names file and line.
    """
    types: list[TypeRule] = []
    packages: list[PackageRule] = []
    for path in paths:
        with open(path, encoding="utf-8", errors="replace") as file:
            text = file.read(MAX_SIZE + 1)
        if len(text) > MAX_SIZE:
            raise RulesError(f"{path}: it is larger than {MAX_SIZE} bytes")
        for rule in _MappingFile(text, os.fspath(path)).rules():
            if isinstance(rule, TypeRule):
                _check_new(rule, types)
                types.append(rule)
            else:
                _check_new(rule, packages)
                packages.append(rule)
    return TypeMapping(types, packages)


def _check_new(rule: TypeRule | PackageRule, others: Iterable[TypeRule | PackageRule]) -> None:
    """Refuse a rule that duplicates or contradicts an earlier one."""
    for other in others:
        if (rule.ros1, rule.ros2) == (other.ros1, other.ros2):
            raise RulesError(
                f"{rule.place}: there is already a rule for {rule.ros1} and {rule.ros2}, in {other.place}: put both "
                "together"
            )
        kinds = [each.ros2.split("/")[1:2] for each in (rule, other)]
        if rule.ros1 == other.ros1 and kinds[0] == kinds[1] != []:
            raise RulesError(
                f"{rule.place}: {rule.ros1} is already {other.ros2} in ROS 2, see {other.place}; it cannot be both"
            )


class _MappingFile(FileReader):
    def rules(self) -> list[TypeRule | PackageRule]:
        """Return the rules in their order."""
        if self._value in ({}, []):
            return []
        if not isinstance(self._value, list):
            self._fail((), "a file of mapping rules is a list: begin each rule with - ros1_package_name: ...")
        return [self._rule(item, (number,)) for number, item in enumerate(self._value)]

    def _rule(self, value: Any, path: Path) -> TypeRule | PackageRule:
        rule = self._mapping(value, path, _KEYS)
        package1, package2 = (self._name(rule, key, path) for key in _PACKAGES)
        if not isinstance(rule.get("enable_foreign_mappings", False), bool):
            self._fail((*path, "enable_foreign_mappings"), "expected true or false")
        is_message, is_service = (any(key in rule for key in keys) for keys in (_MESSAGES, _SERVICES))
        if is_message and is_service:
            self._fail(path, "a rule is for a message or for a service: write two rules")
        if not is_message and _FIELDS in rule:
            self._fail((*path, _FIELDS), f"fields are those of a message: add {' and '.join(_MESSAGES)}")
        for key in _SERVICE_FIELDS:
            if not is_service and key in rule:
                self._fail((*path, key), f"these are fields of a service: add {' and '.join(_SERVICES)}")
        place = self._place(path)
        if is_message:
            name1, name2 = (self._name(rule, key, path) for key in _MESSAGES)
            fields = self._fields(rule, _FIELDS, path)
            return TypeRule(f"{package1}/{name1}", f"{package2}/msg/{name2}", fields, place=place)
        if is_service:
            name1, name2 = (self._name(rule, key, path) for key in _SERVICES)
            request, response = (self._fields(rule, key, path) for key in _SERVICE_FIELDS)
            return TypeRule(f"{package1}/{name1}", f"{package2}/srv/{name2}", request, response, place)
        return PackageRule(package1, package2, place)

    def _name(self, rule: Mapping[str, Any], key: str, path: Path) -> str:
        if key not in rule:
            self._fail(path, f"the rule needs {key}")
        name = self._text(rule[key], (*path, key))
        if not _NAME.match(name) or len(name) > 200:
            self._fail((*path, key), f"{name!r:.60} is not a name, such as std_msgs or String")
        return name

    def _fields(self, rule: Mapping[str, Any], key: str, path: Path) -> dict[str, str] | None:
        if rule.get(key) is None:
            return None
        fields = self._mapping(rule[key], (*path, key), None)
        used: dict[str, str] = {}
        for name, partner in fields.items():
            place = (*path, key, name)
            for each in (name, partner):
                if not isinstance(each, str) or not _PATH.match(each):
                    self._fail(place, f"{each!r:.60} is not a field, such as stamp or header.stamp")
            if partner in used:
                self._fail(place, f"{partner!r} is already matched with {used[partner]!r}; use each field only once")
            used[partner] = name
        return dict(fields)
