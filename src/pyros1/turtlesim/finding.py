"""Finds turtles, and the nodes that simulate them, in the master's lists of topics and publishers (no I/O)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

_POSE_TYPE = "turtlesim/Pose"


def find_simulators(topics: Mapping[str, str], publishers: Mapping[str, Iterable[str]]) -> dict[str, dict[str, str]]:
    """Return the nodes that simulate turtles, sorted by name: node -> turtle -> topic with the turtle's pose.

    Args:
        topics: topic -> type.
        publishers: topic -> nodes that publish it.
    """
    simulators: dict[str, dict[str, str]] = {}
    for topic in sorted(topics):
        turtle, _, base_name = topic.rpartition("/")
        if topics[topic] == _POSE_TYPE and base_name == "pose":
            for node in publishers.get(topic, ()):
                namespace = node.rpartition("/")[0] + "/"
                simulators.setdefault(node, {})[turtle.removeprefix(namespace)] = topic
    return dict(sorted(simulators.items()))


def drawing_topic(node: str) -> str:
    """Return the topic on which a node publishes its turtles' drawing."""
    return f"{node}/drawing"
