"""Keeps the latest messages on some topics in memory, and writes them to a bag on request."""

from __future__ import annotations

import os
import threading
import time
from collections import deque
from collections.abc import Callable
from operator import itemgetter

from pyros1.bag.record.disk_space import SpaceGuard
from pyros1.bag.record.file import RecordFile
from pyros1.bag.record.model import RecordedPublisher, RecordedPublishers, RecordOptions, Topic, make_clock
from pyros1.bag.record.queue import MESSAGE_OVERHEAD
from pyros1.msgs import AnyMsg
from pyros1.node import Node

Entry = tuple[int, RecordedPublisher, bytes]
"""A message: (receive time in nanoseconds, publisher, bytes)."""


class MessageRing:
    """The latest messages on one topic; at least one from each latching publisher is kept.

    Args:
        duration: nanoseconds to keep; 0 for no limit.
        size: maximum size in bytes; 0 for no limit.

    Attributes:
        bytes: memory that the messages take, in bytes.
    """

    def __init__(self, duration: int, size: int) -> None:
        self._duration = duration
        self._max_size = size
        self._entries: deque[Entry] = deque()
        self._latched: dict[RecordedPublisher, Entry] = {}
        self._lock = threading.Lock()
        self.bytes = 0

    def add(self, stamp: int, publisher: RecordedPublisher, data: bytes) -> None:
        """Add a message."""
        entry = (stamp, publisher, data)
        with self._lock:
            if publisher.latching:
                self._latched[publisher] = entry
            self._entries.append(entry)
            self.bytes += len(data) + MESSAGE_OVERHEAD
            self._trim(stamp)

    def _trim(self, now: int) -> None:
        entries = self._entries
        while entries and (
            (self._max_size and self.bytes > self._max_size and len(entries) > 1)
            or (self._duration and now - entries[0][0] > self._duration)
        ):
            _, _, data = entries.popleft()
            self.bytes -= len(data) + MESSAGE_OVERHEAD

    def messages_at(self, now: int) -> tuple[list[Entry], list[Entry]]:
        """Return the messages to keep as of ``now``: latched ones that have left the ring, and those in the ring."""
        with self._lock:
            if self._entries and now < self._entries[-1][0]:  # simulated time has restarted
                now = self._entries[-1][0]
            self._trim(now)
            current = list(self._entries)
            current_ids = {id(entry) for entry in current}
            return [entry for entry in self._latched.values() if id(entry) not in current_ids], current

    def clear(self) -> None:
        """Remove all messages except the last one of each latching publisher."""
        with self._lock:
            self._entries.clear()
            self.bytes = 0


class SnapshotBuffer:
    """Keeps the latest messages on some topics.

    Args:
        node: the node that subscribes.
        options: the recording options; their limits are ignored.
        duration: seconds of messages to keep per topic; 0 for no limit.
        size: maximum size in bytes per topic; 0 for no limit.
        warn: called with a warning.

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
        self._max_size = size
        self._now = make_clock(node)
        self._rings: dict[str, MessageRing] = {}
        self._write_lock = threading.Lock()
        self._file_number = 0
        folder = os.path.dirname(options.names.name(0, time.time())) or "."
        self._space = SpaceGuard(folder, options.min_space, warn)

    @property
    def bytes(self) -> int:
        """Memory used by the messages, in bytes."""
        return sum(ring.bytes for ring in list(self._rings.values()))

    def subscribe(self, name: str) -> None:
        """Start keeping a topic's messages."""
        topic = self.topics[name] = Topic(name)
        ring = self._rings[name] = MessageRing(self._duration, self._max_size)
        publisher_of, now = RecordedPublishers(topic).get, self._now

        def on_message(message: AnyMsg) -> None:
            if self.enabled:
                topic.messages += 1
                topic.bytes += len(message._buff)
                ring.add(now(), publisher_of(message._connection_header or {}), message._buff)

        topic.subscriber = self._node.subscribe(name, AnyMsg, on_message)

    def enable(self, enabled: bool) -> None:
        """Start or pause keeping messages. When a pause ends, the messages from before it are removed."""
        if enabled and not self.enabled:
            for ring in list(self._rings.values()):
                ring.clear()
        self.enabled = enabled

    def write(self) -> tuple[str, int]:
        """Write the messages to a bag. They are kept for the next snapshot as well.

        Returns:
            The path of the file and the number of messages in it. Without messages, no file is written and the path is
            empty.

        Raises:
            BagError: the disk has too little space.
            OSError: the file cannot be written.
        """
        with self._write_lock:
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
            # Old latched messages get the time of the first current message: a bag that began at their own times would
            # be mostly empty.
            begin = entries[0][0] if entries else now
            self._space.check()
            options = self._options
            path = _unused_path(options.names.name(self._file_number, time.time()))
            file = RecordFile[RecordedPublisher](path, options.compression, options.chunk_size)
            self._file_number += 1
            try:
                for _, publisher, data in latched_entries:
                    file.write(publisher, publisher.topic.name, publisher.header, begin, data)
                for stamp, publisher, data in entries:
                    file.write(publisher, publisher.topic.name, publisher.header, stamp, data)
            finally:
                file.close()
            return file.path, file.messages


def _unused_path(path: str) -> str:
    """Return an unused path, so that a snapshot with the same name does not replace an earlier one."""
    unused_path, number = path, 1
    while os.path.lexists(unused_path):
        unused_path, number = f"{path.removesuffix('.bag')}_{number}.bag", number + 1
    return unused_path
