"""Reads a node's robot description, and its other parameters."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

from pyros1.urdf.model import UrdfError

if TYPE_CHECKING:
    from pyros1.node import Node

PARAMETER = "robot_description"


def robot_description(node: Node) -> str:
    """Return the parameter robot_description of the node itself, of its namespace, or of one above.

    Raises:
        UrdfError: it is not set, or is not a string.
    """
    name = node.params.search(PARAMETER)
    value = None if name is None else node.params.get(name)
    if value is None:
        raise UrdfError(
            f'Could not find parameter {PARAMETER} on parameter server: a launch file sets it with <param name="'
            f'{PARAMETER}" textfile="ROBOT.urdf"/>, or command="xacro ROBOT.xacro"'
        )
    if not isinstance(value, str):
        raise UrdfError(f"the parameter {name} must be a string with the robot's description")
    return value


def parameter_getter(node: Node) -> Any:
    """Return a function that takes a parameter's name and default, and looks it up in the node and its namespace."""

    def get(name: str, default: Any) -> Any:
        value = node.params.get(f"~{name}")
        return node.params.get(name, default) if value is None else value

    return get


def number(value: object, name: str) -> float:
    """Return a parameter's value as a number.

    Raises:
        UrdfError: it is not a number.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise UrdfError(f"the parameter {name} must be a number")
    return float(value)
