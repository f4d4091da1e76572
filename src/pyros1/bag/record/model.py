"""The data of a recording: options, topics, and their publishers."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from pyros1.bag.record.file_names import FileNames
from pyros1.node import Node


@dataclass(frozen=True)
class RecordOptions:
    """Recording options.

    Attributes:
        names: the file names.
        split: whether to start a new file when a file reaches a limit; otherwise the recording ends then.
        max_size: maximum size of a file in bytes; 0 for no limit.
        max_duration: maximum duration of a file in seconds; 0 for no limit.
        max_splits: number of files to keep: the oldest are removed; 0 keeps all.
        buffer_size: maximum number of bytes waiting to be written; 0 for no limit.
        chunk_size: size of a chunk in bytes.
        compression: ``none``, ``bz2`` or ``lz4``.
        limit: number of messages to record per topic; 0 for no limit.
        repeat_latched: whether each file after the first starts with the latched messages.
        min_space: bytes that must stay free on the disk.
    """

    names: FileNames = field(default_factory=FileNames)
    split: bool = False
    max_size: int = 0
    max_duration: float = 0.0
    max_splits: int = 0
    buffer_size: int = 256 << 20
    chunk_size: int = 768 << 10
    compression: str = "none"
    limit: int = 0
    repeat_latched: bool = False
    min_space: int = 1 << 30


@dataclass(eq=False)
class Topic:
    """A recorded topic.

    Attributes:
        name: its full name.
        messages: number of messages received so far.
        bytes: total size of these messages in bytes.
        dropped: number of these messages that were not written because the buffer or the disk was full.
        received_after_end: number of these messages that were not written because they arrived after the recording had
        ended.
        subscriber: the subscriber that receives the messages.
    """

    name: str
    messages: int = 0
    bytes: int = 0
    dropped: int = 0
    received_after_end: int = 0
    subscriber: Any = None

    @property
    def written(self) -> int:
        """Number of messages that are in the files, or will be."""
        return self.messages - self.dropped - self.received_after_end


@dataclass(eq=False)
class RecordedPublisher:
    """A publisher on a recorded topic.

    Attributes:
        topic: the topic on which it publishes.
        header: its connection header as received.
        latching: whether it latches its messages.
        latched: its last message, if it is latching.
    """

    topic: Topic
    header: dict[str, str]
    latching: bool = False
    latched: bytes | None = None


class RecordedPublishers:
    """The publishers of one topic. After a reconnection, a publisher is recognised by its header."""

    def __init__(self, topic: Topic) -> None:
        self._topic = topic
        self._by_header_id: dict[int, tuple[dict[str, str], RecordedPublisher]] = {}
        self._by_content: dict[frozenset[tuple[str, str]], RecordedPublisher] = {}

    def get(self, header: dict[str, str]) -> RecordedPublisher:
        """Return the publisher with the given connection header; a new one is added."""
        entry = self._by_header_id.get(id(header))
        if entry is not None:
            return entry[1]
        if len(self._by_header_id) > 1000:
            self._by_header_id.clear()  # otherwise entries of closed connections would accumulate
        key = frozenset(header.items())
        publisher = self._by_content.get(key)
        if publisher is None:
            publisher = self._by_content[key] = RecordedPublisher(self._topic, header, header.get("latching") == "1")
        self._by_header_id[id(header)] = (header, publisher)  # keeps the header alive, so that its id is not reused
        return publisher


def make_clock(node: Node) -> Callable[[], int]:
    """Return a function that returns the node's time in nanoseconds."""
    if node.params.get("/use_sim_time", False) is True:
        return lambda: node.now().to_nsec()
    return time.time_ns
