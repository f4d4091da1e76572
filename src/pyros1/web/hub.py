"""One subscription per topic, shared by all views of all pages.

Messages arrive undecoded, in the node's threads; a listener that needs a message's fields decodes it.
"""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable
from contextlib import suppress
from functools import lru_cache
from time import monotonic
from typing import Any

import numpy as np

from pyros1.ground.errors import Error, MessageError
from pyros1.ground.terminal_text import untrusted
from pyros1.msgs import AnyMsg, Message, load_message
from pyros1.msgs.array_views import make_numpy_view
from pyros1.observe.decoder import Decoder
from pyros1.web.server.threads import ThreadPool

_MAX_LATCHED = 100
"""Maximum number of publishers per topic whose latched messages are kept."""
MAX_KEPT_BYTES = 32 << 20
"""Maximum total size in bytes of the messages from one publisher that are queued for slow listeners, and of the latched
messages kept per topic. At least one message is kept, whatever its size."""
_LINK_GRACE_PERIOD = 1.0
"""Seconds after a message's arrival during which its connection might not be listed yet, if publisher and subscriber
are in the same process."""
_MAX_CONCURRENT_SUBSCRIBES = 16
"""Maximum number of concurrent attempts to subscribe; further attempts wait."""
_numpy_view = make_numpy_view(np)
Listener = Callable[["Arrival"], object]
"""Called with each message, in one of the node's threads. It must return quickly, and must not raise an error."""


class Arrival:
    """A received message.

    Attributes:
        raw: the undecoded message, with the header of its connection.
        time: time of reception in seconds, by the node's clock.
        arrived_at: time of reception in seconds, as returned by `time.monotonic`.
    """

    __slots__ = ("_arrays", "_class", "_decoder", "_message", "arrived_at", "raw", "time")

    def __init__(self, raw: AnyMsg, time: float, arrived_at: float, decoder: Decoder) -> None:
        self.raw = raw
        self.time = time
        self.arrived_at = arrived_at
        self._decoder = decoder
        self._class: type[Message] | None = None
        self._message: Message | None = None
        self._arrays: Message | None = None

    @property
    def message_class(self) -> type[Message]:
        """The class of the message, made from the definition that the publisher sent.

        Raises:
            MessageError: the publisher sent no usable definition.
        """
        if self._class is None:
            self._class = self._decoder.message_class(self.raw)
        return self._class

    @property
    def has_class(self) -> bool:
        """Whether `message_class` is available without first creating it, which can take a second."""
        if self._class is None:
            self._class = self._decoder.cached_class(self.raw)
        return self._class is not None

    @property
    def message(self) -> Message:
        """The message, which is decoded only once.

        Raises:
            MessageError: the publisher sent no usable definition, or the bytes are not a message of its type.
        """
        if self._message is None:
            self._message = self._decoder.decode(self.raw)
        return self._message

    @property
    def checked_message(self) -> Message:
        """The decoded message, after a check that it has all fields of the type that is installed here.

        Raises:
            MessageError: see `message`; or a field of the installed type is missing or has another type; or
                the type is not installed.
        """
        self._check_fields()
        return self.message

    @property
    def arrays(self) -> Message:
        """The decoded message, with arrays of numbers as numpy arrays, which need no more memory than the raw bytes.

        Raises:
            MessageError: see `checked_message`.
        """
        if self._arrays is None:
            self._check_fields()
            self._arrays = self.message_class._decode_arrays(self.raw._buff, 0, len(self.raw._buff), _numpy_view)
        return self._arrays

    def _check_fields(self) -> None:
        cls = self.message_class
        if not _has_installed_fields(cls):
            raise MessageError(f"its publisher has a different definition of {untrusted(cls._type)} than this machine")


@lru_cache(1_000)
def _has_installed_fields(cls: type[Message]) -> bool:
    """Return whether a received class has all fields of the class of the same name that is installed here.

    Comparing checksums is not enough: they are the same whether a field contains a message or an array of such
    messages.
    """
    classes = (cls, load_message(cls._type))
    fields, installed = (dict(zip(each.__slots__, each._slot_types, strict=True)) for each in classes)
    nested = [
        cls._classes[base]
        for field_type in installed.values()
        if (base := field_type.partition("[")[0]) in cls._classes
    ]
    return installed.items() <= fields.items() and all(map(_has_installed_fields, nested))


