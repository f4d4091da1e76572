"""The subscription: one per topic and node; the users' handles are in ``subscriber.py``.

Several subscribers of one topic in a node share its links and its thread, as in rospy and roscpp: a publisher sees one
connection per node. https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sized
from typing import TYPE_CHECKING, Any, Protocol

from pyros1.ground.errors import LengthError, MessageError, NodeError
from pyros1.msgs.large_arrays import layout
from pyros1.node.log.levels import ERROR, WARN
from pyros1.node.subscribing.connector import Connector
from pyros1.node.subscribing.delivery import Delivery
from pyros1.node.subscribing.drivers import StreamState
from pyros1.node.subscribing.hints import Hints
from pyros1.node.subscribing.sources import InboxSource, Item, Source
from pyros1.node.subscribing.tcp_source import MIN_LARGE_FRAME, TcpSource
from pyros1.node.topic_type import topic_type
from pyros1.wire.handshake import ANY, subscriber_header

if TYPE_CHECKING:
    from pyros1.node.context import Context, PublicationView
    from pyros1.node.subscribing.drivers import Driver
    from pyros1.node.subscribing.udp_source import UdpSource


class Stream(StreamState, Protocol):
    """A subscriber's own queue."""

    def put(self, source: Source, item: Item) -> None:
        """Accept a message. One thread at a time."""


class SubscriberCallback(Protocol):
    """The part of a subscriber that a subscription needs; see `subscriber.Subscriber`.

    Attributes:
        direct: whether the callback runs in the thread that receives, even in a node that spins.
        in_publisher: whether it runs in the thread of a publisher of this process.
        stream: receives the messages undecoded, in place of a callback.
        made: class of messages that need not be converted for the callback; None: all must be converted.
    """

    made: type[Any] | None
    type: type[Any]
    queue_size: int | None
    direct: bool
    in_publisher: bool
    stream: Stream | None
    decode: Callable[..., Any]

    def take(self, item: Item, exact: bool = False) -> Any:
        """Return the message of an item; see `subscriber.Subscriber.take`."""

    def call(self, message: Any) -> None:
        """Run the callback."""


