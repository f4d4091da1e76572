"""The topics that a node publishes and subscribes to, and their registration with the master."""

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
from pyros1.node.subscribing.subscriber import Subscriber
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
_Callback = Callable[[Any], object]
_SUBSCRIBE = "subscribe(topic, type, callback)"
MAX_CALLBACK_WAIT = 5.0
"""Maximum number of seconds to wait for running callbacks when the node shuts down."""


class Topics:
    """Publications and subscriptions by full name.

    Args:
        context: the node's context.
        get_registrar: returns the node's registrar.

    Attributes:
        publications, subscriptions: by topic; replaced as a whole on changes, so that readers need no lock. Other parts
            of the node access copies in the context.
    """

    def __init__(self, context: Context, get_registrar: Callable[[], Registrar]) -> None:
        self.publications: dict[str, Publication] = {}
        self.subscriptions: dict[str, Subscription] = {}
        self._context = context
        self._get_registrar = get_registrar
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
        """Register the node as a publisher of a topic; see ``Node.advertise``."""
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
                publication.num_publishers += 1
                publication.latch = publication.latch or latch
                publication.headers.update(headers)  # headers and queue size only affect later subscribers
                if queue_size is not None and publication.queue_size is not None:  # queued messages remain
                    publication.queue_size = queue_size
                return Publisher(publication, message_class, lambda: self._unadvertise(publication))
            new_publication = Publication(context, name, message_class, wire_type, queue_size, latch, headers)
            new_publication.num_publishers = 1
            self._set_publications({**self.publications, name: new_publication})
            try:
                # Called with the lock held, as in `_unadvertise`, so that the master receives the calls in order.
                wait_for_registration = self._get_registrar().begin_register(
                    "registerPublisher", name, wire_type.name, context.uri
                )
            except BaseException:
                self._drop_publication(new_publication)
                raise
        try:
            wait_for_registration()
        except BaseException as error:
            self._drop_publication(new_publication)
            self._undo_registration(error, "registerPublisher", name, wire_type.name, context.uri)
            raise
        return Publisher(new_publication, message_class, lambda: self._unadvertise(new_publication))

    def _undo_registration(self, error: BaseException, *registration: str) -> None:
        """Undo a registration if an exception other than a pyros1 error, such as one raised by a signal handler, has
        interrupted the wait for its result.
        """
        if not isinstance(error, Error):
            with contextlib.suppress(NodeError):
                self._get_registrar().begin_unregister(*registration)

    def _unadvertise(self, publication: Publication) -> None:
        if self._context.is_forked:
            return
        with self._lock:
            publication.num_publishers -= 1
            if publication.num_publishers or self._context.stopping.is_set():
                return
            # Removed immediately: a call that advertises the topic meanwhile must create a new publication.
            self._set_publications({k: v for k, v in self.publications.items() if v is not publication})
            try:
                wait_for_unregistration = self._get_registrar().begin_unregister(
                    "registerPublisher", publication.topic, publication.type.name, self._context.uri
                )
            except BaseException:
                publication.close()
                raise
        try:
            wait_for_unregistration()
        finally:
            publication.close()

    def _drop_publication(self, publication: Publication) -> None:
        with self._lock:
            self._set_publications({k: v for k, v in self.publications.items() if v is not publication})
        publication.close()

    def _set_publications(self, publications: dict[str, Publication]) -> None:
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
            name: the topic's full name.
            message_class: class of the messages.
            callback: called with each message.
            queue_size: maximum number of queued messages per publisher; None for no limit.
            hints: how to connect to publishers.
            direct: whether to call the callback in the receiving thread, even in a node with ``callbacks="spin"``.
            arrays: the type of numeric arrays, see `find_view`.
            stream: receives the messages undecoded, instead of the callback.
            driver: receives the messages if the topic has only streams that drop nothing; None for the node's threads.
            deadline: receives the messages and calls the callback.
            in_publisher: whether to call the callback in the thread of a publisher in this process.
        """
        context = self._context
        view = None
        if arrays is not None:
            from pyros1.msgs.array_views import find_view  # noqa: PLC0415  few programs use them

            view = find_view(arrays)
        context.check_process()
        with self._lock:
            context.check_running()
            subscription = self.subscriptions.get(name)
            is_new = subscription is None
            if subscription is None:
                subscription = Subscription(context, name, message_class, hints, driver)
                self._set_subscriptions({**self.subscriptions, name: subscription})
            receive = callback if deadline is None else deadline.on_message
            unsubscribe = self._unsubscribe
            subscriber = Subscriber(
                subscription,
                message_class,
                receive,
                queue_size,
                unsubscribe,
                direct,
                view,
                stream,
                deadline,
                in_publisher,
            )
            try:
                subscription.add(subscriber)
            except BaseException:
                if is_new:
                    self._drop_subscription(subscription)
                else:
                    subscription.remove(subscriber)
                raise
            if is_new:
                try:
                    wait_for_registration = self._get_registrar().begin_register(
                        "registerSubscriber", name, subscription.type.name, context.uri
                    )
                except BaseException:
                    self._drop_subscription(subscription)
                    raise
        if is_new:
            try:
                uris = wait_for_registration()
            except BaseException as error:
                self._drop_subscription(subscription)
                self._undo_registration(error, "registerSubscriber", name, subscription.type.name, context.uri)
                raise
            self.on_publishers_found(name, uris)
        if deadline is not None:
            deadline.begin(subscription)
        return subscriber

    def _set_subscriptions(self, subscriptions: dict[str, Subscription]) -> None:
        self.subscriptions = subscriptions
        self._context.subscriptions = {**subscriptions}

    def on_publishers_found(self, topic: str, uris: Any) -> None:
        """Process the list of publishers that the master returned for a registration."""
        valid_uris = [uri for uri in uris if isinstance(uri, str)] if isinstance(uris, list) else []
        if valid_uris != uris:
            text = "the master returned an invalid list of publishers of %s: %s"
            self._context.log.peer_event(WARN, text, topic, repr(uris)[:60])
        subscription = self.subscriptions.get(topic)
        if subscription is not None:
            self._context.loop.call_soon(subscription.update_publishers, valid_uris, False)

    def _unsubscribe(self, subscriber: Subscriber[Any]) -> None:
        if self._context.is_forked:
            return
        with self._lock:
            subscription = self.subscriptions.get(subscriber.name)
            if subscription is None or subscription.remove(subscriber) or self._context.stopping.is_set():
                return
            self._set_subscriptions({k: v for k, v in self.subscriptions.items() if v is not subscription})
            try:
                wait_for_unregistration = self._get_registrar().begin_unregister(
                    "registerSubscriber", subscription.topic, subscription.type.name, self._context.uri
                )
            except BaseException:
                subscription.close()
                raise
        try:
            wait_for_unregistration()
        finally:
            subscription.close(wait=False)  # the caller may hold a lock for which the callback is waiting

    def _drop_subscription(self, subscription: Subscription) -> None:
        with self._lock:
            self._set_subscriptions({k: v for k, v in self.subscriptions.items() if v is not subscription})
        subscription.close()

    def wait_for_message(self, name: str, message_class: Any, timeout: float | None) -> Any:
        """Wait for one message; see ``Node.wait_for_message``."""
        checks.check_timeout(timeout)
        received: list[Any] = []
        arrived = Event()

        def on_message(message: Any) -> None:
            received.append(message)
            arrived.set()

        deadline = None if timeout is None else time.monotonic() + timeout
        with self.subscribe(name, message_class, on_message, 1, direct=True):
            while not arrived.wait(0.2 if deadline is None else min(0.2, max(0.0, deadline - time.monotonic()))):
                self._context.check_running()
                if deadline is not None and time.monotonic() >= deadline:
                    raise WaitTimeoutError(f"timeout exceeded while waiting for message on topic {name}")
        return received[0]

    def close(self) -> None:
        """Close all links and stop the receiving threads."""
        deadline = time.perf_counter() + MAX_CALLBACK_WAIT  # one deadline for all: many callbacks may not return
        for subscription in self.subscriptions.values():
            subscription.delivery.stop()
        for subscription in self.subscriptions.values():
            subscription.close(max(0.0, deadline - time.perf_counter()))
        self._context.close_delivery_threads(max(0.1, deadline - time.perf_counter()))
        with self._lock:  # so that no new subscriber finds a publication that is about to close
            publications = self.publications
            self._set_publications({})
        deadline = time.perf_counter() + CLOSE_TIMEOUT  # one deadline for all: a stuck subscriber may have many topics
        for publication in publications.values():
            publication.close(deadline)


class TopicMethods:
    """The methods of `Node` that deal with topics; a base class of `Node`."""

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
        """Register the node as a publisher of a topic, and return a `Publisher` to publish messages with.

        Args:
            topic: name of the topic.
            type: message class, or a type's name such as "std_msgs/Float64".
            queue_size: maximum number of messages queued for each slow subscriber; beyond that, the oldest are dropped.
                0 for no limit. None makes `publish` wait for the slowest subscriber, as in rospy.
            latch: whether to keep the last message for later subscribers.
            headers: extra fields for the connection header.
            raw_type: for AnyMsg, the type name, md5 sum and definition of the messages.

        Raises:
            NodeError: this node already publishes the topic with another type.
            TypeError: an argument has a wrong type.
        """
        checks.check_name(topic, "advertise(topic, type)")
        checks.check_queue_size(queue_size, 0)
        checks.check_headers(headers)
        cls = checks.require_message_class(type, "advertise")
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
        """Subscribe to a topic, and return a `Subscriber`, whose `unregister` ends the subscription.

        Args:
            topic: name of the topic.
            type: message class, a type's name, or AnyMsg to receive any type.
            callback: called with each message. Calls for one topic never overlap.
            queue_size: maximum number of messages of each publisher queued for a slow callback; older ones are dropped
                undecoded. None drops nothing, but slows publishers down; in a node with ``callbacks="spin"``, None
                means 1000.
            tcp_nodelay: whether to ask publishers to send small messages without delay.
            arrays: the type of numeric arrays (always one-dimensional): None for bytes (uint8) and tuples;
                "memoryview" or "numpy" for read-only arrays of the field's type that share the received bytes, without
                copying. With "numpy", an array of messages of fixed size, such as PoseArray's ``poses``, is a
                numpy.recarray of shape (n,) with `pyros1.msgs.record_dtype`: ``message.poses.position.x`` is an array
                of shape (n,).
            transports: one or several transports in order of preference: "tcp" (TCPROS), "local" (shared memory and
                Unix sockets, for pyros1 publishers of the same user on this machine; used by default), "udp" (UDPROS:
                lost messages are not sent again, and nothing waits for them; see https://wiki.ros.org/ROS/UDPROS).
                rospy publishers only support "tcp". The first subscriber to a topic in a node decides for the others.
            max_datagram_size: maximum size of a datagram in bytes, for "udp".
            low_latency: whether to poll for the next message for 2 ms before sleeping: messages arrive 25 to 50 us
                sooner, but the node uses up to one processor. It only has an effect while the topic has one publisher,
                over TCP or local, and the machine is not busy. The first subscriber to a topic in a node decides for
                the others.
            deadline: maximum time between two messages, in seconds of the node's time, starting at the first connection
                to a publisher. A message counts when the callback receives it. None for no limit.
            on_missed: called like any callback, with a Missed, if no message has arrived within ``deadline``: once for
                each gap, whether a publisher is connected or not.
            in_publisher: whether to call the callback in the thread of a publisher in this process, before its
                `publish` returns, so that no other thread has to wake up. All subscribers to the topic in this node
                whose callbacks run immediately must request it. A message that arrives while a callback of the topic is
                running is delivered by another thread.

        Raises:
            ValueError: an unknown transport, a size out of range, or only one of ``deadline`` and ``on_missed``.
            NodeError: this node already subscribes to the topic with another type.
            TypeError: an argument has a wrong type.
        """
        checks.check_name(topic, _SUBSCRIBE)
        checks.check_callback(callback, _SUBSCRIBE, "callback", type)
        checks.check_queue_size(queue_size, 1)
        cls = checks.require_message_class(type, "subscribe")
        transport_names = (
            (transports,) if isinstance(transports, str) or not isinstance(transports, Iterable) else transports
        )
        hints = Hints(tcp_nodelay, tuple(transport_names), max_datagram_size, bool(low_latency))
        hints.check()
        name, monitor = self.resolve(topic), self._make_deadline(callback, deadline, on_missed)
        topics = self._topics
        return topics.subscribe(
            name, cls, callback, queue_size, hints, arrays=arrays, deadline=monitor, in_publisher=bool(in_publisher)
        )

    def _make_deadline(
        self, callback: _Callback, seconds: float | None, on_missed: _Callback | None
    ) -> Deadline | None:
        if seconds is None and on_missed is None:
            return None
        if seconds is None or on_missed is None:
            raise ValueError("subscribe: deadline and on_missed belong together: pass both or neither")
        checks.check_positive(seconds, "subscribe: deadline", "s", MAX_PERIOD)
        checks.check_callback(on_missed, _SUBSCRIBE, "on_missed")
        from pyros1.node.subscribing.deadline import Deadline  # noqa: PLC0415 - few subscribers have one

        return Deadline(seconds, callback, on_missed, self._context, self._clock, self._notifiers)

    def wait_for_message(self, topic: str, type: type[_M] | str, timeout: float | None = None) -> _M:
        """Wait for one message on a topic and return it.

        Args:
            topic: name of the topic.
            type: message class, or a type's name.
            timeout: maximum number of seconds of wall time; None waits until the node shuts down.

        Raises:
            WaitTimeoutError: no message arrived in time.
            NodeShutdownError: the node is shutting down.
        """
        checks.check_name(topic, "wait_for_message(topic, type)")
        cls = checks.require_message_class(type, "wait_for_message")
        message: _M = self._topics.wait_for_message(self.resolve(topic), cls, timeout)
        return message