class Hub:
    """The subscriptions that all views share.

    Subscribing may block as long as the master is unreachable, so it is done in other threads.

    Args:
        subscribe: subscribes a callback to the undecoded messages on a topic, and returns the subscriber; may raise
            Error.
        now: returns the time of the node's clock, in seconds.
        submit: runs a function that may block. If this argument is None, such functions run in a pool of threads.
        wait_for_publishers: waits briefly until the registered publishers of a topic are connected; called with the
            topic and the subscriber.
    """

    def __init__(
        self,
        subscribe: Callable[[str, Callable[[AnyMsg], object]], Any],
        now: Callable[[], float],
        submit: Callable[[Callable[[], None]], object] | None = None,
        wait_for_publishers: Callable[[str, Any], object] = lambda topic, subscriber: None,
    ) -> None:
        self._subscribe = subscribe
        self._wait_for_publishers = wait_for_publishers
        self._now = now
        self._threads = ThreadPool(_MAX_CONCURRENT_SUBSCRIBES, "web: subscribes")
        self._submit = submit or self._threads.submit
        self._lock = threading.Lock()
        self._feeds: dict[str, _Feed] = {}

    def listen(
        self, topic: str, listener: Listener, on_ready: Callable[[], object] | None = None
    ) -> Callable[[], None]:
        """Call a listener with each message on a topic from now on.

        If latched messages are available, the listener is called with them immediately, in this thread.

        Args:
            topic: the topic's full name.
            listener: see `Listener`.
            on_ready: called once, from any thread, when the subscription exists and its publishers are connected, or
                when subscribing has failed.

        Returns:
            A function that removes the listener. While this function runs, the listener may still be called once.
        """
        with self._lock:
            existing_feed = self._feeds.get(topic)
            feed = self._feeds[topic] = existing_feed or _Feed(self._now)
            token, late_listener = feed.add_listener(listener)  # before the first message can arrive
        if on_ready is not None:
            feed.call_when_ready(on_ready)
        if existing_feed is None:
            self._submit(lambda: self._open_feed(topic, feed))
        if late_listener is not None:
            late_listener.catch_up()
        return lambda: self._remove_listener(topic, feed, token)

    def _open_feed(self, topic: str, feed: _Feed) -> None:
        try:
            subscriber = self._subscribe(topic, feed.on_message)
            if feed.set_subscriber(subscriber):
                with suppress(Error):  # the master became unreachable meanwhile
                    self._wait_for_publishers(topic, subscriber)
        except Error:  # the node has shut down, or the topic's name is invalid
            with self._lock:
                if self._feeds.get(topic) is feed:
                    del self._feeds[topic]
        finally:
            feed.set_ready()

    def _remove_listener(self, topic: str, feed: _Feed, token: object) -> None:
        with self._lock:
            if not feed.remove_listener(token) or self._feeds.get(topic) is not feed:
                return
            del self._feeds[topic]
        feed.end()

    def close(self) -> None:
        """End all subscriptions."""
        with self._lock:
            feeds, self._feeds = list(self._feeds.values()), {}
        for feed in feeds:
            feed.end()
        self._threads.shutdown(wait=False, cancel_futures=True)


class _LateListener:
    """Passes latched messages to a listener first; messages that arrive meanwhile in other threads have to wait.

    Args:
        listener: the listener.
        latched: the latched messages.
    """

    def __init__(self, listener: Listener, latched: Iterable[Arrival]) -> None:
        self._listener = listener
        self._lock = threading.Lock()
        self._queue: deque[Arrival] | None = deque(latched)

    def __call__(self, arrival: Arrival) -> None:
        with self._lock:
            if self._queue is not None:
                self._queue.append(arrival)
                return
        self._listener(arrival)

    def catch_up(self) -> None:
        """Call the listener with all queued messages; later messages are passed on immediately."""
        while True:
            with self._lock:
                if not self._queue:
                    self._queue = None
                    return
                arrival = self._queue.popleft()
            self._listener(arrival)


