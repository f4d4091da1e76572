"""rosapi's services that read and change parameters, whose values are sent as JSON strings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.ground.errors import InvalidNameError, ParameterNotSetError
from pyros1.web.client_json import loads
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.frames import to_json
from pyros1.web.rosbridge.operations import BridgeError
from pyros1.web.rosbridge.rosapi import Services

_ROOT = "/"


def _name(robot: Robot, args: Mapping[str, str]) -> str:
    """Return a parameter's full name. As in stock ROS, the name need not be valid."""
    name = args["name"]
    try:
        return robot.node.resolve(name) if name != _ROOT else _ROOT
    except InvalidNameError:
        return "/" + name


def _get_param(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    try:
        value = robot.parameters.get(_name(robot, args))
    except ParameterNotSetError:
        return {"value": _default(args["default"])}
    try:
        return {"value": to_json(value)}
    except (TypeError, ValueError):
        return {"value": to_json(_to_json_types(value))}  # converts dates and bytes


def _default(default: str) -> str:
    """Return a default value as JSON; if it is not JSON, it is treated as a string."""
    try:
        return to_json(loads(default) if default else None)
    except ValueError:
        return to_json(default)


def _to_json_types(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(name): _to_json_types(child) for name, child in value.items()}
    if isinstance(value, (list, tuple)):
        return [_to_json_types(child) for child in value]
    return value if value is None or isinstance(value, (str, int, float)) else str(value)


def _set_param(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    _check_may_change(robot)
    try:
        value = loads(args["value"])
    except ValueError:
        raise BridgeError("the value must be JSON") from None
    name = _name(robot, args)
    if name == _ROOT:
        raise BridgeError("all parameters together cannot be set: send the name of a parameter or namespace")
    robot.parameters.set(name, value)
    return {}


def _delete_param(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    _check_may_change(robot)
    name = _name(robot, args)
    try:
        robot.parameters.delete(name)
    except ParameterNotSetError:
        if name == _ROOT:
            raise
    return {}


def _has_param(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    return {"exists": robot.parameters.has(_name(robot, args))}


def _search_param(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    full_name = (robot.master.search_param(args["name"]) if args["name"] else None) or ""
    return {"global_name": full_name if full_name and robot.parameters.has(full_name) else ""}


def _get_param_names(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    return {"names": robot.parameters.names()}


def _check_may_change(robot: Robot) -> None:
    if robot.access.read_only:
        raise BridgeError("this server is read-only (--read-only)")


SERVICES: Services = {
    "get_param": (("name", "default"), _get_param),
    "set_param": (("name", "value"), _set_param),
    "delete_param": (("name",), _delete_param),
    "has_param": (("name",), _has_param),
    "search_param": (("name",), _search_param),
    "get_param_names": ((), _get_param_names),
}
