"""Calls that read, set and delete parameters."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from pyros1.values import load_yaml
from pyros1.web.models.params import editable_yaml, flatten
from pyros1.web.robot import Robot
from pyros1.web.server.wire import MAX_REQUEST_LENGTH, RequestError
from pyros1.web.views.view import string_arg


def tree(robot: Robot, args: Mapping[str, Any]) -> Any:
    """Return all parameters that pages may see, in one flat object: full name -> value."""
    value_by_name = {name: _to_json_types(value) for name, value in flatten(robot.parameters.get("/"))}
    return {name: value for name, value in sorted(value_by_name.items()) if name}


def get(robot: Robot, args: Mapping[str, Any]) -> str:
    """Return a parameter, or the visible part of a namespace, as YAML text. Args: name."""
    name = string_arg(args, "name")
    yaml = editable_yaml(robot.parameters.get(name))
    if len(yaml) > MAX_REQUEST_LENGTH:
        raise RequestError(f"{name} is too long to display: {len(yaml)} characters")
    return yaml


def put(robot: Robot, args: Mapping[str, Any]) -> None:
    """Set a parameter. Args: name, yaml (the value, as for `rosparam set`)."""
    name = string_arg(args, "name")
    robot.parameters.set(name, load_yaml(string_arg(args, "yaml")))


def delete(robot: Robot, args: Mapping[str, Any]) -> None:
    """Delete a parameter, or a whole namespace. Args: name."""
    name = string_arg(args, "name")
    robot.parameters.delete(name)


def _to_json_types(value: Any) -> Any:
    """Return a value that JSON can represent: values of other types, and numbers that are not finite, are strings."""
    if isinstance(value, dict):
        return {str(key): _to_json_types(child) for key, child in value.items()}
    if isinstance(value, (list, tuple)):
        return [_to_json_types(child) for child in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, (str, int, float, bool)) or value is None:
        return value
    return str(value)


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {"tree": tree, "get": get, "put": put, "delete": delete}
CHANGES = frozenset({"put", "delete"})
