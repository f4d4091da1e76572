"""Reads the robot description and other parameters of the nodes that publish a robot's state."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, Any

from pyros1.urdf.model import UrdfError

if TYPE_CHECKING:
    from pyros1.node import Node

DESCRIPTION_PARAMETER = "robot_description"


def robot_description(node: Node) -> str:
    """Return the robot description: the value of the nearest parameter robot_description.

    The parameter is searched for in the node itself, then in its namespace, and then in the namespaces above.

    Raises:
        UrdfError: the parameter is not set, or is not a string.
    """
    name = node.params.search(DESCRIPTION_PARAMETER)
    value = None if name is None else node.params.get(name)
    if value is None:
        raise UrdfError(
            f"Could not find parameter {DESCRIPTION_PARAMETER} on parameter server: a launch file sets it with <param "
            f'name="{DESCRIPTION_PARAMETER}" textfile="ROBOT.urdf"/>, or command="xacro ROBOT.xacro"'
        )
    if not isinstance(value, str):
        raise UrdfError(f"the parameter {name} must be a string with the robot's description")
    return value


def make_parameter_getter(node: Node) -> Any:
    """Return a function that takes a parameter's name and default, and returns the parameter's value.

    The function looks in the node itself, then in its namespace; if the parameter is not set, it returns the default.
    """

    def get(name: str, default: Any) -> Any:
        value = node.params.get(f"~{name}")
        return node.params.get(name, default) if value is None else value

    return get


def check_number(value: object, name: str) -> float:
    """Return a parameter's value as a float.

    Raises:
        UrdfError: the value is not a finite number.
    """
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not isfinite(value):
        raise UrdfError(f"the parameter {name} must be a number")
    return float(value)
