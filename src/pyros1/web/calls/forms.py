"""Calls that convert a message between the fields of a form and YAML text."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.msgs import Message, load_service
from pyros1.msgs.json_form import from_json
from pyros1.values import load_yaml
from pyros1.web.models.forms import from_yaml, to_page_json, to_yaml
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.view import string_arg


def yaml(robot: Robot, args: Mapping[str, Any]) -> str:
    """Return a message as YAML text. Args: value."""
    value = args.get("value")
    if not isinstance(value, dict):
        raise RequestError("a message must be an object")
    return to_yaml(value)


def parse_yaml(robot: Robot, args: Mapping[str, Any]) -> Any:
    """Convert a message from YAML text to a form's value. Args: type, part ("request" for a service's type), yaml."""
    cls = _message_class(robot, args)
    message = from_yaml(cls, load_yaml(string_arg(args, "yaml")))
    from_json(cls, message, robot.node.now())  # raises an error if a value does not fit its field
    return to_page_json(message)


def _message_class(robot: Robot, args: Mapping[str, Any]) -> type[Message]:
    name = string_arg(args, "type")
    if args.get("part") == "request":
        request: type[Message] = load_service(name)._request_class
        return request
    return robot.types.find(name)


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {"yaml": yaml, "value": parse_yaml}
CHANGES: frozenset[str] = frozenset()
"""Empty: these calls only convert messages; other calls send them."""
