"""Finds turtles, and the nodes that simulate them, in the state of the master (pure)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

_POSE_TYPE = "turtlesim/Pose"


def find_simulators(topics: Mapping[str, str], publishers: Mapping[str, Iterable[str]]) -> dict[str, dict[str, str]]:
    """Return the simulating nodes: node -> turtle -> topic of its pose, sorted.

    Args:
        topics: topic -> type.
        publishers: topic -> nodes.
    """
    found: dict[str, dict[str, str]] = {}
    for topic in sorted(topics):
        turtle, _, name = topic.rpartition("/")
        if topics[topic] == _POSE_TYPE and name == "pose":
            for node in publishers.get(topic, ()):
                namespace = node.rpartition("/")[0] + "/"
                found.setdefault(node, {})[turtle.removeprefix(namespace)] = topic
    return dict(sorted(found.items()))


def drawing_topic(node: str) -> str:
    """Return the topic with the drawing of a node's turtles."""
    return f"{node}/drawing"
