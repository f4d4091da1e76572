"""Finds turtles, and the nodes that simulate them, in what the master reports. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

TYPE = "turtlesim/Pose"


def simulators(topics: Mapping[str, str], publishers: Mapping[str, Iterable[str]]) -> dict[str, dict[str, str]]:
    """Return node -> turtle -> topic of its pose, all sorted.

    Args:
        topics: topic -> type.
        publishers: topic -> nodes.
    """
    found: dict[str, dict[str, str]] = {}
    for topic in sorted(topics):
        turtle, _, name = topic.rpartition("/")
        if topics[topic] == TYPE and name == "pose":
            for node in publishers.get(topic, ()):
                home = node.rpartition("/")[0] + "/"
                found.setdefault(node, {})[turtle.removeprefix(home)] = topic
    return dict(sorted(found.items()))


def drawing_of(node: str) -> str:
    """Return the topic with the drawing of a node's turtles."""
    return f"{node}/drawing"
