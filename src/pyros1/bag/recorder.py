"""Records topics into bags: raw frames with their publishers' connection headers, never decoded.

The node's threads receive, stamp and queue; one thread writes. Nothing else happens per message.
"""

from __future__ import annotations

import contextlib
import os
import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import chain
from typing import Any

from pyros1.bag.errors import BagError
from pyros1.bag.record_file import RecordFile
from pyros1.bag.record_names import FileNames
from pyros1.bag.record_queue import RecordQueue
from pyros1.msgs import AnyMsg
from pyros1.node import Node

NS = 1_000_000_000
_POLL = 0.05
_SPACE_TIME = 1.0
_WARN_TIME = 20.0
_WARN_FACTOR = 5


@dataclass(frozen=True)
class RecordOptions:
    """How to record.

    Attributes:
        names: of the files.
        split: begin a new file at a limit; else the recording ends there.
        max_size: limit of a file in bytes; 0 for none.
        max_duration: limit of a file in seconds; 0 for none.
        max_splits: files that are kept, the oldest are removed; 0 for all.
        buffer_size: bytes that may wait for the disk; 0 for no limit.
        chunk_size: bytes of a chunk.
        compression: ``none``, ``bz2`` or ``lz4``.
        limit: messages of each topic; 0 for all.
        repeat_latched: begin each further file with the latched messages.
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
        name: full name.
        messages: received so far.
        bytes: of these.
        dropped: of these, not written because the buffer or the disk was full.
        beyond: of these, not written because they came after the end.
        subscriber: receives them.
    """

    name: str
    messages: int = 0
    bytes: int = 0
    dropped: int = 0
    beyond: int = 0
    subscriber: Any = None

    @property
    def written(self) -> int:
        """Messages that are in the files, or will be."""
        return self.messages - self.dropped - self.beyond


@dataclass(eq=False)
class Source:
    """A publisher on a recorded topic.

    Attributes:
        topic: the topic.
        header: its connection header as received.
        latched: its last message, if it latches.
    """

    topic: Topic
    header: dict[str, str]
    latching: bool = False
    latched: bytes | None = None


class Sources:
    """The publishers of one topic. The same header, after a reconnection, is the same publisher."""

    def __init__(self, topic: Topic) -> None:
        self._topic = topic
        self._by_object: dict[int, tuple[dict[str, str], Source]] = {}
        self._by_content: dict[frozenset[tuple[str, str]], Source] = {}

    def of(self, header: dict[str, str]) -> Source:
        """Return the publisher with a header."""
        found = self._by_object.get(id(header))
        if found is not None:
            return found[1]
        if len(self._by_object) > 1000:
            self._by_object.clear()  # links come and go
        key = frozenset(header.items())
        source = self._by_content.get(key)
        if source is None:
            source = self._by_content[key] = Source(self._topic, header, header.get("latching") == "1")
        self._by_object[id(header)] = (header, source)  # which keeps the object, so that its id is not used again
        return source


@dataclass
class Events:
    """What a recorder tells; all are called in its writing thread.

    Attributes:
        opened: with the name of a file.
        closing: with the name of a file.
        warning: with a text.
        ended: when the recording has ended by itself, with the error or, at a limit, None.
    """

    opened: Callable[[str], object] = lambda path: None
    closing: Callable[[str], object] = lambda path: None
    warning: Callable[[str], object] = lambda text: None
    ended: Callable[[Exception | None], object] = lambda error: None


@dataclass
class Report:
    """What was recorded.

    Attributes:
        files: names of those that were finished, in order.
        messages: in these.
        bytes: of these.
    """

    files: list[str] = field(default_factory=list)
    messages: int = 0
    bytes: int = 0


