"""Finds the topics to record, as they appear."""

from __future__ import annotations

import contextlib

from pyros1.bag.record.names import Selection
from pyros1.graph import Graph
from pyros1.ground.errors import Error
from pyros1.node import Node


class TopicSearch:
    """Search of the master for topics to record.

    Topics have the requested names, or those from the master; remappings apply at subscription, as in stock.

    Args:
        node: the recorder's node.
        selection: what to record.
    """

    def __init__(self, node: Node, selection: Selection) -> None:
        self._node = node
        self._graph = Graph(node.master)
        self._selection = selection
        self._known: set[str] = set()
        self._watched = node.resolve(selection.node) if selection.node else ""
        self._waiting = [node.resolve(name, remap=False) for name in selection.named()]

    def new_topics(self) -> list[str]:
        """Return the topics to record that were not returned before."""
        found, self._waiting = self._waiting, []
        if self._selection.polling:
            with contextlib.suppress(Error):  # the master does not answer; it may come back
                found += self._published()
        new = [name for name in dict.fromkeys(found) if name not in self._known]
        self._known.update(new)
        return new

    def _published(self) -> list[str]:
        of_node: list[str] = []
        if self._watched:
            subscribers = self._graph.state().subscribers
            of_node = [topic for topic, nodes in subscribers.items() if self._watched in nodes]
        published = [topic for topic, _ in self._node.master.get_published_topics()]
        return [topic for topic in dict.fromkeys(published + of_node) if self._selection.wants(topic, of_node)]
