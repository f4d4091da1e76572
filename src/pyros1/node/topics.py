"""The topics that a node publishes and subscribes, and their registration with the master."""

from __future__ import annotations

import contextlib
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

from pyros1.ground.errors import Error, NodeError, WaitTimeoutError
from pyros1.net.signal_safe import Event
from pyros1.node import checks
from pyros1.node.clock import MAX_PERIOD
from pyros1.node.log.levels import WARN
from pyros1.node.publishing.publication import CLOSE_TIMEOUT, Publication
from pyros1.node.publishing.publisher import Publisher
from pyros1.node.subscribing.hints import DEFAULT_TRANSPORTS, Hints
from pyros1.node.subscribing.subscriber import Subscriber, array_view
from pyros1.node.subscribing.subscription import Subscription
from pyros1.node.topic_type import topic_type

if TYPE_CHECKING:
    from pyros1.node.clock import Clock
    from pyros1.node.context import Context
    from pyros1.node.registrar import Registrar
    from pyros1.node.subscribing.deadline import Deadline, Missed
    from pyros1.node.subscribing.dispatcher import Stream
    from pyros1.node.subscribing.threads import Driver
    from pyros1.node.watching.notifiers import Notifiers
    from pyros1.wire.handshake import TopicType

_M = TypeVar("_M")
_Call = Callable[[Any], object]
_SUBSCRIBE = "subscribe(topic, type, callback)"
MAX_CALLBACK_WAIT = 5.0
"""Seconds that running callbacks have at the end of the node."""


