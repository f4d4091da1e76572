"""Converts messages from nodes for the site's state machine, in its own threads.

Converting an image takes too long for a node's thread, or with the state machine's lock held. So messages wait for a
free thread, but only each publisher's newest; older ones are dropped. Only messages that would be sent are converted.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable
from typing import NamedTuple, Protocol

from pyros1.bridge.conversions.conversion import Conversion
from pyros1.bridge.conversions.converters import Converter, converted_type
from pyros1.bridge.exchange.outgoing import DropReason, ReceivedMessage
from pyros1.ground.errors import Error

_THREADS = 2
_MAX_PUBLISHERS = 100
"""Maximum number of publishers of a topic whose messages may wait."""
_JOIN_TIME = 3.0
Source = tuple[str, Conversion]
"""A topic of this site's master, and how its messages are converted."""


class PendingMessage(NamedTuple):
    """A message to convert.

    Attributes:
        received: the message.
        type: the name of its type.
        is_bridged: whether a bridge has published it.
        at: when it arrived, in seconds of the site's clock.
    """

    received: ReceivedMessage
    type: str
    is_bridged: bool
    at: float


class ConversionSink(Protocol):
    """Receives the pool's results. Its methods are called in any thread, without the pool's lock."""

    def would_send(self, source: Source, pending: PendingMessage) -> bool:
        """Return whether a message would be sent after conversion; otherwise it counts as dropped."""
        ...

    def send(self, source: Source, pending: PendingMessage) -> None:
        """Handle a message that has been converted."""
        ...

    def drop(self, source: Source, publisher: str, reason: str) -> None:
        """Handle that a publisher's message is dropped, and count it."""
        ...


class _Work:
    """The waiting messages of a source. One thread at a time converts them."""

    def __init__(self) -> None:
        self.pending: dict[str, PendingMessage] = {}  # publisher -> its newest message
        self.converter: Converter | None = None
        self.type = ""  # the type that the converter accepts
        self.is_queued = False
        self.must_restart = False


class ConversionPool:
    """The threads that convert messages; they are started by the first message.

    Args:
        sink: receives the converted and dropped messages.
        on_mistake: called with unexpected exceptions, which are bugs in pyros1.

    Attributes:
        problems: topic -> why its last message could not be converted.
    """

    def __init__(self, sink: ConversionSink, on_mistake: Callable[[Exception], None]) -> None:
        self.problems: dict[str, str] = {}
        self._sink = sink
        self._on_mistake = on_mistake
        self._works: dict[Source, _Work] = {}
        self._queue: deque[tuple[Source, _Work]] = deque()
        self._has_work = threading.Condition()
        self._threads: list[threading.Thread] = []
        self._is_closing = False

    def start(self, source: Source) -> None:
        """Start accepting messages of a source."""
        with self._has_work:
            self._works[source] = _Work()

    def stop(self, source: Source) -> None:
        """Stop accepting messages of a source, and discard the waiting ones."""
        with self._has_work:
            self._works.pop(source, None)
            self.problems.pop(source[0], None)

    def restart(self, source: Source) -> None:
        """Make the next message decodable without earlier ones, for a new receiver."""
        with self._has_work:
            if source in self._works:
                self._works[source].must_restart = True

    def put(self, source: Source, pending: PendingMessage) -> None:
        """Queue a message for the threads. It replaces a waiting message of the same publisher."""
        publisher = pending.received.publisher
        with self._has_work:
            work = self._works.get(source)
            if work is None or self._is_closing:
                return
            problem = DropReason.OVERTAKEN if publisher in work.pending else ""
            if not problem and len(work.pending) >= _MAX_PUBLISHERS:
                problem = DropReason.PUBLISHERS
            else:
                work.pending[publisher] = pending
            self._enqueue(source, work)
        if problem:
            self._sink.drop(source, publisher, problem)

    def _enqueue(self, source: Source, work: _Work) -> None:
        """Assign a thread to a source, unless it has one."""
        if work.is_queued or not work.pending:
            return
        work.is_queued = True
        self._queue.append((source, work))
        if len(self._threads) < _THREADS:
            thread = threading.Thread(target=self._run, name="bridge: conversions", daemon=True)
            self._threads.append(thread)
            thread.start()
        self._has_work.notify()

    def _run(self) -> None:
        while True:
            with self._has_work:
                while not self._queue and not self._is_closing:
                    self._has_work.wait()
                if self._is_closing:
                    return
                source, work = self._queue.popleft()
                if self._works.get(source) is not work:
                    continue
                pending = work.pending.pop(next(iter(work.pending)))
                must_restart, work.must_restart = work.must_restart, False
            try:
                self._convert(source, work, pending, must_restart)
            except Exception as error:  # noqa: BLE001 - a bug must not end the thread silently
                self._on_mistake(error)
            with self._has_work:
                work.is_queued = False
                self._enqueue(source, work)

    def _convert(self, source: Source, work: _Work, pending: PendingMessage, must_restart: bool) -> None:
        topic, conversion = source
        received = pending.received
        try:
            new_type = converted_type(conversion, pending.type, received.md5sum)
            if new_type is None:
                self._sink.drop(source, received.publisher, DropReason.TYPE)
                return
            if work.converter is None or work.type != pending.type:
                work.converter, work.type = Converter(conversion, pending.type), pending.type
            if must_restart:
                work.converter.restart()
            if not self._sink.would_send(source, pending):
                return
            body = work.converter.convert(received.publisher, received.body, pending.at)
        except Error as error:
            with self._has_work:
                if self._works.get(source) is work:
                    self.problems[topic] = str(error)
            self._sink.drop(source, received.publisher, DropReason.UNCONVERTED)
            return
        if self.problems:
            with self._has_work:
                self.problems.pop(topic, None)
        self._sink.send(source, pending._replace(received=received._replace(md5sum=new_type.md5sum, body=body)))

    def close(self) -> None:
        """End the threads."""
        with self._has_work:
            self._is_closing = True
            self._works.clear()
            self._has_work.notify_all()
        for thread in self._threads:
            thread.join(_JOIN_TIME)
