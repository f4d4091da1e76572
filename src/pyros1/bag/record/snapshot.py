"""Keeps the last messages of topics in memory, and writes them to a bag on request."""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable
from operator import itemgetter

from pyros1.bag.record.disk_space import SpaceGuard
from pyros1.bag.record.file import RecordFile
from pyros1.bag.record.model import RecordOptions, Source, Sources, Topic, clock_of
from pyros1.bag.record.queue import OVERHEAD
from pyros1.msgs import AnyMsg
from pyros1.node import Node

Entry = tuple[int, Source, bytes]
"""Receive time in nanoseconds, publisher, bytes."""


class MessageRing:
    """The last messages of one topic; at least one of each latching publisher is kept.

    Args:
        duration: nanoseconds to keep; 0: no limit.
        size: bytes of memory to keep; 0: no limit.
    """

    def __init__(self, duration: int, size: int) -> None:
        self._duration = duration
        self._size = size
        self._entries: deque[Entry] = deque()
        self._latched: dict[Source, Entry] = {}
        self._lock = threading.Lock()
        self.bytes = 0

    def add(self, stamp: int, source: Source, data: bytes) -> None:
        """Add a message."""
        entry = (stamp, source, data)
        with self._lock:
            if source.latching:
                self._latched[source] = entry
            self._entries.append(entry)
            self.bytes += len(data) + OVERHEAD
            self._trim(stamp)

    def _trim(self, now: int) -> None:
        entries = self._entries
        while entries and (
            (self._size and self.bytes > self._size and len(entries) > 1)
            or (self._duration and now - entries[0][0] > self._duration)
        ):
            _, _, data = entries.popleft()
            self.bytes -= len(data) + OVERHEAD

    def messages_at(self, now: int) -> tuple[list[Entry], list[Entry]]:
        """Return the messages at a time: latched messages that are older than the rest, and the rest."""
        with self._lock:
            if self._entries and now < self._entries[-1][0]:  # simulated time has started again
                now = self._entries[-1][0]
            self._trim(now)
            current = list(self._entries)
            current_ids = {id(entry) for entry in current}
            return [entry for entry in self._latched.values() if id(entry) not in current_ids], current

    def clear(self) -> None:
        """Remove all messages except latched ones."""
        with self._lock:
            self._entries.clear()
            self.bytes = 0


class Snapshots:
    """Keeps the last messages of topics.

    Args:
        node: subscribes.
        options: how to write; its limits are ignored.
        duration: seconds to keep of each topic; 0: no limit.
        size: bytes of memory for each topic; 0: no limit.
        warn: called with the text of a warning.

    Attributes:
        topics: the topics, by name.
        enabled: whether messages are kept.
    """

    def __init__(
        self, node: Node, options: RecordOptions, duration: float, size: int, warn: Callable[[str], object]
    ) -> None:
        self.topics: dict[str, Topic] = {}
        self.enabled = True
        self._node = node
        self._options = options
        self._duration = int(duration * 1e9)
        self._size = size
        self._now = clock_of(node)
        self._rings: dict[str, MessageRing] = {}
        self._writing = threading.Lock()
        self._number = 0
        folder = os.path.dirname(options.names.name(0, time.time())) or "."
        self._space = SpaceGuard(folder, options.min_space, warn)

    @property
    def bytes(self) -> int:
        """Bytes of memory that the messages take."""
        return sum(ring.bytes for ring in list(self._rings.values()))

    def subscribe(self, name: str) -> None:
        """Begin to keep a topic's messages."""
        topic = self.topics[name] = Topic(name)
        ring = self._rings[name] = MessageRing(self._duration, self._size)
        source_of, now = Sources(topic).of, self._now

        def on_message(message: AnyMsg) -> None:
            if self.enabled:
                topic.messages += 1
                topic.bytes += len(message._buff)
                ring.add(now(), source_of(message._connection_header or {}), message._buff)

        topic.subscriber = self._node.subscribe(name, AnyMsg, on_message)

    def enable(self, enabled: bool) -> None:
        """Keep messages, or pause. Messages from before a pause are removed at its end."""
        if enabled and not self.enabled:
            for ring in list(self._rings.values()):
                ring.clear()
        self.enabled = enabled

    def write(self) -> tuple[str, int]:
        """Write the messages to a bag. They are also kept for the next one.

        Returns:
            The file's name and the number of messages in it; without messages an empty name, and no file is written.

        Raises:
            BagError: the disk has too little space.
            OSError: the file cannot be written.
        """
        with self._writing:
            now = self._now()
            latched_entries: list[Entry] = []
            entries: list[Entry] = []
            for ring in list(self._rings.values()):
                latched, current = ring.messages_at(now)
                latched_entries += latched
                entries += current
            if not (latched_entries or entries):
                return "", 0
            entries.sort(key=itemgetter(0))
            # Old ones get the time of the beginning: a bag that began at their time would be mostly empty.
            begin = entries[0][0] if entries else now
            self._space.check()
            options = self._options
            path = _unused_path(options.names.name(self._number, time.time()))
            file = RecordFile[Source](path, options.compression, options.chunk_size)
            self._number += 1
            try:
                for _, source, data in latched_entries:
                    file.write(source, source.topic.name, source.header, begin, data)
                for stamp, source, data in entries:
                    file.write(source, source.topic.name, source.header, stamp, data)
            finally:
                file.close()
            return file.path, file.messages


def _unused_path(path: str) -> str:
    """Return an unused name: a snapshot of the same second or name must not replace an earlier one."""
    found, number = path, 1
    while os.path.lexists(found):
        found, number = f"{path.removesuffix('.bag')}_{number}.bag", number + 1
    return found
