"""publishtest checks that messages arrive on topics, or that no messages arrive."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from pyros1.ground.timing import Duration
from pyros1.msgs import AnyMsg
from pyros1.test_nodes.common import POLL_INTERVAL, SetupError, Test, list_param, pause, require, wait_for_clock

if TYPE_CHECKING:
    from pyros1.node import Node


def tests(node: Node) -> dict[str, Test]:
    """Return the test cases of publishtest, by name.

    Args:
        node: the node; its parameter ~topics is ``[{name: TOPIC, timeout: SECONDS, negative: BOOL}, ...]``.

    Raises:
        SetupError: the parameter contains no topic.
    """
    topics = list_param(node, "topics", {"timeout": 10, "negative": False})
    if not topics:
        raise SetupError(f"{node.resolve('~topics')} contains no topic to test")
    return {"test_publish": lambda: _test_publish(node, topics)}


class _TopicCheck:
    """The check of one topic, which lasts until a message arrives, or the timeout has passed in the node's time."""

    def __init__(self, node: Node, topic: dict[str, Any]) -> None:
        self._node = node
        self._topic = topic
        self._deadline = node.now() + Duration.from_sec(float(topic["timeout"]))
        self._received = threading.Event()
        node.subscribe(topic["name"], AnyMsg, lambda _message: self._received.set())

    def is_complete(self) -> bool:
        """Return whether the check is complete.

        Raises:
            FailedError: the topic does not meet the expectations.
        """
        name, timeout, negative = self._topic["name"], self._topic["timeout"], self._topic["negative"]
        if self._received.is_set():
            require(not negative, f"a message arrived on {name}")
            return True
        if self._node.now() > self._deadline:
            require(negative, f"no message arrived on {name} within {timeout} s")
            return True
        return False


def _test_publish(node: Node, topics: list[dict[str, Any]]) -> None:
    wait_for_clock(node)
    for topic in topics:
        expectation = "no message" if topic["negative"] else "a message"
        node.log.info(f"waiting up to {topic['timeout']} s for {expectation} on {topic['name']}")
    pending = [_TopicCheck(node, topic) for topic in topics]
    while pending := [check for check in pending if not check.is_complete()]:
        pause(node, POLL_INTERVAL / 5)
