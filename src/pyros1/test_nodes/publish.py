"""publishtest checks that messages arrive on topics, or that none do."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from pyros1.ground.timing import Duration
from pyros1.msgs import AnyMsg
from pyros1.test_nodes.check import STEP, SetupError, Test, await_clock, entries, pause, require

if TYPE_CHECKING:
    from pyros1.node import Node


def tests(node: Node) -> dict[str, Test]:
    """Return the test cases of publishtest, by name.

    Args:
        node: with the parameter ~topics: ``[{name: TOPIC, timeout: SECONDS, negative: BOOL}, ...]``.

    Raises:
        SetupError: the parameter names no topic.
    """
    topics = entries(node, "topics", {"timeout": 10, "negative": False})
    if not topics:
        raise SetupError(f"{node.resolve('~topics')} names no topic to test")
    return {"test_publish": lambda: _test_publish(node, topics)}


class _TopicCheck:
    """A topic that is checked until its timeout, in the node's time."""

    def __init__(self, node: Node, topic: dict[str, Any]) -> None:
        self._node = node
        self._topic = topic
        self._deadline = node.now() + Duration.from_sec(float(topic["timeout"]))
        self._num_messages = threading.Event()
        node.subscribe(topic["name"], AnyMsg, lambda _message: self._num_messages.set())

    def settled(self) -> bool:
        """Return whether the check of this topic is complete.

        Raises:
            FailedError: it does not meet the expectations.
        """
        name, timeout, negative = self._topic["name"], self._topic["timeout"], self._topic["negative"]
        if self._num_messages.is_set():
            require(not negative, f"a message arrived on {name}")
            return True
        if self._node.now() > self._deadline:
            require(negative, f"no message arrived on {name} within {timeout} s")
            return True
        return False


def _test_publish(node: Node, topics: list[dict[str, Any]]) -> None:
    await_clock(node)
    for topic in topics:
        wanted = "no message" if topic["negative"] else "a message"
        node.log.info(f"waiting up to {topic['timeout']} s for {wanted} on {topic['name']}")
    waiting = [_TopicCheck(node, topic) for topic in topics]
    while waiting := [topic for topic in waiting if not topic.settled()]:
        pause(node, STEP / 5)
