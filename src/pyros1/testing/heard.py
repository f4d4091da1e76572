"""Messages of a topic, kept for a test that waits for some of them."""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable
from typing import Any, Generic, TypeVar

from pyros1.node import Node

M = TypeVar("M")
MAX_MESSAGES = 10_000
"""Maximum number of messages kept; older ones are discarded."""
DEFAULT_TIMEOUT = 10.0
"""Default timeout of waits, in seconds."""
_SHOWN = 300  # maximum number of characters of a message


class Heard(Generic[M]):
    """The messages received on a topic since the test began to listen.

    Args:
        node: the node that subscribes.
        topic: name of the topic.
        type: message class, or a type's name such as "std_msgs/Float64".

    Attributes:
        topic: full name of the topic.
        count: number of messages received.
    """

    def __init__(self, node: Node, topic: str, type: type[M] | str) -> None:
        self.topic = node.resolve(topic)
        self.count = 0
        self._node = node
        self._messages: deque[M] = deque(maxlen=MAX_MESSAGES)
        self._changed = threading.Condition()
        self._num_taken = 0
        self._subscriber: Any = node.subscribe(topic, type, self._on_message)

    def _on_message(self, message: M) -> None:
        with self._changed:
            self._messages.append(message)
            self.count += 1
            self._changed.notify_all()

    @property
    def messages(self) -> list[M]:
        """The received messages, the oldest first; at most the last 10,000."""
        with self._changed:
            return list(self._messages)

    def next(self, timeout: float = DEFAULT_TIMEOUT) -> M:
        """Return the next message that neither `next` nor `wait` has returned.

        Args:
            timeout: seconds to wait for it.

        Raises:
            AssertionError: none arrived in time.
        """
        return self.wait(1, timeout)[0]

    def wait(self, count: int, timeout: float = DEFAULT_TIMEOUT) -> list[M]:
        """Return the next messages that neither `next` nor `wait` has returned.

        Args:
            count: number of messages.
            timeout: seconds to wait for all of them.

        Raises:
            AssertionError: fewer arrived in time.
        """
        with self._changed:
            if not self._changed.wait_for(lambda: self.count - self._num_taken >= count, timeout):
                came = self.count - self._num_taken
                raise AssertionError(f"{came} of {count} messages arrived within {timeout:g} s. {self._status_text()}")
            skipped = self._num_taken - (self.count - len(self._messages))
            if skipped < 0:
                raise AssertionError(
                    f"{-skipped} messages of {self.topic} were forgotten: only {MAX_MESSAGES} are kept"
                )
            self._num_taken += count
            return list(self._messages)[skipped : skipped + count]

    def first(self, fits: Callable[[M], object] = lambda _: True, timeout: float = DEFAULT_TIMEOUT) -> M:
        """Return the first matching message, whether it has already arrived or arrives now.

        Args:
            fits: called with each message; returns true for a match.
            timeout: seconds to wait for it.

        Raises:
            AssertionError: none arrived in time.
        """
        end = time.monotonic() + timeout
        seen = 0
        with self._changed:
            while True:
                new = min(self.count - seen, len(self._messages))
                for message in list(self._messages)[len(self._messages) - new :] if new else ():
                    if fits(message):
                        return message
                seen = self.count
                if not self._changed.wait_for(lambda: self.count > seen, end - time.monotonic()):  # noqa: B023
                    raise AssertionError(f"no matching message arrived within {timeout:g} s. {self._status_text()}")

    def nothing(self, seconds: float) -> None:
        """Wait, and make sure that there is no message that neither `next` nor `wait` has returned.

        Args:
            seconds: the duration.

        Raises:
            AssertionError: there was one, or one arrived.
        """
        with self._changed:
            if self._changed.wait_for(lambda: self.count > self._num_taken, seconds):
                raise AssertionError(f"an unexpected message arrived. {self._status_text()}")

    def clear(self) -> None:
        """Discard the messages received so far."""
        with self._changed:
            self._messages.clear()
            self.count = self._num_taken = 0

    def _status_text(self) -> str:
        """Return a text that helps to find out why a message is missing."""
        connected = self._subscriber.num_connections
        if not connected:
            return f"{self.topic}: no node publishes this topic, or it has a different type: see `pyros1 topic info`."
        if not self.count:
            return f"{self.topic}: connected to {connected} publisher(s), which sent nothing."
        last = str(self._messages[-1])
        return (
            f"{self.topic}: {self.count} arrived in all, the last one:\n{last[:_SHOWN]}{'...' * (len(last) > _SHOWN)}"
        )
