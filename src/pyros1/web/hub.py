"""One subscription per topic, shared by all views of all pages.

A message arrives in a thread of the node, undecoded; each listener decodes it if it needs to.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic
from typing import Any

from pyros1.ground.errors import Error
from pyros1.msgs import AnyMsg, Message
from pyros1.observe.decoder import Decoder

_MOST_LATCHED = 100
"""Most publishers of a topic whose latched messages are kept."""
Listener = Callable[["Arrival"], object]
"""Called with each message, in a thread of the node. It must be quick, and raises nothing."""


class Arrival:
    """A message that has come.

    Attributes:
        raw: its bytes and its connection's header.
        time: when it came, in seconds of the node's clock.
        at: when it came, in seconds of `time.monotonic`.
    """

    __slots__ = ("_decoder", "_message", "at", "raw", "time")

    def __init__(self, raw: AnyMsg, time: float, at: float, decoder: Decoder) -> None:
        self.raw = raw
        self.time = time
        self.at = at
        self._decoder = decoder
        self._message: Message | None = None

    @property
    def message_class(self) -> type[Message]:
        """The class of the message.

        Raises:
            MessageError: the publisher sent no usable definition.
        """
        return self._decoder.message_class(self.raw)

    @property
    def message(self) -> Message:
        """The decoded message; it is decoded once, whoever asks.

        Raises:
            MessageError: the publisher sent no usable definition, or the bytes are not such a message.
        """
        if self._message is None:
            self._message = self._decoder.decode(self.raw)
        return self._message


class Hub:
    """The subscriptions.

    To subscribe may take as long as the master is away. So a thread of its own does it, and nobody waits.

    Args:
        subscribe: subscribes to undecoded messages of a topic; returns a subscriber. It may raise Error.
        now: returns the time of the node's clock in seconds.
        start: runs a function that may wait.
    """

    def __init__(
        self,
        subscribe: Callable[[str, Callable[[AnyMsg], object]], Any],
        now: Callable[[], float],
        start: Callable[[Callable[[], None]], object] | None = None,
    ) -> None:
        self._subscribe = subscribe
        self._now = now
        self._begin = start or _in_a_thread
        self._lock = threading.Lock()
        self._feeds: dict[str, _Feed] = {}

    def listen(self, topic: str, listener: Listener) -> Callable[[], None]:
        """Call a listener with the messages of a topic from now on.

        Args:
            topic: the topic's full name.
            listener: see `Listener`.

        A topic that is latched has a message already; the listener is called with it at once, in this thread.

        Returns:
            A function that ends this. The listener may be called once more meanwhile.
        """
        with self._lock:
            known = self._feeds.get(topic)
            feed = self._feeds[topic] = known or _Feed(self._now)
            latched = feed.join(listener)  # before the first message can come
        if known is None:
            self._begin(lambda: self._open(topic, feed))
        for arrival in latched:
            listener(arrival)
        return lambda: self._leave(topic, feed, listener)

    def _open(self, topic: str, feed: _Feed) -> None:
        try:
            feed.begun(self._subscribe(topic, feed.arrived))
        except Error:  # the node has ended, or the topic's name is not legal
            with self._lock:
                if self._feeds.get(topic) is feed:
                    del self._feeds[topic]

    def _leave(self, topic: str, feed: _Feed, listener: Listener) -> None:
        with self._lock:
            if feed.leave(listener) or self._feeds.get(topic) is not feed:
                return
            del self._feeds[topic]
        feed.end()

    def close(self) -> None:
        """End all subscriptions."""
        with self._lock:
            feeds, self._feeds = list(self._feeds.values()), {}
        for feed in feeds:
            feed.end()


def _in_a_thread(work: Callable[[], None]) -> None:
    threading.Thread(target=work, name="web: subscribes", daemon=True).start()


class _Feed:
    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._decoder = Decoder()
        self._lock = threading.Lock()
        self._latched: dict[str, Arrival] = {}  # by publisher, the newest at the end
        self._listeners: tuple[Listener, ...] = ()
        self._subscriber: Any = None
        self._ended = False

    def begun(self, subscriber: Any) -> None:
        """Take the subscriber, or end it if nobody listens any more."""
        with self._lock:
            if not self._ended:
                self._subscriber = subscriber
                return
        subscriber.unregister()

    def end(self) -> None:
        """Listen no more."""
        with self._lock:
            self._ended, self._listeners = True, ()
            subscriber, self._subscriber = self._subscriber, None
        if subscriber is not None:
            subscriber.unregister()

    def join(self, listener: Listener) -> list[Arrival]:
        """Add a listener; return the latched messages of publishers that are there, which it has not seen."""
        with self._lock:
            self._listeners = (*self._listeners, listener)
            if self._latched and self._subscriber is not None:
                here = {link.header.get("callerid", "") for link in self._subscriber.links if link.header}
                self._latched = {name: each for name, each in self._latched.items() if name in here}
            return list(self._latched.values())

    def leave(self, listener: Listener) -> bool:
        """Remove a listener; return whether there are others, or it was not one."""
        with self._lock:
            left = tuple(each for each in self._listeners if each is not listener)
            was_here = len(left) < len(self._listeners)
            self._listeners = left
            return bool(left) or not was_here

    def arrived(self, raw: AnyMsg) -> None:
        arrival = Arrival(raw, self._now(), monotonic(), self._decoder)
        header = raw._connection_header or {}
        with self._lock:
            listeners = self._listeners
            if header.get("latching") == "1":
                self._latched.pop(header.get("callerid", ""), None)
                while len(self._latched) >= _MOST_LATCHED:
                    del self._latched[next(iter(self._latched))]
                self._latched[header.get("callerid", "")] = arrival
        for listener in listeners:
            listener(arrival)
