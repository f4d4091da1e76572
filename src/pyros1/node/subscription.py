"""Subscribing: one Subscription per topic and node, and the Subscriber handles that users hold.

Several subscribers of one topic in a node share its links and its thread, as in rospy and roscpp: a publisher sees one
connection per node. https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pyros1.errors import MessageError, NodeError, NodeShutdownError
from pyros1.node.connector import Connector
from pyros1.node.context import wait_for_links
from pyros1.node.inlink import InLink
from pyros1.node.publisher import topic_type
from pyros1.node.reader import Data, Reader, Source
from pyros1.wire.handshake import ANY, subscriber_header

if TYPE_CHECKING:
    from pyros1.node.context import Context
    from pyros1.node.local import LocalLink
    from pyros1.node.publisher import Publication

_M = TypeVar("_M")


class Subscription:
    """A topic that a node subscribes to, with its links to publishers.

    Args:
        context: the node.
        topic: full name.
        message_class: of the first subscriber; AnyMsg takes every type.
        tcp_nodelay: ask publishers to send small messages at once.
    """

    def __init__(self, context: Context, topic: str, message_class: type[Any], tcp_nodelay: bool) -> None:
        self.context = context
        self.topic = topic
        self.type = topic_type(message_class)
        self.subscribers: tuple[Subscriber[Any], ...] = ()
        self.on_change: list[Callable[[], None]] = []
        self._tcp_nodelay = tcp_nodelay
        self._connectors: dict[str, Connector] = {}  # loop only
        self._in_links: tuple[InLink, ...] = ()
        self._local_links: tuple[LocalLink, ...] = ()
        self._latched: dict[int, tuple[Source, bytes]] = {}  # as delivered
        self._arrived_latched: dict[int, tuple[Source, bytes]] = {}  # in a node that spins: as arrived
        self._lock = threading.Lock()
        self._closed = False
        self._direct: tuple[Subscriber[Any], ...] = ()
        self.reader = Reader(f"{context.name}:{topic}", self._deliver, self._lost, self._arrived, context.callbacks)

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
        self.reader.submit(lambda: self._replay(subscriber))

    def remove(self, subscriber: Subscriber[Any]) -> bool:
        """Remove a subscriber; return whether any is left."""
        with self._lock:
            self.subscribers = tuple(other for other in self.subscribers if other is not subscriber)
            self._direct = tuple(other for other in self._direct if other is not subscriber)
            self._set_limit()
        return bool(self.subscribers or self._direct)

    def _set_limit(self) -> None:
        """The links are shared, so the most patient subscriber decides how much may wait."""
        sizes = [subscriber.queue_size for subscriber in self.subscribers]
        self.reader.limit = None if None in sizes or not sizes else max(size for size in sizes if size is not None)

    # Publishers -------------------------------------------------------------------------------------------------------

    def request_header(self) -> dict[str, str]:
        """Return the connection header to greet publishers with."""
        return subscriber_header(self.context.name, self.topic, self.type, self._tcp_nodelay)

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
                if not self._connectors[uri].linked:
                    del self._connectors[uri]

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
        with self._lock:
            if link.connected:  # not so if the publisher ended meanwhile, on its own thread
                self._local_links = (*self._local_links, link)
        self._changed()

    def local_closed(self, link: LocalLink) -> None:
        """A local publisher has ended its link. Any thread."""
        with self._lock:
            self._local_links = tuple(other for other in self._local_links if other is not link)
        self.reader.submit(lambda: self._forget(link))
        self.context.loop.call_soon(self._reconnect, link.uri, None)
        self._changed()

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
        if connector.idle:
            del self._connectors[uri]

    def _changed(self) -> None:
        for callback in tuple(self.on_change):
            callback()

    @property
    def links(self) -> tuple[InLink | LocalLink, ...]:
        """The links that are up."""
        return self._in_links + self._local_links

    # Messages, on the reader thread or the one that spins -------------------------------------------------------------

    def _arrived(self, source: Source, frame: bytes) -> bool:
        """A node that spins has received a frame: serve those who do not wait for the spinning; say if others do."""
        if source.header.get("latching") == "1":
            self._arrived_latched[id(source)] = (source, frame)
        if self._direct:
            self._call(self._direct, source, frame, 0, len(frame))
        return bool(self.subscribers)

    def _deliver(self, source: Source, data: Data, start: int, end: int) -> None:
        self._call(self.subscribers, source, data, start, end)
        if source.header.get("latching") == "1":
            self._latched[id(source)] = (source, bytes(data[start:end]))

    def _call(self, subscribers: tuple[Subscriber[Any], ...], source: Source, data: Data, start: int, end: int) -> None:
        header = source.header
        message = made_for = None
        for subscriber in subscribers:
            if subscriber.type is not made_for or message is None:
                try:
                    message = subscriber.type._decode(data, start, end)
                except MessageError as error:
                    self.context.log.error(
                        "%s from %s: %s (message dropped)", self.topic, header.get("callerid", "?"), error, throttle=5.0
                    )
                    continue
                message._connection_header = header
                made_for = subscriber.type
            subscriber._call(message)

    def _replay(self, subscriber: Subscriber[Any]) -> None:
        early = subscriber.direct and self.context.callbacks is not None
        for source, frame in list((self._arrived_latched if early else self._latched).values()):
            try:
                message = subscriber.type._decode(frame, 0, len(frame))
            except MessageError:
                continue  # was logged when it came
            message._connection_header = source.header
            if self.context.callbacks is not None and not subscriber.direct:
                self.context.callbacks.push(lambda message=message: subscriber._call(message))  # type: ignore[misc]
            else:
                subscriber._call(message)

    def close(self) -> None:
        """End all links and the thread."""
        self._closed = True
        self.context.loop.call_soon(self._stop_connectors)
        for link in self._local_links:
            link.close()
        self.reader.close()
        with self._lock:
            self._in_links = ()
        self._changed()

    def _stop_connectors(self) -> None:
        for connector in self._connectors.values():
            connector.stop()
        self._connectors.clear()


class Subscriber(Generic[_M]):
    """A user's handle of a subscription; made by ``Node.subscribe``. Also a context manager that unregisters.

    Attributes:
        name: the topic's full name.
        type: the message class.
        queue_size: most messages that may wait for the callback; None for no limit.
    """

    def __init__(
        self,
        subscription: Subscription,
        message_class: type[_M],
        callback: Callable[[_M], object],
        queue_size: int | None,
        unregister: Callable[[Subscriber[Any]], None],
        direct: bool = False,
    ) -> None:
        self.direct = direct  # called in the reader thread even in a node that spins
        self.name = subscription.topic
        self.type = message_class
        self.queue_size = queue_size
        self._subscription = subscription
        self._callback = callback
        self._unregister: Callable[[Subscriber[Any]], None] | None = unregister

    def _call(self, message: _M) -> None:
        if self._unregister is None:
            return
        try:
            self._callback(message)
        except NodeShutdownError:
            pass  # the callback waited for something when the node was told to stop
        except Exception as error:
            self._subscription.context.log.exception(f"bad callback of {self.name}: {self._callback!r}", error)

    @property
    def num_connections(self) -> int:
        """Number of connected publishers."""
        return len(self._subscription.links)

    @property
    def dropped(self) -> int:
        """Messages thrown away on this side because the callbacks were too slow."""
        return self._subscription.reader.dropped

    def wait_for_publishers(self, count: int = 1, timeout: float | None = None) -> bool:
        """Wait until at least ``count`` publishers are connected.

        Args:
            timeout: seconds; None waits until the node shuts down.

        Returns:
            Whether they are there.
        """
        return wait_for_links(self._subscription, count, timeout)

    def unregister(self) -> None:
        """Stop receiving; the topic is unregistered with its last subscriber in this node."""
        unregister, self._unregister = self._unregister, None
        if unregister is not None:
            unregister(self)

    def __enter__(self) -> Subscriber[_M]:
        return self

    def __exit__(self, *_: object) -> None:
        self.unregister()