class _Feed:
    """The subscription to one topic, and its listeners."""

    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._decoder = Decoder()
        self._lock = threading.Lock()
        self._latched: dict[str, Arrival] = {}  # by publisher, the newest last
        self._listeners: dict[object, Listener] = {}
        self._listeners_snapshot: tuple[Listener, ...] | None = ()  # all listeners; None if they have changed
        self._subscriber: Any = None
        self._largest_size = 0
        self._ended = self._is_ready = False
        self._ready_callbacks: list[Callable[[], object]] = []

    def set_subscriber(self, subscriber: Any) -> bool:
        """Store the subscriber and return True; if no listeners are left, close the subscriber and return False."""
        with self._lock:
            if not self._ended:
                self._subscriber = subscriber
                self._limit_queue()
                return True
        subscriber.unregister()
        return False

    def call_when_ready(self, on_ready: Callable[[], object]) -> None:
        """Call a function when `set_ready` is called, or now if it has already been called."""
        with self._lock:
            if not self._is_ready:
                self._ready_callbacks.append(on_ready)
                return
        on_ready()

    def set_ready(self) -> None:
        """Record that the subscription exists or has failed, and call the functions that wait for this."""
        with self._lock:
            self._is_ready = True
            callbacks, self._ready_callbacks = self._ready_callbacks, []
        for on_ready in callbacks:
            on_ready()

    def end(self) -> None:
        """End the subscription, and remove all listeners."""
        with self._lock:
            self._ended, self._listeners, self._listeners_snapshot = True, {}, ()
            subscriber, self._subscriber = self._subscriber, None
        if subscriber is not None:
            subscriber.unregister()
        self.set_ready()

    def _limit_queue(self) -> None:
        """Shorten the subscriber's queue if messages are large."""
        max_messages = MAX_KEPT_BYTES // max(1, self._largest_size)
        if self._subscriber is not None and max_messages < self._subscriber.queue_size:
            self._subscriber.set_queue_size(max(1, max_messages))

    def add_listener(self, listener: Listener) -> tuple[object, _LateListener | None]:
        """Add a listener. Return a token for `remove_listener`, and an object that passes latched messages to the
        listener if there are any.
        """
        token = object()
        with self._lock:
            if self._latched and self._subscriber is not None:
                headers = [link.header for link in self._subscriber.links if link.header]
                publishers = {header.get("callerid", "") for header in headers}
                grace_period_start = monotonic() - _LINK_GRACE_PERIOD
                self._latched = {
                    name: arrival
                    for name, arrival in self._latched.items()  # each connection has its own header object
                    if any(header is arrival.raw._connection_header for header in headers)
                    or (name not in publishers and arrival.arrived_at > grace_period_start)
                }
            late_listener = _LateListener(listener, self._latched.values()) if self._latched else None
            self._listeners[token] = late_listener or listener
            self._listeners_snapshot = None
            return token, late_listener

    def remove_listener(self, token: object) -> bool:
        """Remove a listener by its token; return whether it was the last one."""
        with self._lock:
            was_listening = self._listeners.pop(token, None) is not None
            self._listeners_snapshot = None
            return was_listening and not self._listeners

    def on_message(self, raw: AnyMsg) -> None:
        arrival = Arrival(raw, self._now(), monotonic(), self._decoder)
        header = raw._connection_header or {}
        with self._lock:
            if self._listeners_snapshot is None:
                self._listeners_snapshot = tuple(self._listeners.values())
            listeners = self._listeners_snapshot
            if len(raw._buff) > self._largest_size:
                self._largest_size = len(raw._buff)
                self._limit_queue()
            if header.get("latching") == "1":
                self._store_latched(header.get("callerid", ""), arrival)
        for listener in listeners:
            listener(arrival)

    def _store_latched(self, publisher: str, arrival: Arrival) -> None:
        self._latched.pop(publisher, None)
        self._latched[publisher] = arrival
        size = sum(len(latched.raw._buff) for latched in self._latched.values())
        while len(self._latched) > _MAX_LATCHED or (size > MAX_KEPT_BYTES and len(self._latched) > 1):
            size -= len(self._latched.pop(next(iter(self._latched))).raw._buff)
