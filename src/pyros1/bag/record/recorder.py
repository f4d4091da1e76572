"""Records topics into bags: raw messages with their publishers' connection headers, never decoded.

The node's threads receive, stamp and queue the messages; one thread writes them.
"""

from __future__ import annotations

import contextlib
import errno
import os
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import chain

from pyros1.bag.errors import BagError
from pyros1.bag.record.disk_space import SpaceGuard
from pyros1.bag.record.file import RecordFile
from pyros1.bag.record.model import RecordedPublisher, RecordedPublishers, RecordOptions, Topic, make_clock
from pyros1.bag.record.queue import RecordQueue
from pyros1.msgs import AnyMsg
from pyros1.node import Node

_NS_PER_S = 1_000_000_000
_POLL_PERIOD = 0.05
_WARN_PERIOD = 5.0
_SPLIT_RETRY_DELAY = 1.0


@dataclass
class Events:
    """The callbacks of a recorder; all are called in its writing thread.

    Attributes:
        on_opened: called with the path of each file that has been opened.
        on_closing: called with the path of each file that is about to be closed.
        on_warning: called with a warning.
        on_ended: called when the recording has ended by itself, at a limit or after an error.
    """

    on_opened: Callable[[str], object] = lambda path: None
    on_closing: Callable[[str], object] = lambda path: None
    on_warning: Callable[[str], object] = lambda text: None
    on_ended: Callable[[], object] = lambda: None


@dataclass
class Report:
    """The files of a recording.

    Attributes:
        files: paths of the finished files, in order.
        messages: number of messages in these files.
        bytes: total size of these files in bytes.
    """

    files: list[str] = field(default_factory=list)
    messages: int = 0
    bytes: int = 0