class Recorder:
    """A recording. Also a context manager that ends it.

    Args:
        node: subscribes.
        options: how to record.
        events: whom to tell what.

    Attributes:
        topics: those recorded, by name.
        report: what is in finished files.

    Raises:
        OSError: the first file cannot be made.
        BagError: the disk has too little space.
    """

    def __init__(self, node: Node, options: RecordOptions, events: Events | None = None) -> None:
        self.topics: dict[str, Topic] = {}
        self.report = Report()
        self._node = node
        self._options = options
        self._events = events or Events()
        self._now = clock_of(node)
        self._queue: RecordQueue[Source] = RecordQueue(options.buffer_size, self._dropped)
        self._sources: list[Sources] = []
        self._latching: dict[Source, None] = {}
        self._finished: deque[str] = deque()
        self._number = 0
        self._began = self._now()
        self._space_at = 0.0
        self._warned: dict[str, float] = {}
        self._ending = threading.Event()
        self._unwritten: list[tuple[Source, int, bytes]] = []  # of a batch that could not be finished
        self._done = 0  # topics that have reached the limit
        self._file: RecordFile[Source] | None = None
        folder = os.path.dirname(options.names.name(0, time.time()))
        self._folder = folder or "."
        self._check_space()
        self._file = self._open()
        self._thread = threading.Thread(target=self._run, name="bag:writer", daemon=True)
        self._thread.start()

    # Topics -----------------------------------------------------------------------------------------------------------

    def subscribe(self, name: str, *, tcp_nodelay: bool = True) -> None:
        """Record a topic from now on."""
        topic = self.topics[name] = Topic(name)
        topic.subscriber = self._node.subscribe(name, AnyMsg, self._taker(topic), tcp_nodelay=tcp_nodelay)

    def _taker(self, topic: Topic) -> Callable[[AnyMsg], None]:
        """Return the callback of a topic; its calls never overlap."""
        of, now, put, limit = Sources(topic).of, self._now, self._queue.put, self._options.limit

        def take(message: AnyMsg) -> None:
            stamp, data = now(), message._buff
            source = of(message._connection_header or {})
            if limit and topic.messages >= limit:
                return
            if put(source, stamp, data):
                topic.messages += 1
                topic.bytes += len(data)
                if topic.messages == limit:
                    self._done += 1

        return take

    def leave_finished(self) -> bool:
        """Unsubscribe from topics that have reached the limit; tell whether all have."""
        limit = self._options.limit
        if not limit or not self._done:
            return False
        for topic in self.topics.values():
            if topic.messages >= limit and topic.subscriber is not None:
                topic.subscriber.unregister()
                topic.subscriber = None
        return all(topic.subscriber is None for topic in self.topics.values())

    def _dropped(self, source: Source) -> None:
        source.topic.dropped += 1
        self._warn("rosbag record buffer exceeded.  Dropping oldest queued message.", 5.0)

    def _warn(self, text: str, every: float) -> None:
        now = time.monotonic()
        if now - self._warned.get(text[:20], -every) >= every:
            self._warned[text[:20]] = now
            self._events.warning(text)

    @property
    def size(self) -> int:
        """Bytes of all files so far."""
        file = self._file
        return self.report.bytes + (file.size if file is not None else 0)

    # Ending -----------------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """End: write what was received, and close the file."""
        self._ending.set()
        self._queue.wake()
        self._thread.join()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # Writing, in the thread -------------------------------------------------------------------------------------------

    def _run(self) -> None:
        error: Exception | None = None
        try:
            self._write_all()
        except (OSError, BagError) as caught:
            error = caught
        for source, _, _ in chain(self._unwritten, self._queue.close()):
            if error is None:
                source.topic.beyond += 1
            else:
                source.topic.dropped += 1
        try:
            self._close_file()
        except OSError as caught:
            error = error or caught
        if not self._ending.is_set():
            self._events.ended(error)

    def _write_all(self) -> None:
        """Write until the end or a limit."""
        while True:
            ending = self._ending.is_set()
            batch = self._queue.close() if ending else self._queue.take(_POLL)
            if not self._write_batch(batch) or ending:
                return
            if not batch and not self._within_limits(self._now()):
                return
            if self._file is not None:
                self._file.tick()
            self._check_space()

    def _write_batch(self, batch: list[tuple[Source, int, bytes]]) -> bool:
        """Write messages; return False at a limit."""
        for index, (source, stamp, data) in enumerate(batch):
            if not self._within_limits(stamp):
                self._unwritten = batch[index:]
                return False
            try:
                self._write(source, stamp, data)
            except OSError:
                self._unwritten = batch[index + 1 :]
                raise
        return True

    def _write(self, source: Source, stamp: int, data: bytes) -> None:
        assert self._file is not None
        try:
            self._file.write(source, source.topic.name, source.header, stamp, data)
        except BagError as error:
            source.topic.dropped += 1
            self._warn(str(error), 5.0)
        if source.latching:
            source.latched = data
            self._latching[source] = None

    def _within_limits(self, stamp: int) -> bool:
        """Begin a new file at a limit; return False if the recording ends there."""
        options, file = self._options, self._file
        assert file is not None
        due = bool(options.max_size and file.size > options.max_size)
        if options.max_duration and stamp - self._began > options.max_duration * NS:
            due = True
            while options.split and stamp - self._began > options.max_duration * NS:
                self._began += int(options.max_duration * NS)
        if not due:
            return True
        if not options.split:
            return False
        self._close_file()
        self._forget_oldest()
        self._number += 1
        self._file = self._open()
        if options.repeat_latched:
            moment = self._now()
            for source in self._latching:
                if source.latched is not None:
                    self._file.write(source, source.topic.name, source.header, moment, source.latched)
        return True

    def _open(self) -> RecordFile[Source]:
        options = self._options
        path = options.names.name(self._number, time.time())
        file = RecordFile[Source](path, options.compression, options.chunk_size)
        self._events.opened(path)
        return file

    def _close_file(self) -> None:
        file, self._file = self._file, None
        if file is None:
            return
        self._events.closing(file.path)
        try:
            file.close()
        finally:
            for source, count in file.lost.items():
                source.topic.dropped += count
        with contextlib.suppress(OSError):
            self.report.bytes += os.path.getsize(file.path)
        self.report.files.append(file.path)
        self.report.messages += file.messages
        self._finished.append(file.path)

    def _forget_oldest(self) -> None:
        if self._options.max_splits and len(self._finished) > self._options.max_splits:
            with contextlib.suppress(OSError):
                os.remove(self._finished.popleft())

    def _check_space(self) -> None:
        """Look whether the disk has room.

        Raises:
            BagError: it has not.
        """
        moment = time.monotonic()
        if moment < self._space_at or not hasattr(os, "statvfs"):
            return
        self._space_at = moment + _SPACE_TIME
        try:
            disk = os.statvfs(self._folder)
        except OSError:
            return  # the write will say what is wrong
        free, least = disk.f_bavail * disk.f_frsize, self._options.min_space
        if free < least:
            raise BagError(
                self._folder,
                f"less than {_gigabytes(least)} of space free on the disk; recording ends (see --min-space)",
            )
        if free < _WARN_FACTOR * least:
            self._warn(f"Less than {_gigabytes(_WARN_FACTOR * least)} of space free on the disk.", _WARN_TIME)


def clock_of(node: Node) -> Callable[[], int]:
    """Return what tells a node's time in nanoseconds."""
    if node.params.get("/use_sim_time", False) is True:
        return lambda: node.now().to_nsec()
    return time.time_ns


def _gigabytes(size: int) -> str:
    return f"{size / (1 << 30):.3g} GiB"
