"""Records the messages of a topic, for tests that wait for some of them."""

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
_MAX_PRINTED_LENGTH = 300  # maximum number of characters of a message in an error message


class Heard(Generic[M]):
    """The messages received on a topic since the test started listening.

    Args:
        node: the node that subscribes.
        topic: name of the topic.
        type: the message class, or the name of a type, such as "std_msgs/Float64".

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
        self._num_returned = 0
        self._subscriber: Any = node.subscribe(topic, type, self._on_message)

    def _on_message(self, message: M) -> None:
        with self._changed:
            self._messages.append(message)
            self.count += 1
            self._changed.notify_all()

    @property
    def messages(self) -> list[M]:
        """The received messages, oldest first; only the newest 10,000 are kept."""
        with self._changed:
            return list(self._messages)

    def next(self, timeout: float = DEFAULT_TIMEOUT) -> M:
        """Return the next message that neither `next` nor `wait` has returned.

        Args:
            timeout: maximum number of seconds to wait for the message.

        Raises:
            AssertionError: no such message arrived in time.
        """
        return self.wait(1, timeout)[0]

    def wait(self, count: int, timeout: float = DEFAULT_TIMEOUT) -> list[M]:
        """Return the next messages that neither `next` nor `wait` has returned.

        Args:
            count: number of messages.
            timeout: maximum number of seconds to wait for all of them.

        Raises:
            AssertionError: fewer messages arrived in time.
        """
        with self._changed:
            if not self._changed.wait_for(lambda: self.count - self._num_returned >= count, timeout):
                arrived = self.count - self._num_returned
                raise AssertionError(
                    f"{arrived} of {count} messages arrived within {timeout:g} s. {self._describe_state()}"
                )
            first_index = self._num_returned - (self.count - len(self._messages))
            if first_index < 0:
                raise AssertionError(
                    f"{-first_index} messages of {self.topic} were discarded: only the newest {MAX_MESSAGES} are kept"
                )
            self._num_returned += count
            return list(self._messages)[first_index : first_index + count]

    def first(self, fits: Callable[[M], object] = lambda _: True, timeout: float = DEFAULT_TIMEOUT) -> M:
        """Return the first matching message: one that has already arrived, or else one that arrives in time.

        Args:
            fits: called with each message; returns true if it matches.
            timeout: maximum number of seconds to wait for a match.

        Raises:
            AssertionError: no such message arrived in time.
        """
        deadline = time.monotonic() + timeout
        num_checked = 0
        with self._changed:
            while True:
                num_new = min(self.count - num_checked, len(self._messages))
                for message in list(self._messages)[len(self._messages) - num_new :] if num_new else ():
                    if fits(message):
                        return message
                num_checked = self.count
                if not self._changed.wait_for(lambda: self.count > num_checked, deadline - time.monotonic()):  # noqa: B023
                    raise AssertionError(f"no matching message arrived within {timeout:g} s. {self._describe_state()}")

    def nothing(self, seconds: float) -> None:
        """Verify, for a number of seconds, that there are no messages except those returned by `next` and `wait`.

        Args:
            seconds: how long to wait.

        Raises:
            AssertionError: there was such a message already, or one arrived during this time.
        """
        with self._changed:
            if self._changed.wait_for(lambda: self.count > self._num_returned, seconds):
                raise AssertionError(f"an unexpected message arrived. {self._describe_state()}")

    def clear(self) -> None:
        """Discard the messages received so far."""
        with self._changed:
            self._messages.clear()
            self.count = self._num_returned = 0

    def _describe_state(self) -> str:
        """Return a description of the state that helps to find out why a message is missing or unexpected."""
        connected = self._subscriber.num_connections
        if not connected:
            return f"{self.topic}: no node publishes this topic, or it has a different type: see `pyros1 topic info`."
        if not self.count:
            return f"{self.topic}: connected to {connected} publisher(s), which sent nothing."
        last = str(self._messages[-1])
        last = last[:_MAX_PRINTED_LENGTH] + "..." * (len(last) > _MAX_PRINTED_LENGTH)
        return f"{self.topic}: {self.count} messages arrived in total, the last one:\n{last}"