class Topics:
    """Publications and subscriptions by full name.

    Args:
        context: the node.
        registrar: the node's registrations with the master.

    Attributes:
        publications, subscriptions: by topic; replaced as a whole on changes, so that readers need no lock. Other
            parts see them in the context.
    """

    def __init__(self, context: Context, registrar: Callable[[], Registrar]) -> None:
        self.publications: dict[str, Publication] = {}
        self.subscriptions: dict[str, Subscription] = {}
        self._context = context
        self._registrar = registrar
        self._lock = threading.RLock()

    # Publishing -------------------------------------------------------------------------------------------------------

    def advertise(
        self,
        name: str,
        message_class: Any,
        wire_type: TopicType,
        queue_size: int | None,
        latch: bool,
        headers: Mapping[str, str],
    ) -> Publisher[Any]:
        """Publish on a topic; see ``Node.advertise``."""
        context = self._context
        context.check_process()
        with self._lock:
            context.check_running()
            publication = self.publications.get(name)
            if publication is not None:
                if publication.type.md5sum != wire_type.md5sum:
                    raise NodeError(
                        f"this node already publishes {name} as {publication.type.name}, not as {wire_type.name}"
                    )
                publication.handles += 1
                publication.latch = publication.latch or latch
                publication.headers.update(headers)  # this, and the next, for subscribers that come later
                if queue_size is not None and publication.queue_size is not None:  # waiting messages stay queued
                    publication.queue_size = queue_size
                return Publisher(publication, message_class, lambda: self._unadvertise(publication))
            created = Publication(context, name, message_class, wire_type, queue_size, latch, headers)
            created.handles = 1
            self._publish({**self.publications, name: created})
            try:
                # With the lock, here and below: the master must be told of an end and a new start in that order.
                registered = self._registrar().begin_register("registerPublisher", name, wire_type.name, context.uri)
            except BaseException:
                self._drop_publication(created)
                raise
        try:
            registered()
        except BaseException as error:
            self._drop_publication(created)
            self._undo_registration(error, "registerPublisher", name, wire_type.name, context.uri)
            raise
        return Publisher(created, message_class, lambda: self._unadvertise(created))

    def _undo_registration(self, error: BaseException, *registration: str) -> None:
        """Undo a registration that a thread stopped waiting for: a signal handler raised. The master may be down."""
        if not isinstance(error, Error):
            with contextlib.suppress(NodeError):
                self._registrar().begin_unregister(*registration)

    def _unadvertise(self, publication: Publication) -> None:
        if self._context.is_forked:
            return
        with self._lock:
            publication.handles -= 1
            if publication.handles or self._context.stopping.is_set():
                return
            # Removed from the table at once: a call that advertises the topic now must get a new publication.
            self._publish({k: v for k, v in self.publications.items() if v is not publication})
            try:
                unregistered = self._registrar().begin_unregister(
                    "registerPublisher", publication.topic, publication.type.name, self._context.uri
                )
            except BaseException:
                publication.close()
                raise
        try:
            unregistered()
        finally:
            publication.close()

    def _drop_publication(self, publication: Publication) -> None:
        with self._lock:
            self._publish({k: v for k, v in self.publications.items() if v is not publication})
        publication.close()

    def _publish(self, publications: dict[str, Publication]) -> None:
        self.publications = publications
        self._context.publications = {**publications}

    # Subscribing ------------------------------------------------------------------------------------------------------

    def subscribe(
        self,
        name: str,
        message_class: Any,
        callback: Callable[[Any], object],
        queue_size: int | None = None,
        hints: Hints = Hints(),  # noqa: B008 - immutable
        direct: bool = False,
        arrays: str | None = None,
        stream: Stream | None = None,
        driver: Driver | None = None,
        deadline: Deadline | None = None,
        in_publisher: bool = False,
    ) -> Subscriber[Any]:
        """Subscribe to a topic; see ``Node.subscribe``.

        Args:
            hints: how to link to publishers.
            direct: whether to call from the thread that receives, even in a node that spins.
            arrays: see `array_view`.
            stream: receives the messages undecoded, in place of the callback.
            driver: receives for topics that have only streams that drop nothing; None for the node's threads.
            deadline: replaces the callback.
            in_publisher: whether to call from the thread of a publisher of this process.
        """
        context = self._context
        view = array_view(arrays)
        context.check_process()
        with self._lock:
            context.check_running()
            subscription = self.subscriptions.get(name)
            new = subscription is None
            if subscription is None:
                subscription = Subscription(context, name, message_class, hints, driver)
                self._subscribe_to({**self.subscriptions, name: subscription})
            call = callback if deadline is None else deadline.take
            leave = self._unsubscribe
            subscriber = Subscriber(
                subscription, message_class, call, queue_size, leave, direct, view, stream, deadline, in_publisher
            )
            try:
                subscription.add(subscriber)
            except BaseException:
                if new:
                    self._drop_subscription(subscription)
                else:
                    subscription.remove(subscriber)
                raise
            if new:
                try:
                    registered = self._registrar().begin_register(
                        "registerSubscriber", name, subscription.type.name, context.uri
                    )
                except BaseException:
                    self._drop_subscription(subscription)
                    raise
        if new:
            try:
                uris = registered()
            except BaseException as error:
                self._drop_subscription(subscription)
                self._undo_registration(error, "registerSubscriber", name, subscription.type.name, context.uri)
                raise
            self.publishers_found(name, uris)
        if deadline is not None:
            deadline.begin(subscription)
        return subscriber

    def _subscribe_to(self, subscriptions: dict[str, Subscription]) -> None:
        self.subscriptions = subscriptions
        self._context.subscriptions = {**subscriptions}

    def publishers_found(self, topic: str, uris: Any) -> None:
        """Take the list of publishers in the master's answer to a registration."""
        known = [uri for uri in uris if isinstance(uri, str)] if isinstance(uris, list) else []
        if known != uris:
            text = "the master gave an invalid answer about the publishers of %s: %s"
            self._context.log.peer(WARN, text, topic, repr(uris)[:60])
        subscription = self.subscriptions.get(topic)
        if subscription is not None:
            self._context.loop.call_soon(subscription.update_publishers, known, False)

    def _unsubscribe(self, subscriber: Subscriber[Any]) -> None:
        if self._context.is_forked:
            return
        with self._lock:
            subscription = self.subscriptions.get(subscriber.name)
            if subscription is None or subscription.remove(subscriber) or self._context.stopping.is_set():
                return
            self._subscribe_to({k: v for k, v in self.subscriptions.items() if v is not subscription})
            try:
                unregistered = self._registrar().begin_unregister(
                    "registerSubscriber", subscription.topic, subscription.type.name, self._context.uri
                )
            except BaseException:
                subscription.close()
                raise
        try:
            unregistered()
        finally:
            subscription.close(wait=False)  # the caller may hold a lock that the callback waits for

    def _drop_subscription(self, subscription: Subscription) -> None:
        with self._lock:
            self._subscribe_to({k: v for k, v in self.subscriptions.items() if v is not subscription})
        subscription.close()

    def wait_for_message(self, name: str, message_class: Any, timeout: float | None) -> Any:
        """Wait for one message; see ``Node.wait_for_message``."""
        checks.check_timeout(timeout)
        got: list[Any] = []
        came = Event()

        def take(message: Any) -> None:
            got.append(message)
            came.set()

        until = None if timeout is None else time.monotonic() + timeout
        with self.subscribe(name, message_class, take, 1, direct=True):
            while not came.wait(0.2 if until is None else min(0.2, max(0.0, until - time.monotonic()))):
                self._context.check_running()
                if until is not None and time.monotonic() >= until:
                    raise WaitTimeoutError(f"timeout exceeded while waiting for message on topic {name}")
        return got[0]

    def close(self) -> None:
        """End all links and the receiving threads."""
        until = time.perf_counter() + MAX_CALLBACK_WAIT  # one deadline for all: many callbacks may not return
        for subscription in self.subscriptions.values():
            subscription.delivery.stop()
        for subscription in self.subscriptions.values():
            subscription.close(max(0.0, until - time.perf_counter()))
        self._context.close_delivery_threads(max(0.1, until - time.perf_counter()))
        with self._lock:  # no new subscriber finds a publication that is about to close
            publications = self.publications
            self._publish({})
        until = time.perf_counter() + CLOSE_TIMEOUT  # one deadline for all: a stuck subscriber may have many topics
        for publication in publications.values():
            publication.close(until)


