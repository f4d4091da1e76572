"""Filters that form a chain: each receives messages from other filters and passes on its output."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from pyros1.filters.synchronizers import Recent, make_matcher, stamp_of
from pyros1.ground.timing import Time

if TYPE_CHECKING:
    from pyros1.node import Node


class Filter:
    """Base class of all filters: calls callbacks with its output.

    Attributes:
        node: the node whose time the filter uses.
    """

    def __init__(self, node: Node) -> None:
        self.node = node
        self._callbacks: list[Callable[..., object]] = []

    def connect(self, callback: Callable[..., object]) -> None:
        """Register a function to be called with all later output of the filter, one argument per message."""
        self._callbacks.append(callback)

    def emit(self, *messages: Any) -> None:
        """Output messages: call all callbacks with them, one argument per message."""
        for callback in self._callbacks:
            callback(*messages)


class Subscriber(Filter):
    """Outputs the messages of a topic.

    Args:
        node: the node that subscribes.
        topic: name of the topic.
        type: a message class, or the name of a type.
        options: further arguments of :meth:`pyros1.Node.subscribe`, such as ``queue_size``.
    """

    def __init__(self, node: Node, topic: str, type: Any, **options: Any) -> None:
        super().__init__(node)
        self._handle = node.subscribe(topic, type, self.emit, **options)

    def close(self) -> None:
        """Unsubscribe."""
        self._handle.unregister()


class Synchronizer(Filter):
    """Outputs sets of messages, one from each of several filters, with equal or nearly equal time stamps.

    When time jumps back, waiting messages are discarded.

    Args:
        inputs: the filters, which must output stamped messages.
        queue_size: maximum number of waiting messages per filter; beyond that, those with the oldest stamps are
            dropped.
        slop: the stamps in a set are less than this many seconds apart; None if the stamps must be equal.
        headerless: whether messages without a header are accepted, and stamped with their arrival time. Otherwise, such
            messages cause an error, which the node logs.
    """

    def __init__(
        self, inputs: Sequence[Filter], queue_size: int = 10, slop: float | None = None, headerless: bool = False
    ) -> None:
        if not inputs:
            raise ValueError("a synchronizer needs at least one filter")
        super().__init__(inputs[0].node)
        self._matcher = make_matcher(len(inputs), queue_size, slop)
        self._allow_headerless = headerless
        self._last_time = Time()
        self._lock = threading.RLock()  # a callback may add messages
        for index, input_filter in enumerate(inputs):
            input_filter.connect(lambda message, index=index: self.add(index, message))

    def add(self, index: int, message: Any) -> None:
        """Add a message from the filter with the given index; output the sets that the message completes.

        Raises:
            TypeError: the message has no header, and ``headerless`` is False.
        """
        with self._lock:  # held even while callbacks run, so that sets are output in order
            now = self.node.now()  # with the lock held, so that times do not decrease from call to call
            stamp = stamp_of(message, now if self._allow_headerless else None)
            if now < self._last_time:
                self._matcher.clear()
            self._last_time = now
            for messages in self._matcher.add(index, stamp, message):
                self.emit(*messages)


class Cache(Filter):
    """Keeps the newest messages of a filter, and passes on all messages.

    Args:
        source: the filter, which must output stamped messages.
        size: maximum number of messages to keep.
        headerless: see `Synchronizer`.
    """

    def __init__(self, source: Filter, size: int, headerless: bool = False) -> None:
        super().__init__(source.node)
        self._recent = Recent(size)
        self._allow_headerless = headerless
        self._lock = threading.RLock()
        source.connect(self.add)

    def add(self, message: Any) -> None:
        """Add a message and pass it on.

        Raises:
            TypeError: the message has no header, and ``headerless`` is False.
        """
        stamp = stamp_of(message, self.node.now() if self._allow_headerless else None)
        with self._lock:
            self._recent.add(stamp, message)
        self.emit(message)

    def between(self, first: Time, last: Time) -> list[Any]:
        """Return the messages with stamps from ``first`` to ``last``, both included, the oldest first."""
        with self._lock:
            return self._recent.between(first, last)

    def after(self, stamp: Time) -> Any:
        """Return the oldest message that is not older than a stamp; None if there is none."""
        with self._lock:
            return self._recent.after(stamp)

    def before(self, stamp: Time) -> Any:
        """Return the newest message that is not newer than a stamp; None if there is none."""
        with self._lock:
            return self._recent.before(stamp)

    @property
    def oldest(self) -> Time | None:
        """Stamp of the oldest message; None if there is none."""
        with self._lock:
            return self._recent.oldest

    @property
    def newest(self) -> Time | None:
        """Stamp of the newest message; None if there is none."""
        with self._lock:
            return self._recent.newest
