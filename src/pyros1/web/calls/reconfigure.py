"""Calls that change dynamic_reconfigure parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground.errors import MessageError
from pyros1.msgs.dynamic_reconfigure.msg import Config
from pyros1.msgs.dynamic_reconfigure.srv import Reconfigure
from pyros1.msgs.fill import fill_message
from pyros1.reconfigure.encoding import encode
from pyros1.reconfigure.values import TYPE_CONVERTERS
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.reconfigure import values
from pyros1.web.views.view import string_arg

_TIMEOUT = 5.0


def update(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Change parameters; return the node's new values. Args: node, values (name -> value), types (name -> type)."""
    new_values, types = args.get("values"), args.get("types")
    if not isinstance(new_values, dict) or not isinstance(types, dict) or "groups" in new_values:
        raise RequestError("values and types must be objects with the parameters' names as keys")
    if not all(types.get(name) in TYPE_CONVERTERS for name in new_values):
        raise RequestError(f"types must be among {', '.join(TYPE_CONVERTERS)}")
    try:
        config = encode(new_values, types)
    except (ValueError, TypeError, OverflowError) as error:
        raise RequestError(str(error)) from None
    return _send_config(robot, args, config)


def turn(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Turn groups of parameters on and off; return the node's new values.

    Args: node, groups (all groups, since C++ nodes need them; objects with name, state, id and parent).
    """
    config = Config()
    try:
        fill_message(config, {"groups": args.get("groups")})
    except MessageError as error:
        raise RequestError(f"groups: {error}") from None
    return _send_config(robot, args, config)


def _send_config(robot: Robot, args: Mapping[str, Any], config: Any) -> dict[str, Any]:
    name = f"{string_arg(args, 'node')}/set_parameters"
    robot.check_visible(name)
    with robot.node.service(name, Reconfigure) as client:
        return values(client.call(Reconfigure._request_class(config=config), _TIMEOUT).config)


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {"update": update, "turn": turn}
CHANGES = frozenset({"update", "turn"})