class Recorder:
    """A recording. As a context manager, it ends on exit.

    Args:
        node: the node that subscribes.
        options: the recording options.
        events: the callbacks; None for no callbacks.

    Attributes:
        topics: the recorded topics, by name.
        report: summary of the finished files.
        error: the error that has ended the recording, or None.

    Raises:
        OSError: the first file cannot be created.
        BagError: the disk has too little space.
    """

    def __init__(self, node: Node, options: RecordOptions, events: Events | None = None) -> None:
        self.topics: dict[str, Topic] = {}
        self.report = Report()
        self.error: Exception | None = None
        self._node = node
        self._options = options
        self._events = events or Events()
        self._now = make_clock(node)
        self._queue: RecordQueue[RecordedPublisher] = RecordQueue(
            options.buffer_size, self._count_received, self._count_dropped
        )
        self._latching_publishers: dict[RecordedPublisher, None] = {}
        self._finished_paths: deque[str] = deque()
        self._file_number = 0
        self._file_started_at = self._now()
        self._retry_split_at = 0.0  # monotonic time at which to retry starting the next file
        self._warned_at: dict[str, float] = {}
        self._stop_event = threading.Event()
        self._unwritten_messages: list[
            tuple[RecordedPublisher, int, bytes]
        ] = []  # the remainder of an unfinished batch
        self._has_reached_limit = False  # whether a topic has reached the limit of messages
        self._has_dropped = False  # whether messages were dropped since the last warning
        folder = os.path.dirname(options.names.name(0, time.time())) or "."
        self._space = SpaceGuard(folder, options.min_space, self._events.on_warning)
        self._space.check()
        self._file: RecordFile[RecordedPublisher] | None = self._open(0)
        self._events.on_opened(self._file.path)
        self._thread = threading.Thread(target=self._run, name="bag:writer", daemon=True)
        self._thread.start()

    # Topics -----------------------------------------------------------------------------------------------------------

    def subscribe(self, name: str, *, transports: Sequence[str] = ("tcp",)) -> None:
        """Start recording a topic, with ``transports`` as for `Node.subscribe`."""
        topic = self.topics[name] = Topic(name)
        topic.subscriber = self._node.subscribe(name, AnyMsg, self._make_callback(topic), transports=transports)

    def _make_callback(self, topic: Topic) -> Callable[[AnyMsg], None]:
        """Return the callback for a topic's messages; its calls never overlap."""
        publisher_of, now, enqueue, limit = (
            RecordedPublishers(topic).get,
            self._now,
            self._queue.put,
            self._options.limit,
        )

        def on_message(message: AnyMsg) -> None:
            stamp, data = now(), message._buff
            publisher = publisher_of(message._connection_header or {})
            if limit and topic.messages >= limit:
                return
            if enqueue(publisher, stamp, data) and topic.messages == limit:
                self._has_reached_limit = True

        return on_message

    def unsubscribe_finished(self) -> bool:
        """Unsubscribe from topics that have reached the limit of messages; return whether all topics have reached
        it.
        """
        limit = self._options.limit
        if not limit or not self._has_reached_limit:
            return False
        for topic in self.topics.values():
            if topic.messages >= limit and topic.subscriber is not None:
                topic.subscriber.unregister()
                topic.subscriber = None
        return all(topic.subscriber is None for topic in self.topics.values())

    @staticmethod
    def _count_received(publisher: RecordedPublisher, size: int) -> None:
        publisher.topic.messages += 1
        publisher.topic.bytes += size

    def _count_dropped(self, publisher: RecordedPublisher) -> None:
        publisher.topic.dropped += 1
        self._has_dropped = True  # reported by the writing thread, so as not to delay this receiving thread

    def _warn(self, text: str) -> None:
        """Report a warning that each message could cause; warnings that begin with the same text are reported at most
        every five seconds.
        """
        now, warning_key = time.monotonic(), text[:20]
        if now - self._warned_at.get(warning_key, -_WARN_PERIOD) >= _WARN_PERIOD:
            self._warned_at[warning_key] = now
            self._events.on_warning(text)

    @property
    def size(self) -> int:
        """Size of all files so far, in bytes."""
        file = self._file
        return self.report.bytes + (file.size if file is not None else 0)

    # Ending -----------------------------------------------------------------------------------------------------------

    def close(self) -> None:
        """End the recording: write all received messages and close the file."""
        self._stop_event.set()
        self._queue.wake()
        self._thread.join()

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    # Writing, in the thread -------------------------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._write_all()
        except Exception as error:  # noqa: BLE001 - the file must be closed after any error
            self.error = error
        for publisher, _, _ in chain(self._unwritten_messages, self._queue.close()):
            if self.error is None:
                publisher.topic.received_after_end += 1
            else:
                publisher.topic.dropped += 1
        try:
            self._close_file()
        except OSError as error:
            self.error = self.error or error
        if not self._stop_event.is_set():
            self._events.on_ended()

    def _write_all(self) -> None:
        """Write messages until the recording ends, on request or at a limit."""
        while True:
            is_ending = self._stop_event.is_set()
            batch = self._queue.close() if is_ending else self._queue.take(_POLL_PERIOD)
            if not self._write_batch(batch) or is_ending:
                return
            if not batch and not self._split_if_due(self._now()):
                return
            if self._has_dropped:
                self._has_dropped = False
                self._warn("rosbag record buffer exceeded.  Dropping oldest queued message.")
            if self._file is not None:
                self._file.flush_if_due()
            self._space.check()

    def _write_batch(self, batch: list[tuple[RecordedPublisher, int, bytes]]) -> bool:
        """Write messages; return False if the recording has reached a limit and ends."""
        taken_count = 0
        try:
            for publisher, stamp, data in batch:
                if not self._split_if_due(stamp):
                    return False
                taken_count += 1  # a message that cannot be written is counted as lost by the file
                self._write(publisher, stamp, data)
        finally:
            self._unwritten_messages = batch[taken_count:]
        return True

    def _write(self, publisher: RecordedPublisher, stamp: int, data: bytes) -> None:
        assert self._file is not None
        try:
            self._file.write(publisher, publisher.topic.name, publisher.header, stamp, data)
        except BagError as error:
            publisher.topic.dropped += 1
            self._warn(str(error))
        if publisher.latching and self._options.repeat_latched:
            publisher.latched = data
            self._latching_publishers[publisher] = None

    def _split_if_due(self, stamp: int) -> bool:
        """Start a new file if this one has reached a limit; return False if the recording ends instead."""
        options, file = self._options, self._file
        assert file is not None
        is_split_due = bool(options.max_size and file.size > options.max_size)
        max_duration = int(options.max_duration * _NS_PER_S)
        self._file_started_at = min(self._file_started_at, stamp)  # simulated time may restart
        file_started_at = self._file_started_at
        if max_duration and stamp - file_started_at > max_duration:
            is_split_due = True
            file_started_at += (stamp - file_started_at - 1) // max_duration * max_duration
        if not is_split_due:
            return True
        if not options.split:
            return False
        if time.monotonic() >= self._retry_split_at and self._split():
            self._file_started_at = file_started_at
        return True

    def _split(self) -> bool:
        """Start the next file; if the process cannot open more files now, keep the current one and return False."""
        file = self._file
        assert file is not None
        try:
            next_file = self._open(self._file_number + 1)  # opened first, since there must always be a file to write to
        except OSError as error:
            if error.errno not in (errno.EMFILE, errno.ENFILE):
                raise
            self._retry_split_at = time.monotonic() + _SPLIT_RETRY_DELAY
            self._warn(f"Cannot start the next file ({error.strerror}); the recording continues in {file.path}.")
            return False
        try:
            self._close_file()
        except OSError:
            next_file.discard()
            raise
        self._file = next_file
        self._file_number += 1
        self._remove_oldest()
        self._events.on_opened(next_file.path)
        if self._options.repeat_latched:
            now = self._now()
            for publisher in self._latching_publishers:
                if publisher.latched is not None:
                    next_file.write(publisher, publisher.topic.name, publisher.header, now, publisher.latched)
        return True

    def _open(self, file_number: int) -> RecordFile[RecordedPublisher]:
        options = self._options
        path = options.names.name(file_number, time.time())
        file = RecordFile[RecordedPublisher](path, options.compression, options.chunk_size)
        if file.leftover_path:
            self._events.on_warning(
                f"{path}.active of a recording that was not closed was renamed to {file.leftover_path}; "
                "`pyros1 bag reindex` can repair it"
            )
        return file

    def _close_file(self) -> None:
        file, self._file = self._file, None
        if file is None:
            return
        self._events.on_closing(file.path)
        try:
            file.close()
        finally:
            for publisher, count in file.lost.items():
                publisher.topic.dropped += count
        with contextlib.suppress(OSError):
            self.report.bytes += os.path.getsize(file.path)
        self.report.files.append(file.path)
        self.report.messages += file.messages
        self._finished_paths.append(file.path)

    def _remove_oldest(self) -> None:
        if self._options.max_splits and len(self._finished_paths) > self._options.max_splits:
            with contextlib.suppress(OSError):
                os.remove(self._finished_paths.popleft())
