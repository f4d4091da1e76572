"""rosapi's services that describe topics and find action servers."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pyros1.graph import Graph
from pyros1.ground.errors import MessageError
from pyros1.msgs import load_message
from pyros1.web.robot import Robot
from pyros1.web.rosbridge.rosapi import Services

_ACTION_TYPE_SUFFIXES = {"goal": "ActionGoal", "result": "ActionResult", "feedback": "ActionFeedback"}
"""Last part of the name of an action's topic -> suffix of the topic's type."""


def _types_by_topic(robot: Robot) -> dict[str, str]:
    """Return topic -> type for all topics with publishers or subscribers; an unknown type is empty."""
    state, types_by_topic = robot.graph.state(), robot.graph.topic_types()
    names = robot.access.visible_names(sorted({*state.publishers, *state.subscribers}))
    if not types_by_topic.keys() >= {*names}:  # some topics are new
        types_by_topic = Graph(robot.master).topic_types()
    return {name: types_by_topic.get(name, "").replace("*", "") for name in names}


def _topics(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    types_by_topic = _types_by_topic(robot)
    return {"topics": list(types_by_topic), "types": list(types_by_topic.values())}


def _topics_and_raw_types(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    types_by_topic = _types_by_topic(robot)
    definitions = {type_name: _definition(type_name) for type_name in set(types_by_topic.values())}
    return {
        "topics": list(types_by_topic),
        "types": list(types_by_topic.values()),
        "typedefs_full_text": [definitions[type_name] for type_name in types_by_topic.values()],
    }


def _definition(type_name: str) -> str:
    try:
        return load_message(type_name)._full_text if type_name else ""
    except MessageError:
        return ""  # not installed here


def _topics_for_type(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    return {
        "topics": [
            name for name, type_name in _types_by_topic(robot).items() if type_name and type_name == args["type"]
        ]
    }


def _topic_type(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    """Return a topic's type. For a field of a topic, such as ``/odom/pose``, return the type of the topic."""
    topic = args["topic"]
    robot.check_visible(topic)
    type_name = robot.type_of(topic)
    if type_name == "*":
        types_by_topic = {
            name: type_name
            for name, type_name in Graph(robot.master).topic_types().items()
            if topic.startswith(name + "/")
        }
        type_name = types_by_topic.get(max(robot.access.visible_names(types_by_topic), key=len, default=""), "")
    return {"type": type_name.replace("*", "")}


def _publishers(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    robot.check_visible(args["topic"])
    return {"publishers": robot.graph.state().publishers.get(args["topic"], [])}


def _subscribers(robot: Robot, args: Mapping[str, str]) -> dict[str, Any]:
    robot.check_visible(args["topic"])
    return {"subscribers": robot.graph.state().subscribers.get(args["topic"], [])}


def _action_servers(robot: Robot, _: Mapping[str, str]) -> dict[str, Any]:
    types_by_topic = _types_by_topic(robot)
    names = [name.removesuffix("/goal") for name in types_by_topic if name.endswith("/goal")]
    return {
        "action_servers": [
            name
            for name in names
            if all(
                types_by_topic.get(f"{name}/{last_part}", "").endswith(type_suffix)
                for last_part, type_suffix in _ACTION_TYPE_SUFFIXES.items()
            )
        ]
    }


SERVICES: Services = {
    "topics": ((), _topics),
    "topics_and_raw_types": ((), _topics_and_raw_types),
    "topics_for_type": (("type",), _topics_for_type),
    "topic_type": (("topic",), _topic_type),
    "publishers": (("topic",), _publishers),
    "subscribers": (("topic",), _subscribers),
    "action_servers": ((), _action_servers),
}
