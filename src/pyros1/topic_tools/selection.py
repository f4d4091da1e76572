"""A list of topics, and services that select one of the topics or none: the common part of mux and demux.

The services are select, add, delete and list, relative to the name ``mux`` or ``demux``, which users can remap. The
selected topic is published on the latched topic ``selected``.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from pyros1.ground.errors import InvalidNameError, NodeError
from pyros1.node import Node
from pyros1.node.log.levels import WARN
from pyros1.node.publishing.publisher import Publisher

NO_TOPIC = "__none"
"""The name that selects no topic."""


class Selection:
    """The list of topics, and the services that select one of them and change the list.

    Args:
        node: the node that provides the services.
        tool_name: ``mux`` or ``demux``.
        topics: the topics. The first one is selected.
        initial: the topic to select instead of the first, or `NO_TOPIC`. An unknown topic is treated like `NO_TOPIC`.

    Attributes:
        topics: the full names of the topics.
        selected: the selected topic, or None.
        on_added, on_removed: called with a topic after it was added or deleted, while `lock` is held.
        on_changed: called after another topic was selected, while `lock` is held.
        lock: the lock that is held while the topics or the selection change.
    """

    def __init__(self, node: Node, tool_name: str, topics: Sequence[str], initial: str = "") -> None:
        self.topics = list(dict.fromkeys(map(node.resolve, topics)))
        self.selected: str | None = self.topics[0]
        self.on_added: Callable[[str], object] = _do_nothing
        self.on_removed: Callable[[str], object] = _do_nothing
        self.on_changed: Callable[[], object] = _do_nothing
        self.lock = threading.RLock()
        self._node = node
        self._tool_name = tool_name
        self._prefix = node.resolve(tool_name)
        published_name = self.selected
        if initial:
            self.selected = None if initial == NO_TOPIC else self._find_topic(initial)
            published_name = initial if self.selected else NO_TOPIC
        self._publisher: Publisher[Any] = node.advertise(
            f"{self._prefix}/selected", "std_msgs/String", queue_size=1, latch=True
        )
        self._publisher.publish(published_name)

    def serve(self) -> None:
        """Provide the services."""
        type_prefix = self._tool_name.capitalize()
        handlers = {"Select": self.select, "Add": self._add, "Delete": self._delete, "List": self._list}
        for verb, handler in handlers.items():
            self._node.advertise_service(f"{self._prefix}/{verb.lower()}", f"topic_tools/{type_prefix}{verb}", handler)

    def select(self, request: Any) -> Mapping[str, str]:
        """Select a topic or `NO_TOPIC`. Return the response, which names the topic that was selected before.

        Raises:
            NodeError: the topic is unknown.
        """
        with self.lock:
            previous = self.selected
            if request.topic == NO_TOPIC:
                self.selected = None
            else:
                self.selected = self._find_topic(request.topic) or self._refuse(
                    f"cannot select {request.topic}: unknown topic"
                )
            self._node.log.info("%s: %s is selected", self._tool_name, self.selected or "nothing")
            self.on_changed()
            self._publisher.publish(request.topic)
        return {"prev_topic": previous or ""}

    def _add(self, request: Any) -> Mapping[str, str]:
        with self.lock:
            if request.topic == NO_TOPIC:
                self._refuse(f"cannot add {NO_TOPIC}: this name stands for no topic")
            if self._find_topic(request.topic):
                self._refuse(f"cannot add {request.topic}: it is already in the list")
            topic = self._node.resolve(request.topic)
            self.topics.append(topic)
            self.on_added(topic)
            self._node.log.info("%s: added %s", self._tool_name, topic)
        return {}

    def _delete(self, request: Any) -> Mapping[str, str]:
        with self.lock:
            topic = self._find_topic(request.topic) or self._refuse(f"cannot delete {request.topic}: unknown topic")
            if topic == self.selected:
                self._refuse(f"cannot delete {topic}: it is selected")
            self.topics.remove(topic)
            self.on_removed(topic)
            self._node.log.info("%s: deleted %s", self._tool_name, topic)
        return {}

    def _list(self, request: Any) -> Mapping[str, list[str]]:
        return {"topics": list(self.topics)}

    def _find_topic(self, name: str) -> str | None:
        """Return the full name of a topic in the list; None if it is not in the list."""
        try:
            topic = self._node.resolve(name)
        except InvalidNameError as error:
            self._refuse(str(error))
        return topic if topic in self.topics else None

    def _refuse(self, reason: str) -> Any:
        """Log why a request is refused, and raise NodeError."""
        self._node.log.peer_event(WARN, "%s: %s", self._tool_name, reason)
        raise NodeError(reason)


def _do_nothing(*_: object) -> None:
    """Do nothing. This is the default callback."""
