"""The subscription to a topic: one per topic and node. The user's handles are in ``subscriber.py``.

Several subscribers to one topic in a node share the topic's links and thread, as in rospy and roscpp: a publisher sees
one connection per node. https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import NodeError
from pyros1.node.subscribing.connector import Connector
from pyros1.node.subscribing.delivery_loop import DeliveryLoop
from pyros1.node.subscribing.dispatcher import Dispatcher, SpinQueues
from pyros1.node.topic_type import topic_type
from pyros1.wire.handshake import WILDCARD, make_subscriber_header

if TYPE_CHECKING:
    from pyros1.node.context import Context, PublicationInterface
    from pyros1.node.subscribing.hints import Hints
    from pyros1.node.subscribing.queues import Source
    from pyros1.node.subscribing.subscriber import Subscriber
    from pyros1.node.subscribing.tcp_source import TcpSource
    from pyros1.node.subscribing.threads import Driver
    from pyros1.node.subscribing.udp_source import UdpSource


class Subscription:
    """A topic that a node subscribes to, with its links to publishers.

    Args:
        context: the node's context.
        topic: the topic's full name.
        message_class: class of the first subscriber's messages; AnyMsg accepts every type.
        hints: transports and options for links to publishers.
        driver: runs the delivery loop while all subscribers are streams that drop nothing; None for the node's
            threads.

    Attributes:
        type: the topic's type, as used in connection headers.
        change_listeners: functions called, without arguments, when links are added and removed.
        dispatcher: passes messages to the subscribers.
        delivery: receives from the links.
    """

    def __init__(
        self, context: Context, topic: str, message_class: type[Any], hints: Hints, driver: Driver | None = None
    ) -> None:
        self.context = context
        self.topic = topic
        self.type = topic_type(message_class)
        self.change_listeners: list[Callable[[], None]] = []
        self.hints = hints
        self.dispatcher = Dispatcher(context, topic)
        self._spin_queues = (
            None if context.callback_queue is None else SpinQueues(self.dispatcher, context.callback_queue)
        )
        self.delivery = DeliveryLoop(
            self.dispatcher, driver or context.delivery_threads, self._spin_queues, self._on_link_lost
        )
        self._connectors: dict[str, Connector] = {}  # used only on the loop
        self._tcp_links: tuple[TcpSource, ...] = ()
        self._inbox_links: tuple[Source, ...] = ()  # over UDP and within the process
        self._lock = threading.RLock()  # reentrant: a signal handler in one of these methods may shut down the node
        self._closed = False

    # Subscribers ------------------------------------------------------------------------------------------------------

    def add(self, subscriber: Subscriber[Any]) -> None:
        """Add a subscriber and deliver earlier latched messages to it (T18).

        Raises:
            NodeError: this node already subscribes to the topic with another type.
        """
        requested_type = topic_type(subscriber.type)
        with self._lock:
            if WILDCARD not in (requested_type.md5sum, self.type.md5sum) and requested_type.md5sum != self.type.md5sum:
                raise NodeError(
                    f"this node already subscribes to {self.topic} as {self.type.name}, not as {requested_type.name}"
                )
            if self.type.md5sum == WILDCARD:
                self.type = requested_type
            self.dispatcher.add(subscriber)
            self._set_limit()
        stream = subscriber.stream
        may_block = stream is None or stream.wants_newest  # a callback may take a long time
        if may_block and self.delivery.driver.cooperative:
            self.delivery.submit(lambda: self.delivery.links.move(self.context.delivery_threads))
        self.delivery.submit(lambda: self.dispatcher.activate(subscriber), by_callback=True)

    def remove(self, subscriber: Subscriber[Any]) -> bool:
        """Remove a subscriber; return whether any is left."""
        with self._lock:
            self.dispatcher.remove(subscriber)
            self._set_limit()
        self.delivery.wake()  # the subscriber may have held publishers back
        return bool(self.dispatcher.subscribers or self.dispatcher.direct_subscribers)

    def update_limit(self) -> None:
        """Apply a subscriber's changed queue size."""
        with self._lock:
            self._set_limit()

    def _set_limit(self) -> None:
        """Set how many messages may wait: the links are shared, so the largest limit of the subscribers applies.

        Streams limit themselves. Messages are delivered in the publisher's thread if all callbacks request this.
        """
        subscribers = self.dispatcher.subscribers
        sizes = [subscriber.queue_size for subscriber in subscribers]
        is_unlimited = None in sizes or all(subscriber.stream is not None for subscriber in subscribers)
        limit = None if is_unlimited else max(size for size in sizes if size is not None)
        self.delivery.limit = limit
        if self._spin_queues is not None:
            self._spin_queues.limit = limit
        immediate_subscribers = (
            self.dispatcher.direct_subscribers if self.context.callback_queue is not None else subscribers
        )
        self.delivery.in_publisher = bool(immediate_subscribers) and all(
            subscriber.in_publisher for subscriber in immediate_subscribers
        )

    # Publishers -------------------------------------------------------------------------------------------------------

    def request_header(self) -> dict[str, str]:
        """Return the connection header that is sent to publishers."""
        return make_subscriber_header(self.context.name, self.topic, self.type, self.hints.tcp_nodelay)

    def update_publishers(self, uris: list[str], complete: bool = True) -> None:
        """Apply the master's list of publishers. Called on the loop.

        Args:
            uris: URIs of the publishers' slave APIs.
            complete: whether publishers that are not in the list are gone. False for the response to a registration,
                which may be older than an update that was received before it.
        """
        if self._closed:
            return
        for uri in uris:
            if uri not in self._connectors:
                self._connectors[uri] = Connector(self, uri)
            self._connectors[uri].on_publisher_listed()
        if complete:
            listed = set(uris)  # for fast look-ups: there may be a thousand
            for uri in [uri for uri in self._connectors if uri not in listed]:
                self._connectors[uri].on_publisher_unlisted()

    def has_publisher(self, uri: str) -> bool:
        """Return whether the master has listed a publisher. Called on the loop."""
        return uri in self._connectors

    def forget(self, uri: str) -> None:
        """Remove the connector of a publisher if it has nothing left to do. Called on the loop."""
        connector = self._connectors.get(uri)
        if connector is not None and connector.is_finished:
            del self._connectors[uri]

    def link(self, link: TcpSource) -> None:
        """Add the link of a connector that has reached its publisher. Called on the loop."""
        if self._closed:
            link.close()
            return
        link.low_latency = self.hints.low_latency
        with self._lock:
            self._tcp_links = (*self._tcp_links, link)
        self.delivery.add(link)
        self._notify_listeners()

    def link_in_process(self, uri: str, publication: PublicationInterface) -> None:
        """Link to a publication of this process. Called on the loop.

        Raises:
            Refusal: the publication has another type, or is closed.
        """
        self.add_inbox_link(
            publication.connect_in_process(self.delivery, uri, self.request_header(), self._on_inbox_link_closed)
        )

    def offer_datagrams(self, uri: str) -> UdpSource:
        """Return a UDP socket to offer to a publisher; see `add_inbox_link`. Called on the loop.

        Raises:
            OSError: no socket can be opened.
        """
        from pyros1.node.subscribing.udp_source import UdpSource  # noqa: PLC0415 - few nodes need it

        context, header, size = self.context, self.request_header(), self.hints.max_datagram_size
        assert context.address is not None
        return UdpSource(
            context.loop,
            self.delivery,
            header,
            uri,
            context.address,
            context.allowlist,
            size,
            self._on_inbox_link_closed,
        )

    def add_inbox_link(self, link: Source) -> None:
        """Add a link that puts messages into an inbox. Called on the loop."""
        with self._lock:
            if link.connected:  # the publisher may have closed the link meanwhile, on its own thread
                self._inbox_links = (*self._inbox_links, link)
        if self._closed:  # on another thread, perhaps before the link was added, so it must be closed here
            link.close()
        self._notify_listeners()

    def _on_inbox_link_closed(self, link: Source) -> None:
        """Forget a link that puts messages into an inbox, since it has closed. Thread-safe."""
        with self._lock:
            self._inbox_links = tuple(other for other in self._inbox_links if other is not link)
        self.delivery.submit(lambda: self.delivery.forget(link))
        self.context.loop.call_soon(self._reconnect, link.uri, None)
        self._notify_listeners()

    def _on_link_lost(self, link: TcpSource, reason: str | None) -> None:
        with self._lock:
            self._tcp_links = tuple(other for other in self._tcp_links if other is not link)
        self.context.loop.call_soon(self._reconnect, link.uri, reason)
        self._notify_listeners()

    def _reconnect(self, uri: str, reason: str | None) -> None:
        connector = self._connectors.get(uri)
        if connector is None or self._closed:
            return
        connector.on_link_lost(reason)

    def _notify_listeners(self) -> None:
        for callback in tuple(self.change_listeners):
            callback()

    @property
    def links(self) -> tuple[Source, ...]:
        """The open links."""
        return self._tcp_links + self._inbox_links

    def close(self, timeout: float = 5.0, wait: bool = True) -> None:
        """Close all links; if ``wait`` is True, wait for a running callback at most ``timeout`` seconds."""
        self._closed = True
        self.context.loop.call_soon(self._stop_connectors)
        for link in self._inbox_links:
            link.close()
        self.delivery.close(timeout, wait)
        with self._lock:
            self._tcp_links = ()
        self._notify_listeners()

    def _stop_connectors(self) -> None:
        for connector in list(self._connectors.values()):
            connector.stop()
        self._connectors.clear()
