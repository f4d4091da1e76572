"""Subscribing: one Subscription per topic and node; the users' handles are in ``subscriber.py``.

Several subscribers of one topic in a node share its links and its thread, as in rospy and roscpp: a publisher sees one
connection per node. https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

from pyros1.errors import MessageError, NodeError
from pyros1.msgs.large import layout
from pyros1.node.connector import Connector
from pyros1.node.inlink import LARGE, InLink
from pyros1.node.log import ERROR
from pyros1.node.publisher import topic_type
from pyros1.node.reader import Reader
from pyros1.node.sources import Item, Source
from pyros1.wire.handshake import ANY, subscriber_header

if TYPE_CHECKING:
    from pyros1.node.context import Context
    from pyros1.node.datagrams import DatagramInLink
    from pyros1.node.local import LocalLink
    from pyros1.node.publication import Publication
    from pyros1.node.subscriber import Subscriber


class Hints(NamedTuple):
    """How a subscriber wants to be linked to publishers (roscpp's TransportHints, C11).

    Attributes:
        tcp_nodelay: ask publishers to send small messages at once.
        transports: "tcp" and "udp", in the order of preference.
        max_datagram_size: in bytes, for "udp".
    """

    tcp_nodelay: bool = True
    transports: tuple[str, ...] = ("tcp",)
    max_datagram_size: int = 1500

    def check(self) -> None:
        """Raise ValueError for a transport or size that there is not."""
        if not hasattr(type(self.max_datagram_size), "__index__"):
            raise TypeError(f"max_datagram_size must be a whole number of bytes, not {self.max_datagram_size!r:.80}")
        if self.transports == ("tcp",):
            return
        from pyros1.wire.datagram import LARGEST_SIZE, SMALLEST_SIZE  # noqa: PLC0415 - few nodes need it

        if not self.transports or not set(self.transports) <= {"tcp", "udp"}:
            raise ValueError(f"transports must be 'tcp', 'udp' or both, not {self.transports!r}")
        if not SMALLEST_SIZE <= self.max_datagram_size <= LARGEST_SIZE:
            sizes = f"{SMALLEST_SIZE} to {LARGEST_SIZE}"
            raise ValueError(f"max_datagram_size must be {sizes}, not {self.max_datagram_size}")


class Subscription:
    """A topic that a node subscribes to, with its links to publishers.

    Args:
        context: the node.
        topic: full name.
        message_class: of the first subscriber; AnyMsg takes every type.
        hints: how to be linked to publishers.
    """

    def __init__(self, context: Context, topic: str, message_class: type[Any], hints: Hints) -> None:
        self.context = context
        self.topic = topic
        self.type = topic_type(message_class)
        self.subscribers: tuple[Subscriber[Any], ...] = ()
        self.on_change: list[Callable[[], None]] = []
        self.hints = hints
        self._connectors: dict[str, Connector] = {}  # loop only
        self._in_links: tuple[InLink, ...] = ()
        self._local_links: tuple[LocalLink | DatagramInLink, ...] = ()
        self._latched: dict[int, tuple[Source, Item]] = {}  # as delivered
        self._arrived_latched: dict[int, tuple[Source, Item]] = {}  # in a node that spins: as arrived
        self._lock = threading.RLock()  # a signal handler may end the node while its thread is in here
        self._closed = False
        self._direct: tuple[Subscriber[Any], ...] = ()
        # Those of both that have got what came before them, and get what comes from now on.
        self._active: tuple[Subscriber[Any], ...] = ()
        self._active_direct: tuple[Subscriber[Any], ...] = ()
        self.reader = Reader(
            context.readers, self._deliver, self._deliver_item, self._lost, self._arrived, context.callbacks
        )

    # Subscribers ------------------------------------------------------------------------------------------------------

    def add(self, subscriber: Subscriber[Any]) -> None:
        """Add a subscriber; latched messages that came before are handed to it (T18).

        Raises:
            NodeError: this topic is subscribed with another type in this node already.
        """
        wanted = topic_type(subscriber.type)
        with self._lock:
            if ANY not in (wanted.md5sum, self.type.md5sum) and wanted.md5sum != self.type.md5sum:
                raise NodeError(
                    f"{self.topic} is subscribed as {self.type.name} in this node already, "
                    f"it cannot be {wanted.name} too"
                )
            if self.type.md5sum == ANY:
                self.type = wanted
            if subscriber.direct and self.context.callbacks is not None:
                self._direct = (*self._direct, subscriber)
            else:
                self.subscribers = (*self.subscribers, subscriber)
            self._set_limit()
        self.reader.submit(lambda: self._activate(subscriber))

    def remove(self, subscriber: Subscriber[Any]) -> bool:
        """Remove a subscriber; return whether any is left."""
        with self._lock:
            self.subscribers = tuple(other for other in self.subscribers if other is not subscriber)
            self._direct = tuple(other for other in self._direct if other is not subscriber)
            self._active = tuple(other for other in self._active if other is not subscriber)
            self._active_direct = tuple(other for other in self._active_direct if other is not subscriber)
            self._set_limit()
        return bool(self.subscribers or self._direct)

    def _activate(self, subscriber: Subscriber[Any]) -> None:
        """Hand over the latched messages, and let all that come from now on be delivered. By the reader's owner."""
        with self._lock:
            early = subscriber.direct and self.context.callbacks is not None
            latched = list((self._arrived_latched if early else self._latched).values())
            if subscriber in self.subscribers:
                self._active = (*self._active, subscriber)
            elif subscriber in self._direct:
                self._active_direct = (*self._active_direct, subscriber)
        self._replay(subscriber, latched)

    def _set_limit(self) -> None:
        """The links are shared, so the most patient subscriber decides how much may wait."""
        sizes = [subscriber.queue_size for subscriber in self.subscribers]
        self.reader.limit = None if None in sizes or not sizes else max(size for size in sizes if size is not None)

    # Publishers -------------------------------------------------------------------------------------------------------

    def request_header(self) -> dict[str, str]:
        """Return the connection header to greet publishers with."""
        return subscriber_header(self.context.name, self.topic, self.type, self.hints.tcp_nodelay)

    def update_publishers(self, uris: list[str], complete: bool = True) -> None:
        """Take the master's list of publishers. On the loop.

        Args:
            uris: slave API addresses.
            complete: publishers that are not in the list are gone. (The answer to a registration may be older than an
                update that overtook it, so it only adds.)
        """
        if self._closed:
            return
        for uri in uris:
            if uri not in self._connectors:
                self._connectors[uri] = Connector(self, uri)
            self._connectors[uri].announced()
        if complete:
            for uri in [uri for uri in self._connectors if uri not in uris]:
                self._connectors[uri].vanished()
                self.forget(self._connectors[uri])

    def forget(self, connector: Connector) -> None:
        """Drop a connector that has nothing to do any more. On the loop."""
        if connector.idle and self._connectors.get(connector.uri) is connector:
            del self._connectors[connector.uri]

    def link(self, connector: Connector, link: InLink) -> None:
        """A connector has reached its publisher. On the loop."""
        if self._closed:
            link.sock.close()
            return
        with self._lock:
            self._in_links = (*self._in_links, link)
        self.reader.add(link)
        self._changed()

    def link_local(self, connector: Connector, publication: Publication) -> None:
        """Link to a publication of this process. On the loop.

        Raises:
            Refusal: it is of another type.
        """
        link = publication.connect_local(self, connector.uri, self.request_header())
        connector.linked = True
        self.add_local(link)

    def add_local(self, link: LocalLink | DatagramInLink) -> None:
        """Take a link that hands over its messages itself. On the loop."""
        with self._lock:
            if link.connected:  # not so if the publisher ended meanwhile, on its own thread
                self._local_links = (*self._local_links, link)
        self._changed()

    def local_closed(self, link: LocalLink | DatagramInLink) -> None:
        """A link that hands over its messages itself has ended. Any thread."""
        with self._lock:
            self._local_links = tuple(other for other in self._local_links if other is not link)
        self.reader.submit(lambda: self._ended(link))
        self.context.loop.call_soon(self._reconnect, link.uri, None)
        self._changed()

    def _ended(self, link: LocalLink | DatagramInLink) -> None:
        self._forget(link)
        self.reader.forget(link)

    def _forget(self, source: Source) -> None:
        self._latched.pop(id(source), None)
        self._arrived_latched.pop(id(source), None)

    def _lost(self, link: InLink, reason: str | None) -> None:
        with self._lock:
            self._in_links = tuple(other for other in self._in_links if other is not link)
        self._forget(link)
        self.context.loop.call_soon(self._reconnect, link.uri, reason)
        self._changed()

    def _reconnect(self, uri: str, reason: str | None) -> None:
        connector = self._connectors.get(uri)
        if connector is None or self._closed:
            return
        connector.lost(reason)
        self.forget(connector)

    def _changed(self) -> None:
        for callback in tuple(self.on_change):
            callback()

    @property
    def links(self) -> tuple[InLink | LocalLink | DatagramInLink, ...]:
        """The links that are up."""
        return self._in_links + self._local_links

    # Messages, on the reader thread or the one that spins -------------------------------------------------------------

    def _arrived(self, source: Source, item: Item) -> bool:
        """A node that spins has received a message: serve those who do not wait for the spinning; say if others do."""
        if source.header.get("latching") == "1" and source.connected:
            self._arrived_latched[id(source)] = (source, item)
        if self._active_direct:
            self._call(self._active_direct, source, item)
        return bool(self.subscribers)

    def _deliver(self, source: Source, data: bytes, start: int, end: int) -> None:
        active = self._active
        if source.header.get("latching") == "1":
            active = self._keep(source, data[start:end])
        self._call(active, source, data, start, end)

    def _deliver_item(self, source: Source, item: Item) -> None:
        active = self._active
        if source.header.get("latching") == "1":
            active = self._keep(source, item)
        self._call(active, source, item)

    def _keep(self, source: Source, item: Item) -> tuple[Subscriber[Any], ...]:
        """Keep a latched message for those who subscribe later; return who gets it now."""
        with self._lock:
            if source.connected:  # not what waited here when its publisher went
                self._latched[id(source)] = (source, item)
            return self._active

    def _call(
        self, subscribers: tuple[Subscriber[Any], ...], source: Source, data: Any, start: int = 0, end: int = -1
    ) -> None:
        """Run the callbacks.

        Args:
            data: a frame's body at ``start`` to ``end``; or an item, if ``end`` is -1.
        """
        header = source.header
        message = made_by = None
        for subscriber in subscribers:
            if subscriber.decode is not made_by or message is None:
                try:
                    message = subscriber.decode(data, start, end) if end >= 0 else subscriber.take(data)
                except MessageError as error:
                    who = header.get("callerid", "?")
                    self.context.log.peer(ERROR, "%s from %s: %s (message dropped)", self.topic, who, error)
                    continue
                message._connection_header = header
                made_by = subscriber.decode
                if end - start >= LARGE:
                    _learn(source, message, end - start)
                elif end < 0 and isinstance(data, bytes) and len(data) >= LARGE:
                    _learn(source, message, len(data))
            subscriber.call(message)

    def _replay(self, subscriber: Subscriber[Any], latched: list[tuple[Source, Item]]) -> None:
        for source, item in latched:
            try:
                message = subscriber.take(item)
            except MessageError:
                continue  # was logged when it came
            message._connection_header = source.header
            if self.context.callbacks is not None and not subscriber.direct:
                self.context.callbacks.push(lambda message=message: subscriber.call(message))  # type: ignore[misc]
            else:
                subscriber.call(message)

    def close(self, timeout: float = 5.0) -> None:
        """End all links; wait for a running callback at most ``timeout`` seconds."""
        self._closed = True
        self.context.loop.call_soon(self._stop_connectors)
        for link in self._local_links:
            link.close()
        self.reader.close(timeout)
        with self._lock:
            self._in_links = ()
        self._changed()

    def _stop_connectors(self) -> None:
        for connector in self._connectors.values():
            connector.stop()
        self._connectors.clear()


def _learn(source: Source, message: Any, size: int) -> None:
    """Tell a link where the array of a large message was."""
    where = layout(type(message))
    if where is not None and isinstance(source, InLink):
        array = len(getattr(message, where.field))
        if array >= LARGE:
            source.expect(size, array, where.tail, where.counted)
