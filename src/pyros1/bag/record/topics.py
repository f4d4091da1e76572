"""Finds the topics to record, as they appear."""

from __future__ import annotations

import contextlib

from pyros1.bag.record.topic_selection import TopicSelection
from pyros1.graph import Graph
from pyros1.ground.errors import Error
from pyros1.node import Node


class TopicSearch:
    """Searches the master for topics to record.

    Topic names are returned as requested, or as the master lists them; remappings apply only on subscription, as in
    stock ROS.

    Args:
        node: the recorder's node.
        selection: what to record.
    """

    def __init__(self, node: Node, selection: TopicSelection) -> None:
        self._node = node
        self._graph = Graph(node.master)
        self._selection = selection
        self._returned_topics: set[str] = set()
        self._watched_node = node.resolve(selection.node) if selection.node else ""
        self._unreturned_topics = [node.resolve(name, remap=False) for name in selection.fixed_topics()]

    def new_topics(self) -> list[str]:
        """Return the topics to record that have not been returned yet."""
        names, self._unreturned_topics = self._unreturned_topics, []
        if self._selection.needs_polling:
            with contextlib.suppress(Error):  # the master does not respond, but may come back
                names += self._find_selected()
        new_names = [name for name in dict.fromkeys(names) if name not in self._returned_topics]
        self._returned_topics.update(new_names)
        return new_names

    def _find_selected(self) -> list[str]:
        node_topics: list[str] = []
        if self._watched_node:
            subscribers = self._graph.state().subscribers
            node_topics = [topic for topic, nodes in subscribers.items() if self._watched_node in nodes]
        published = [topic for topic, _ in self._node.master.get_published_topics()]
        return [
            topic for topic in dict.fromkeys(published + node_topics) if self._selection.selects(topic, node_topics)
        ]