class Subscription:
    """A topic that a node subscribes to, with its links to publishers.

    Args:
        context: the node.
        topic: full name.
        message_class: of the first subscriber; AnyMsg accepts every type.
        hints: transports and options for links to publishers.
        driver: receives while all subscribers are streams that drop nothing; None: the node's threads.
    """

    def __init__(
        self, context: Context, topic: str, message_class: type[Any], hints: Hints, driver: Driver | None = None
    ) -> None:
        self.context = context
        self.topic = topic
        self.type = topic_type(message_class)
        self.subscribers: tuple[SubscriberCallback, ...] = ()
        self.on_change: list[Callable[[], None]] = []
        self.hints = hints
        self._connectors: dict[str, Connector] = {}  # loop only
        self._in_links: tuple[TcpSource, ...] = ()
        self._local_links: tuple[InboxSource, ...] = ()
        self._latched: dict[int, tuple[Source, Item]] = {}  # as delivered
        self._early_latched: dict[int, tuple[Source, Item]] = {}  # in a node that spins: as arrived
        self._lock = threading.RLock()  # a signal handler may end the node on top of a method of this object
        self._closed = False
        self._direct: tuple[SubscriberCallback, ...] = ()
        # Those of both that have received the latched messages, and now receive all further messages.
        self._active: tuple[SubscriberCallback, ...] = ()
        self._active_direct: tuple[SubscriberCallback, ...] = ()
        self._streams: tuple[Stream, ...] = ()
        self.delivery = Delivery(
            driver or context.delivery_threads,
            self._deliver,
            self._deliver_item,
            self._link_lost,
            self._on_arrival,
            context.callbacks,
        )

    # Subscribers ------------------------------------------------------------------------------------------------------

    def add(self, subscriber: SubscriberCallback) -> None:
        """Add a subscriber and give it earlier latched messages (T18).

        Raises:
            NodeError: this node already subscribes to the topic with another type.
        """
        requested_type = topic_type(subscriber.type)
        with self._lock:
            if ANY not in (requested_type.md5sum, self.type.md5sum) and requested_type.md5sum != self.type.md5sum:
                raise NodeError(
                    f"this node already subscribes to {self.topic} as {self.type.name}, not as {requested_type.name}"
                )
            if self.type.md5sum == ANY:
                self.type = requested_type
            if subscriber.direct and self.context.callbacks is not None:
                self._direct = (*self._direct, subscriber)
            else:
                self.subscribers = (*self.subscribers, subscriber)
            self._set_limit()
        stream = subscriber.stream
        busy = stream is None or stream.wants_newest  # a callback may wait
        if busy and self.delivery.driver.cooperative:
            self.delivery.submit(lambda: self.delivery.links.move(self.context.delivery_threads))
        self.delivery.submit(lambda: self._activate(subscriber), by_callback=True)

    def remove(self, subscriber: SubscriberCallback) -> bool:
        """Remove a subscriber; return whether any is left."""
        with self._lock:
            self.subscribers = tuple(other for other in self.subscribers if other is not subscriber)
            self._direct = tuple(other for other in self._direct if other is not subscriber)
            self._active = tuple(other for other in self._active if other is not subscriber)
            self._active_direct = tuple(other for other in self._active_direct if other is not subscriber)
            self._set_streams(tuple(other for other in self._streams if other is not subscriber.stream))
            self._set_limit()
        return bool(self.subscribers or self._direct)

    def _activate(self, subscriber: SubscriberCallback) -> None:
        """Deliver the latched messages to a subscriber, and from now on all others. Called by the delivery's owner."""
        with self._lock:
            early = subscriber.direct and self.context.callbacks is not None
            latched = list((self._early_latched if early else self._latched).values())
            if subscriber in self.subscribers and subscriber.stream is not None:
                self._set_streams((*self._streams, subscriber.stream))
            elif subscriber in self.subscribers:
                self._active = (*self._active, subscriber)
            elif subscriber in self._direct:
                self._active_direct = (*self._active_direct, subscriber)
        self._replay(subscriber, latched)

    def _set_streams(self, streams: tuple[Stream, ...]) -> None:
        self._streams = self.delivery.streams = streams
        self.delivery.wake()  # the subscriber that held publishers back may be gone

    def limit_changed(self) -> None:
        """Apply the new limit of a subscriber."""
        with self._lock:
            self._set_limit()

    def _set_limit(self) -> None:
        """Set how many messages may wait: the links are shared, so the largest limit of the subscribers applies.

        Streams limit themselves. Messages are delivered in the publisher's thread if all callbacks to be run want that.
        """
        sizes = [subscriber.queue_size for subscriber in self.subscribers]
        no_limit = None in sizes or all(subscriber.stream is not None for subscriber in self.subscribers)
        self.delivery.limit = None if no_limit else max(size for size in sizes if size is not None)
        run = self._direct if self.context.callbacks is not None else self.subscribers
        self.delivery.in_publisher = bool(run) and all(subscriber.in_publisher for subscriber in run)

    # Publishers -------------------------------------------------------------------------------------------------------

    def request_header(self) -> dict[str, str]:
        """Return the connection header that is sent to publishers."""
        return subscriber_header(self.context.name, self.topic, self.type, self.hints.tcp_nodelay)

    def update_publishers(self, uris: list[str], complete: bool = True) -> None:
        """Apply the master's list of publishers. On the loop.

        Args:
            uris: slave API URIs.
            complete: whether publishers that are not in the list are gone. (The answer to a registration may be older
                than an update that overtook it, so it only adds.)
        """
        if self._closed:
            return
        for uri in uris:
            if uri not in self._connectors:
                self._connectors[uri] = Connector(self, uri)
            self._connectors[uri].publisher_listed()
        if complete:
            listed = set(uris)  # there may be a thousand
            for uri in [uri for uri in self._connectors if uri not in listed]:
                self._connectors[uri].publisher_unlisted()

    def has_publisher(self, uri: str) -> bool:
        """Whether this is a publisher that the master has listed. On the loop."""
        return uri in self._connectors

    def forget(self, uri: str) -> None:
        """Remove the connector of a publisher, as it has nothing left to do. On the loop."""
        connector = self._connectors.get(uri)
        if connector is not None and connector.is_finished:
            del self._connectors[uri]

    def link(self, link: TcpSource) -> None:
        """Add the link of a connector that has reached its publisher. On the loop."""
        if self._closed:
            link.close()
            return
        link.spins = self.hints.low_latency
        with self._lock:
            self._in_links = (*self._in_links, link)
        self.delivery.add(link)
        self._changed()

    def link_local(self, uri: str, publication: PublicationView) -> None:
        """Link to a publication of this process. On the loop.

        Raises:
            Refusal: it is of another type.
        """
        self.add_local(publication.connect_local(self.delivery, uri, self.request_header(), self._local_closed))

    def offer_datagrams(self, uri: str) -> UdpSource:
        """Return a UDP socket to offer to a publisher; see `add_local`. On the loop.

        Raises:
            OSError: no socket can be opened.
        """
        from pyros1.node.subscribing.udp_source import UdpSource  # noqa: PLC0415 - few nodes need it

        context, header, size = self.context, self.request_header(), self.hints.max_datagram_size
        assert context.address is not None
        return UdpSource(
            context.loop, self.delivery, header, uri, context.address, context.allowlist, size, self._local_closed
        )

    def add_local(self, link: InboxSource) -> None:
        """Add a link that puts messages into an inbox. On the loop."""
        with self._lock:
            if link.connected:  # not if the publisher has ended meanwhile, on its own thread
                self._local_links = (*self._local_links, link)
        self._changed()

    def _local_closed(self, link: InboxSource) -> None:
        """Note that a link that puts messages into an inbox has ended. Any thread."""
        with self._lock:
            self._local_links = tuple(other for other in self._local_links if other is not link)
        self.delivery.submit(lambda: self._ended(link))
        self.context.loop.call_soon(self._reconnect, link.uri, None)
        self._changed()

    def _ended(self, link: InboxSource) -> None:
        self._forget(link)
        self.delivery.forget(link)

    def _forget(self, source: Source) -> None:
        self._latched.pop(id(source), None)
        self._early_latched.pop(id(source), None)

    def _link_lost(self, link: TcpSource, reason: str | None) -> None:
        with self._lock:
            self._in_links = tuple(other for other in self._in_links if other is not link)
        self._forget(link)
        self.context.loop.call_soon(self._reconnect, link.uri, reason)
        self._changed()

    def _reconnect(self, uri: str, reason: str | None) -> None:
        connector = self._connectors.get(uri)
        if connector is None or self._closed:
            return
        connector.link_lost(reason)

    def _changed(self) -> None:
        for callback in tuple(self.on_change):
            callback()

    @property
    def links(self) -> tuple[TcpSource | InboxSource, ...]:
        """The open links."""
        return self._in_links + self._local_links

    # Messages, on the reader thread or the one that spins -------------------------------------------------------------

    def _on_arrival(self, source: Source, item: Item) -> bool:
        """Call the subscribers that do not wait for `spin`, in a node that spins; return whether others do."""
        if source.header.get("latching") == "1" and source.connected:
            self._early_latched[id(source)] = (source, item)
        if self._active_direct:
            self._call(self._active_direct, source, item)
        return bool(self.subscribers)

    def _deliver(self, source: Source, data: bytes, start: int, end: int) -> None:
        active = self._active
        if source.header.get("latching") == "1":
            active = self._keep_latched(source, data[start:end])
        if self._streams:
            self._put_into_streams(source, data[start:end])
        self._call(active, source, data, start, end)

    def _deliver_item(self, source: Source, item: Item) -> None:
        active, header = self._active, source.header
        if header.get("latching") == "1":
            active = self._keep_latched(source, item)
        if self._streams:
            self._put_into_streams(source, item)
        if len(active) == 1 and item.__class__ is active[0].made:  # most often, within a process
            message: Any = item
            message._connection_header = header
            active[0].call(message)
            return
        self._call(active, source, item)

    def _put_into_streams(self, source: Source, item: Item) -> None:
        for stream in self._streams:
            stream.put(source, item)

    def _keep_latched(self, source: Source, item: Item) -> tuple[SubscriberCallback, ...]:
        """Keep a latched message for later subscribers; return the subscribers that receive it now."""
        with self._lock:
            if source.connected:  # not a message that was still queued when its publisher left
                self._latched[id(source)] = (source, item)
            return self._active

    def _call(
        self, subscribers: tuple[SubscriberCallback, ...], source: Source, data: Any, start: int = 0, end: int = -1
    ) -> None:
        """Run the callbacks.

        Args:
            data: a buffer with a frame's body from ``start`` to ``end``; or an item, if ``end`` is -1.
        """
        header = source.header
        message = made_by = None
        for subscriber in subscribers:
            if subscriber.decode is not made_by or message is None:
                try:
                    message = subscriber.decode(data, start, end, True) if end >= 0 else subscriber.take(data, True)
                except LengthError as error:
                    self._warn_wrong_length(source, error)
                    message = subscriber.decode(data, start, end) if end >= 0 else subscriber.take(data)
                except MessageError as error:
                    self._log_undecodable(source, error)
                    continue
                message._connection_header = header
                made_by = subscriber.decode
                if end - start >= MIN_LARGE_FRAME:
                    _expect_array(source, message, end - start)
                elif end < 0 and isinstance(data, bytes) and len(data) >= MIN_LARGE_FRAME:
                    _expect_array(source, message, len(data))
            subscriber.call(message)

    def message(self, subscriber: SubscriberCallback, source: Source, item: Item) -> Any:
        """Return the message that a stream received; None, after logging it, if it cannot be decoded."""
        try:
            message = subscriber.take(item, exact=True)
        except LengthError as error:
            self._warn_wrong_length(source, error)
            message = subscriber.take(item)
        except MessageError as error:
            self._log_undecodable(source, error)
            return None
        message._connection_header = source.header
        if isinstance(item, bytes) and len(item) >= MIN_LARGE_FRAME:
            _expect_array(source, message, len(item))
        return message

    def _log_undecodable(self, source: Source, error: MessageError) -> None:
        who = source.header.get("callerid", "?")
        self.context.log.peer(ERROR, "%s from %s: %s (message dropped)", self.topic, who, error)

    def _warn_wrong_length(self, source: Source, error: LengthError) -> None:
        """Log that messages do not end where they should. They are received nevertheless, like in stock nodes."""
        who = source.header.get("callerid", "?")
        text = "%s from %s: received %s: is its definition different, or does it append a checksum?"
        self.context.log.peer(WARN, text, self.topic, who, error, max_texts=1, link=(self.topic, who))

    def _replay(self, subscriber: SubscriberCallback, latched: list[tuple[Source, Item]]) -> None:
        for source, item in latched:
            if subscriber.stream is not None:
                subscriber.stream.put(source, item)
                continue
            try:
                message = subscriber.take(item)
            except MessageError:
                continue  # was logged when it came
            message._connection_header = source.header
            if self.context.callbacks is not None and not subscriber.direct:
                self.context.callbacks.push(lambda message=message: subscriber.call(message))  # type: ignore[misc]
            else:
                subscriber.call(message)

    def close(self, timeout: float = 5.0, wait: bool = True) -> None:
        """End all links; wait for a running callback at most ``timeout`` seconds, or not at all."""
        self._closed = True
        self.context.loop.call_soon(self._stop_connectors)
        for link in self._local_links:
            link.close()
        self.delivery.close(timeout, wait)
        with self._lock:
            self._in_links = ()
        self._changed()

    def _stop_connectors(self) -> None:
        for connector in list(self._connectors.values()):
            connector.stop()
        self._connectors.clear()


def _expect_array(source: Source, message: Any, size: int) -> None:
    """Record for a link where the array of a large message was in its frame."""
    where = layout(type(message))
    if where is not None and isinstance(source, TcpSource):
        array = getattr(message, where.field, None)
        if isinstance(array, Sized) and len(array) >= MIN_LARGE_FRAME:  # a program's own class may hold anything there
            source.expect(size, len(array), where.tail, where.has_length_field)