class TopicMethods:
    """The topic functions of a node; one of its base classes."""

    resolve: Callable[[str], str]
    _clock: Clock
    _context: Context
    _notifiers: Notifiers
    _topics: Topics

    def advertise(
        self,
        topic: str,
        type: type[_M] | str,
        *,
        queue_size: int | None = 100,
        latch: bool = False,
        headers: Mapping[str, str] | None = None,
        raw_type: TopicType | None = None,
    ) -> Publisher[_M]:
        """Publish on a topic.

        Args:
            topic: name of the topic.
            type: message class, or a type's name such as "std_msgs/Float64".
            queue_size: maximum number of messages waiting for each slow subscriber; beyond that the oldest are dropped.
                0: no limit. None: `publish` waits for the slowest subscriber, like rospy's.
            latch: whether to keep the last message for subscribers that come later.
            headers: extra fields for the connection header.
            raw_type: for AnyMsg: type name, md5 sum and definition of the messages.

        Raises:
            NodeError: this node already publishes the topic with another type.
            TypeError: an argument has a wrong type.
        """
        checks.check_name(topic, "advertise(topic, type)")
        checks.check_queue_size(queue_size, 0)
        checks.check_headers(headers)
        cls = checks.message_class(type, "advertise")
        checks.check_raw_type(raw_type)
        wire_type = raw_type or topic_type(cls)
        return self._topics.advertise(self.resolve(topic), cls, wire_type, queue_size, latch, headers or {})

    def subscribe(
        self,
        topic: str,
        type: type[_M] | str,
        callback: Callable[[_M], object],
        *,
        queue_size: int | None = None,
        tcp_nodelay: bool = True,
        arrays: str | None = None,
        transports: str | Iterable[str] = DEFAULT_TRANSPORTS,
        max_datagram_size: int = 1500,
        low_latency: bool = False,
        deadline: float | None = None,
        on_missed: Callable[[Missed], object] | None = None,
        in_publisher: bool = False,
    ) -> Subscriber[_M]:
        """Subscribe to a topic.

        Args:
            topic: name of the topic.
            type: message class, a type's name, or AnyMsg for whatever type the topic has.
            callback: called with each message. Calls of one topic never overlap.
            queue_size: maximum number of messages of each publisher waiting for a slow callback; older ones are dropped
                undecoded. None drops nothing: publishers are held back (in a node that spins: 1000).
            tcp_nodelay: whether to ask publishers to send small messages at once.
            arrays: the type of numeric arrays, which all have one dimension: None for bytes (uint8) and tuples;
                "memoryview" or "numpy" for read-only arrays of the field's type that refer to the received bytes,
                without a copy.
            transports: one or several transports in the order of preference: "tcp" (TCPROS), "local" (shared memory
                and Unix sockets, with pyros1 publishers of this machine and user; used by default), "udp"
                (UDPROS: lost messages are not sent again, and nothing waits for them; see
                https://wiki.ros.org/ROS/UDPROS). rospy's publishers have "tcp" only. The first subscriber of a topic
                in a node decides.
            max_datagram_size: bytes of the largest datagram, for "udp".
            low_latency: look for the next message for 2 ms after each before sleeping: messages come 25 to 50 us
                sooner, but the node uses up to a whole processor. Only while the topic has one publisher, over TCP or
                local. The first subscriber of a topic in a node decides.
            deadline: seconds of the node's time that may pass between two messages, counted from the first connection
                to a publisher on; a message counts when the callback receives it. None: no limit.
            on_missed: called with a Missed, where all callbacks run, when no message has come within ``deadline``: once
                for each gap, whether a publisher is connected or not.
            in_publisher: run the callback within `publish` of a publisher of this process, in its thread, before it
                returns; no thread must wake up for that. Not for a message that comes while a callback of the topic
                runs, and only if all subscribers of the topic in this node whose callbacks run at once want it.

        Raises:
            ValueError: an unknown transport, an impossible size, or only one of ``deadline`` and ``on_missed``.
            NodeError: this node already subscribes to the topic with another type.
            TypeError: an argument has a wrong type.
        """
        checks.check_name(topic, _SUBSCRIBE)
        checks.check_callback(callback, _SUBSCRIBE, "callback", type)
        checks.check_queue_size(queue_size, 1)
        cls = checks.message_class(type, "subscribe")
        wanted = (transports,) if isinstance(transports, str) or not isinstance(transports, Iterable) else transports
        hints = Hints(tcp_nodelay, tuple(wanted), max_datagram_size, bool(low_latency))
        hints.check()
        name, limit = self.resolve(topic), self._deadline(callback, deadline, on_missed)
        topics = self._topics
        return topics.subscribe(
            name, cls, callback, queue_size, hints, arrays=arrays, deadline=limit, in_publisher=bool(in_publisher)
        )

    def _deadline(self, callback: _Call, seconds: float | None, on_missed: _Call | None) -> Deadline | None:
        if seconds is None and on_missed is None:
            return None
        if seconds is None or on_missed is None:
            raise ValueError("subscribe: deadline and on_missed belong together: give both or neither")
        checks.check_positive(seconds, "subscribe: deadline", "s", MAX_PERIOD)
        checks.check_callback(on_missed, _SUBSCRIBE, "on_missed")
        from pyros1.node.subscribing.deadline import Deadline  # noqa: PLC0415 - few subscribers have one

        return Deadline(seconds, callback, on_missed, self._context, self._clock, self._notifiers)

    def wait_for_message(self, topic: str, type: type[_M] | str, timeout: float | None = None) -> _M:
        """Wait for one message of a topic and return it.

        Args:
            timeout: seconds, in wall time; None waits until the node shuts down.

        Raises:
            WaitTimeoutError: no message came in time.
            NodeShutdownError: the node is shutting down.
        """
        checks.check_name(topic, "wait_for_message(topic, type)")
        cls = checks.message_class(type, "wait_for_message")
        message: _M = self._topics.wait_for_message(self.resolve(topic), cls, timeout)
        return message
