"""Explains the rules of a user's mapping files, and why some cannot be used here."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pyros1.ground.errors import Error
from pyros1.ground.suggest import did_you_mean
from pyros1.msgs import load_message, load_service
from pyros1.ros2.pairs.differences import difference
from pyros1.ros2.pairs.type_pairs import TypePairs
from pyros1.ros2_types.mapping import TypeMapping, TypeRule


def check_mapping(mapping: TypeMapping, types: TypePairs) -> Iterator[tuple[str, bool]]:
    """Yield a line for each rule, and whether it can be used.

    A type that this machine does not have is no mistake: it becomes known once a node publishes it. But if other ROS 2
    types of its package are known, its name may be misspelt; the rule is used anyway, and the line suggests a name.

    Args:
        mapping: the rules.
        types: knows the types of both sides, with these rules.
    """
    for package in mapping.packages:
        yield f"{package.place}: {package.ros1} is {package.ros2} in ROS 2", True
    for rule in mapping.rules:
        try:
            loaded = load_service(rule.ros1) if _is_service(rule) else load_message(rule.ros1)
        except Error as error:
            yield f"{rule.place}: {rule.ros1} is {rule.ros2}, once a ROS 1 node publishes it; not yet: {error}", False
            continue
        try:
            differences = _differences(rule, loaded, types)
        except Error as error:
            reason = str(error).removeprefix(f"{rule.place}: ")
            yield f"{rule.place}: {rule.ros1} and {rule.ros2} are not exchanged: {reason}", False
            continue
        if not types.has_ros2_definition(rule.ros2) and (others := _known_types_in_package(rule, types)):
            folder, _, name = rule.ros2.rpartition("/")
            hint = did_you_mean(name, others)
            line = f"{rule.place}: {rule.ros1} is {rule.ros2}, with the ROS 1 fields"
            yield f"{line}, but ROS 2 has no known type {name} in {folder}{hint}", False
            continue
        known = (
            "" if types.has_ros2_definition(rule.ros2) else ", with the ROS 1 fields, since its definition is not here"
        )
        yield f"{rule.place}: {rule.ros1} is {rule.ros2}{known}", True
        for line in differences:
            yield f"    {line}", True


def _is_service(rule: TypeRule) -> bool:
    return rule.ros2.split("/")[1] == "srv"


def _known_types_in_package(rule: TypeRule, types: TypePairs) -> list[str]:
    """Return the names, without the package, of the known ROS 2 types of the rule's package."""
    folder = f"{rule.ros2.rpartition('/')[0]}/"
    return [name.removeprefix(folder) for name in types.known if name.startswith(folder)]


def _differences(rule: TypeRule, loaded: Any, types: TypePairs) -> list[str]:
    """Return what differs between two types.

    Raises:
        Error: they cannot be converted into each other.
    """
    if _is_service(rule):
        service = types.service_for_ros1(rule.ros1, loaded._md5sum)
        lines = [
            difference(f"{rule.ros1}Request", f"{rule.ros2}_Request", service.request),
            difference(f"{rule.ros1}Response", f"{rule.ros2}_Response", service.response),
        ]
    else:
        pair = types.for_ros1(rule.ros1, loaded._md5sum, loaded._full_text)
        lines = [difference(rule.ros1, rule.ros2, pair.transcoder)]
    return [line for line in lines if line]
