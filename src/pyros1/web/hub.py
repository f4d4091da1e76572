"""One subscription per topic, shared by all views of all pages.

A message arrives in a thread of the node, undecoded; each listener decodes it if it needs to.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from time import monotonic
from typing import Any

from pyros1.msgs import AnyMsg, Message
from pyros1.observe.decoder import Decoder

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

    Args:
        subscribe: subscribes to undecoded messages of a topic; returns a subscriber.
        now: returns the time of the node's clock in seconds.
    """

    def __init__(self, subscribe: Callable[[str, Callable[[AnyMsg], object]], Any], now: Callable[[], float]) -> None:
        self._subscribe = subscribe
        self._now = now
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
            feed = known or _Feed(self._now)
            latched = feed.join(listener)  # before the first message can come
            if known is None:
                feed.subscriber = self._subscribe(topic, feed.arrived)
                self._feeds[topic] = feed
        for arrival in latched:
            listener(arrival)
        return lambda: self._leave(topic, feed, listener)

    def _leave(self, topic: str, feed: _Feed, listener: Listener) -> None:
        with self._lock:
            if listener not in feed.listeners:
                return
            feed.leave(listener)
            if feed.listeners or self._feeds.get(topic) is not feed:
                return
            del self._feeds[topic]
            feed.subscriber.unregister()

    def close(self) -> None:
        """End all subscriptions."""
        with self._lock:
            feeds, self._feeds = list(self._feeds.values()), {}
        for feed in feeds:
            feed.listeners = ()
            feed.subscriber.unregister()


class _Feed:
    def __init__(self, now: Callable[[], float]) -> None:
        self._now = now
        self._decoder = Decoder()
        self._lock = threading.Lock()
        self._latched: dict[str, Arrival] = {}  # by publisher
        self.listeners: tuple[Listener, ...] = ()
        self.subscriber: Any = None

    def join(self, listener: Listener) -> list[Arrival]:
        """Add a listener; return the latched messages, which it has not seen."""
        with self._lock:
            self.listeners = (*self.listeners, listener)
            return list(self._latched.values())

    def leave(self, listener: Listener) -> None:
        """Remove a listener."""
        with self._lock:
            self.listeners = tuple(each for each in self.listeners if each is not listener)

    def arrived(self, raw: AnyMsg) -> None:
        arrival = Arrival(raw, self._now(), monotonic(), self._decoder)
        header = raw._connection_header or {}
        with self._lock:
            listeners = self.listeners
            if header.get("latching") == "1":
                self._latched[header.get("callerid", "")] = arrival
        for listener in listeners:
            listener(arrival)
