"""Calls that publish messages, and complete the names of types and fields."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from pyros1.ground import msgs_imports
from pyros1.ground.errors import MessageError
from pyros1.msgs import load_message
from pyros1.web.models.forms import form as form_of
from pyros1.web.models.forms import numeric_paths
from pyros1.web.robot import Robot
from pyros1.web.server.wire import RequestError
from pyros1.web.views.view import string_arg

_MAX_COMPLETIONS = 200


def form(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Return the form for a message type; see `pyros1.web.models.forms.form`. Args: type, or a topic that has it."""
    name = args.get("type")
    if isinstance(name, str):
        return form_of(robot.types.find(name))
    topic = string_arg(args, "topic")
    robot.check_visible(topic)
    name = robot.type_of(topic)
    if name == "*":
        raise RequestError(f"the type of {topic} is unknown")
    return form_of(robot.types.find_on(topic, name))


def publish(robot: Robot, args: Mapping[str, Any]) -> dict[str, Any]:
    """Publish a message; return the number of subscribers. Args: topic, type, value, latch."""
    topic = string_arg(args, "topic")
    robot.check_visible(topic)
    subscribers = robot.publishers.publish(topic, string_arg(args, "type"), args.get("value"), bool(args.get("latch")))
    return {"subscribers": subscribers}


def advertise(robot: Robot, args: Mapping[str, Any]) -> None:
    """Prepare to publish, so that no subscriber misses the first message. Args: topic, type."""
    topic = string_arg(args, "topic")
    robot.check_visible(topic)
    robot.publishers.advertise(topic, string_arg(args, "type"))


def types(robot: Robot, args: Mapping[str, Any]) -> list[str]:
    """Return completions for a text field that takes a message type: names of installed types. Args: begin (the text).

    If the text contains no slash, the names of packages that define messages are returned, each followed by a slash.
    """
    begin = string_arg(args, "begin", "")
    package, slash, _ = begin.partition("/")
    if not slash:
        names = [f"{package_name}/" for package_name in robot.types.packages()]
    else:
        names = [
            f"{package}/{full_name.rpartition('/')[2]}" for full_name in msgs_imports.finder().library.messages(package)
        ]
    return sorted(name for name in names if name.startswith(begin))[:_MAX_COMPLETIONS]


def fields(robot: Robot, args: Mapping[str, Any]) -> list[str]:
    """Return completions for a text field that takes the path of a numeric field in a topic. Args: begin (the text)."""
    begin = string_arg(args, "begin", "")
    paths: list[str] = []
    for topic, type_name in sorted(robot.graph.topic_types().items()):
        if not robot.access.may_see(topic) or not (topic.startswith(begin) or begin.startswith(topic)):
            continue
        try:
            paths += [path for path in numeric_paths(load_message(type_name), topic) if path.startswith(begin)]
        except MessageError:
            continue  # a type that is not installed, or no type at all
        if len(paths) >= _MAX_COMPLETIONS:
            break
    return paths[:_MAX_COMPLETIONS]


CALLS: dict[str, Callable[[Robot, Mapping[str, Any]], Any]] = {
    "form": form,
    "publish": publish,
    "advertise": advertise,
    "types": types,
    "fields": fields,
}
CHANGES = frozenset({"publish", "advertise"})
