"""Stores the latest log messages from all nodes (/rosout), so that a reloaded page can display them."""

from __future__ import annotations

import secrets
import threading
from collections import deque
from collections.abc import Callable, Iterable
from itertools import islice
from typing import Any, NamedTuple

from pyros1.node import Node

_QUEUE_SIZE = 20_000
"""Maximum number of messages queued per node; it is high, so that no node is delayed."""
MAX_ENTRIES = 50_000
"""Maximum number of stored messages."""
_MAX_TEXT_LENGTH = 20_000
"""Maximum number of characters stored per message."""
_MAX_TOPICS = 50
_MAX_NAME_LENGTH = 500
MAX_CHARACTERS = 50_000_000
"""Maximum total number of characters stored."""


class Entry(NamedTuple):
    """A log message."""

    number: int
    time: float
    level: int
    node: str
    text: str
    file: str
    function: str
    line: int
    topics: list[str]
    nanoseconds: int
    """The nanosecond part of the time, since ``time``, which is a float, is not precise enough."""


class Console:
    """The latest log messages from all nodes.

    Args:
        size: maximum number of stored messages.

    Attributes:
        run_id: an id of this run of the server. In each run, messages are numbered from 1.
    """

    def __init__(self, size: int = MAX_ENTRIES) -> None:
        self.run_id = secrets.token_hex(8)
        self._lock = threading.Lock()
        self._entries: deque[Entry] = deque(maxlen=size)
        self._last_number = 0
        self._total_characters = 0
        self._listeners: tuple[Callable[[], object], ...] = ()

    def start(self, node: Node) -> None:
        """Start to collect log messages: subscribe the node to /rosout."""
        # Not /rosout_agg: the rosout node, which publishes the messages again there, may not be running, and delays
        # them.
        node.subscribe("/rosout", "rosgraph_msgs/Log", self.add, queue_size=_QUEUE_SIZE)

    def add(self, message: Any) -> None:
        """Add a rosgraph_msgs/Log message."""
        text = message.msg[: _MAX_TEXT_LENGTH + 1]
        if len(text) > _MAX_TEXT_LENGTH:
            text = f"{text[:_MAX_TEXT_LENGTH]}..."
        file, function = message.file[:_MAX_NAME_LENGTH], message.function[:_MAX_NAME_LENGTH]
        topics = [topic[:_MAX_NAME_LENGTH] for topic in message.topics[:_MAX_TOPICS]]
        name, stamp = message.name[:_MAX_NAME_LENGTH], message.header.stamp
        with self._lock:
            self._last_number += 1
            if len(self._entries) == self._entries.maxlen:
                self._remove_oldest()
            level, line = message.level, message.line
            entry = Entry(
                self._last_number, stamp.to_sec(), level, name, text, file, function, line, topics, stamp.nsecs
            )
            self._total_characters += _num_characters(entry)
            while self._total_characters > MAX_CHARACTERS and self._entries:
                self._remove_oldest()
            self._entries.append(entry)
        for listener in self._listeners:
            listener()

    def _remove_oldest(self) -> None:
        self._total_characters -= _num_characters(self._entries.popleft())

    def entries_after(
        self, number: int, max_entries: int, max_characters: int = MAX_CHARACTERS
    ) -> tuple[list[Entry], int]:
        """Return the messages that follow the message with a given number.

        Args:
            number: the number of the last known message; 0 for none.
            max_entries: maximum number of messages; if there are more, the oldest are returned.
            max_characters: maximum total number of characters, but at least one message is returned, however long it
                is.

        Returns:
            The messages, and how many messages before them are missing, since they are no longer stored.
        """
        with self._lock:
            first = self._entries[0].number if self._entries else self._last_number + 1
            number = min(number, self._last_number)
            start = max(number + 1, first)
            entries = list(_slice(self._entries, start - first, max_entries))
        for count, entry in enumerate(entries):
            max_characters -= _num_characters(entry)
            if max_characters < 0 and count:
                del entries[count:]
                break
        return entries, start - number - 1

    def listen(self, listener: Callable[[], object]) -> Callable[[], None]:
        """Call a listener after each message, in a thread of the node; return a function that removes the listener."""
        with self._lock:
            self._listeners = (*self._listeners, listener)

        def stop_listening() -> None:
            with self._lock:
                self._listeners = tuple(each for each in self._listeners if each is not listener)

        return stop_listening


def _num_characters(entry: Entry) -> int:
    return sum(map(len, (entry.text, entry.node, entry.file, entry.function, *entry.topics)))


def _slice(entries: deque[Entry], start: int, max_entries: int) -> Iterable[Entry]:
    if start > len(entries) // 2:  # traverse the deque from the nearer end
        last = len(entries) - start
        return reversed(list(islice(reversed(entries), max(0, last - max_entries), last)))
    return islice(entries, start, start + max_entries)
