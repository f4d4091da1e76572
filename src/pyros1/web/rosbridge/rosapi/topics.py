"""rosapi's services about topics, including those of actions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.graph import Graph
from pyros1.ground.errors import MessageError
from pyros1.msgs import load_message
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.rosapi import Services

_ACTION = {"goal": "ActionGoal", "result": "ActionResult", "feedback": "ActionFeedback"}
"""Last parts of an action's topics, and the suffixes of their types."""


def _types(robot: Robot) -> dict[str, str]:
    """Return topic -> type for all topics with publishers or subscribers; the type is empty if unknown."""
    state, types = robot.graph.state(), robot.graph.topic_types()
    names = robot.access.visible(sorted({*state.publishers, *state.subscribers}))
    if not types.keys() >= {*names}:  # some topics are new
        types = Graph(robot.master).topic_types()
    return {name: types.get(name, "").replace("*", "") for name in names}


def _topics(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    types = _types(robot)
    return {"topics": list(types), "types": list(types.values())}


def _raw_types(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    types = _types(robot)
    definitions = {kind: _definition(kind) for kind in set(types.values())}
    return {
        "topics": list(types),
        "types": list(types.values()),
        "typedefs_full_text": [definitions[kind] for kind in types.values()],
    }


def _definition(kind: str) -> str:
    try:
        return load_message(kind)._full_text if kind else ""
    except MessageError:
        return ""  # not installed here


def _of_type(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    return {"topics": [name for name, kind in _types(robot).items() if kind and kind == args["type"]]}


def _type(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    """Return the type of a topic; for a field of a topic, such as ``/odom/pose``, the type of its topic."""
    topic = args["topic"]
    robot.check_visible(topic)
    kind = robot.type_of(topic)
    if kind == "*":
        types = {name: kind for name, kind in Graph(robot.master).topic_types().items() if topic.startswith(name + "/")}
        kind = types.get(max(robot.access.visible(types), key=len, default=""), "")
    return {"type": kind.replace("*", "")}


def _publishers(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    robot.check_visible(args["topic"])
    return {"publishers": robot.graph.state().publishers.get(args["topic"], [])}


def _subscribers(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    robot.check_visible(args["topic"])
    return {"subscribers": robot.graph.state().subscribers.get(args["topic"], [])}


def _action_servers(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    types = _types(robot)
    names = [name.removesuffix("/goal") for name in types if name.endswith("/goal")]
    return {
        "action_servers": [
            name
            for name in names
            if all(types.get(f"{name}/{end}", "").endswith(kind) for end, kind in _ACTION.items())
        ]
    }


SERVICES: Services = {
    "topics": ((), _topics),
    "topics_and_raw_types": ((), _raw_types),
    "topics_for_type": (("type",), _of_type),
    "topic_type": (("topic",), _type),
    "publishers": (("topic",), _publishers),
    "subscribers": (("topic",), _subscribers),
    "action_servers": ((), _action_servers),
}
