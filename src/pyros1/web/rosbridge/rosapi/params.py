"""Parameters. Their values go as JSON texts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.ground.errors import ParameterNotSetError
from pyros1.web.json_texts import loads
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.frames import text
from pyros1.web.rosbridge.operations import BridgeError
from pyros1.web.rosbridge.rosapi import Services


def _name(robot: Robot, args: Mapping[str, str]) -> str:
    return robot.node.resolve(args["name"]) if args["name"] != "/" else "/"


def _get(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    try:
        value = robot.parameters.get(_name(robot, args))
    except ParameterNotSetError:
        return {"value": args["default"] or "null"}
    try:
        return {"value": text(value)}
    except (TypeError, ValueError):
        return {"value": text(_plain(value))}  # dates and bytes


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {str(name): _plain(inner) for name, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(inner) for inner in value]
    return value if value is None or isinstance(value, (str, int, float)) else str(value)


def _set(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    _check_may_change(robot)
    try:
        value = loads(args["value"])
    except ValueError:
        raise BridgeError("the value must be JSON") from None
    robot.parameters.set(_name(robot, args), value)
    return {}


def _delete(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    _check_may_change(robot)
    robot.parameters.delete(_name(robot, args))
    return {}


def _has(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    return {"exists": robot.parameters.has(_name(robot, args))}


def _search(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    found = robot.master.search_param(args["name"]) or ""
    return {"global_name": found if found and robot.parameters.has(found) else ""}


def _names(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    return {"names": robot.parameters.names()}


def _check_may_change(robot: Robot) -> None:
    if robot.access.read_only:
        raise BridgeError("this server is read-only (--read-only)")


SERVICES: Services = {
    "get_param": (("name", "default"), _get),
    "set_param": (("name", "value"), _set),
    "delete_param": (("name",), _delete),
    "has_param": (("name",), _has),
    "search_param": (("name",), _search),
    "get_param_names": ((), _names),
}
