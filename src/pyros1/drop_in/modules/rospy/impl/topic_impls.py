"""``Publisher.impl`` and ``Subscriber.impl``: for programs that inspect the connections of a topic."""

from __future__ import annotations

import functools
import threading
from typing import Any

from pyros1.drop_in.module_attributes import class_getattr
from pyros1.drop_in.process import PROCESS
from rospy.exceptions import ROSException

_SOCKET_REASON = "pyros1's nodes manage the sockets, and use none within a process"
_SOCKET_MEMBERS = frozenset(
    ["socket", "fileno", "protocol", "local_endpoint", "remote_endpoint", "cleanup_cb", "read_buff", "write_buff"]
)
_LOCK_REASON = "pyros1's topics have no lock for sending"
_LOCK_MEMBERS = frozenset(["acquire", "release", "c_lock", "publock", "buff", "seq", "latch"])


class Connection:
    """A connection to a peer.

    Attributes:
        id: number of the connection.
        endpoint_id: the peer's node name, or the address of its API.
        direction: "o" or "i".
        transport_type, name: the name of the transport, and of the topic.
        header, type, md5sum, callerid_pub, is_latched: as in the connection header.
        stat_bytes, stat_num_msg: number of bytes and messages so far.
        done: whether the connection has ended.
    """

    def __init__(self, number: int, link: Any, topic: str, direction: str) -> None:
        self._link = link
        self.id = number
        self.direction = direction
        self.name = topic
        self.endpoint_id: str = link.peer if direction == "o" else link.uri
        self.transport_type: str = link.transport
        self.header: dict[str, str] = getattr(link, "header", {})
        self.type = self.header.get("type")
        self.md5sum = self.header.get("md5sum")
        self.callerid_pub = self.header.get("callerid")
        self.is_latched = self.header.get("latching") == "1"
        self.done = not link.connected

    @property
    def stat_bytes(self) -> int:
        """Number of bytes received or sent so far."""
        return int(getattr(self._link, "bytes_received", 0) or getattr(self._link, "bytes_sent", 0))

    @property
    def stat_num_msg(self) -> int:
        """Number of messages received or sent so far."""
        return int(self._link.messages)

    __getattr__ = class_getattr("Publisher.impl.connections[]", _SOCKET_REASON, _SOCKET_MEMBERS)

    def get_transport_info(self) -> str:
        """Return the addresses of both ends as text."""
        return str(self._link.address)


class TopicImpl:
    """A topic of this program; see `PublisherImpl` and `SubscriberImpl`.

    Attributes:
        name, resolved_name: full name.
        data_class, type: message class and type name of the first publisher or subscriber.
        ref_count: number of publishers or subscribers.
        handles: pyros1's publishers or subscribers.
        closed: whether no publisher or subscriber is left.
        handler: None, as in stock ROS.
    """

    direction = ""
    handler = None
    __getattr__ = class_getattr("Publisher.impl and Subscriber.impl", _LOCK_REASON, _LOCK_MEMBERS)

    def __init__(self, name: str, data_class: Any) -> None:
        self.name = self.resolved_name = name
        self.data_class = data_class
        self.type: str = data_class._type
        self.handles: list[Any] = []
        self.ref_count = 0
        self.closed = False
        self._connection_ids: dict[int, tuple[Any, int]] = {}
        self._next_connection_id = 1

    def _links(self) -> tuple[Any, ...]:
        handles = self.handles  # other threads replace the list, but do not modify it
        return handles[0].links if handles else ()

    @property
    def connections(self) -> list[Connection]:
        """The connections."""
        links = self._links()
        numbers: dict[int, tuple[Any, int]] = {}
        for link in links:  # a link keeps the number that an earlier call gave it
            numbers[id(link)] = self._connection_ids.get(id(link)) or (link, self._next_connection_id)
            self._next_connection_id = max(self._next_connection_id, numbers[id(link)][1] + 1)
        self._connection_ids = numbers
        return [Connection(numbers[id(link)][1], link, self.name, self.direction) for link in links]

    def get_num_connections(self) -> int:
        """Return the number of connections."""
        return len(self._links())

    def has_connections(self) -> bool:
        """Return whether there are connections."""
        return bool(self._links())

    def has_connection(self, endpoint_id: str) -> bool:
        """Return whether a peer is connected."""
        return any(connection.endpoint_id == endpoint_id for connection in self.connections)

    def close(self) -> None:
        """Mark the topic as closed; subclasses release its resources."""
        self.closed = True

    def check(self) -> None:
        """Do nothing: ended connections are noticed immediately."""

    def get_stats_info(self) -> list[tuple[Any, ...]]:
        """Return (id, peer, direction, transport, topic, whether it is connected, addresses) of each connection."""
        return [
            (
                connection.id,
                connection.endpoint_id,
                connection.direction,
                connection.transport_type,
                connection.name,
                True,
                connection.get_transport_info(),
            )
            for connection in self.connections
        ]

    def add_connection(self, c: Any) -> bool:
        """Raise NotImplementedError: pyros1 makes connections itself.

        Raises:
            NotImplementedError: always.
        """
        raise NotImplementedError("pyros1 makes a topic's connections itself")

    remove_connection = add_connection


class PublisherImpl(TopicImpl):
    """A topic that this program publishes.

    Attributes:
        queue_size, is_latch, headers: shared by all publishers of the topic.
        subscriber_listeners: the listeners of all publishers of the topic.
    """

    direction = "o"

    def __init__(self, name: str, data_class: Any) -> None:
        super().__init__(name, data_class)
        self.queue_size: int | None = None
        self.is_latch = False
        self.headers: dict[str, str] = {}
        self.subscriber_listeners: list[Any] = []
        self._listener_watch: Any = None

    def add_headers(self, headers: dict[str, str]) -> None:
        """Add connection header fields, for publishers created later."""
        self.headers.update(headers)

    def enable_latch(self) -> None:
        """Record that the topic is latched."""
        self.is_latch = True

    def set_queue_size(self, queue_size: int) -> None:
        """Set the maximum number of queued messages, for publishers started later."""
        self.queue_size = queue_size

    def publish(self, message: Any, connection_override: Connection | None = None) -> None:
        """Publish a message."""
        handles = self.handles
        if handles:
            handles[0].publish(message)

    def get_stats(self) -> tuple[str, int, list[tuple[int, int, int, bool]]]:
        """Return (topic, bytes, [(id, bytes, messages, whether it is connected)])."""
        stats = [
            (connection.id, connection.stat_bytes, connection.stat_num_msg, not connection.done)
            for connection in self.connections
        ]
        return self.name, sum(entry[1] for entry in stats), stats

    # Listeners, called in one of pyros1's threads ---------------------------------------------------------------------

    def add_subscriber_listener(self, l: Any) -> None:  # noqa: E741 - stock's name
        """Notify a `SubscribeListener` when subscribers connect and disconnect."""
        self.subscriber_listeners.append(l)
        PROCESS.add_start_callback(lambda _: self.start_notifications())

    def start_notifications(self) -> None:
        """Start to notify the listeners, if the topic is already published."""
        handles = self.handles
        if self._listener_watch is None and self.subscriber_listeners and handles:
            self._listener_watch = handles[0].watch(self._on_connect, self._on_disconnect)

    def _on_connect(self, peer: Any) -> None:
        handles = self.handles
        for listener in list(self.subscriber_listeners):
            listener.peer_subscribe(self.name, handles[0].publish if handles else self.publish, peer.publish)

    def _on_disconnect(self, peer: Any) -> None:
        for listener in list(self.subscriber_listeners):
            listener.peer_unsubscribe(self.name, peer.others)


def _call_with_extra(callback: Any, extra: Any, message: Any) -> None:
    callback(message, extra)


class SubscriberImpl(TopicImpl):
    """A topic to which this program subscribes.

    Attributes:
        callbacks: (callback, extra argument or None) of each subscriber.
        queue_size, buff_size, tcp_nodelay: the values that were set last.
    """

    direction = "i"

    def __init__(self, name: str, data_class: Any) -> None:
        super().__init__(name, data_class)
        self.callbacks: list[tuple[Any, Any]] = []
        self.queue_size: int | None = None
        self.buff_size = 65536
        self.tcp_nodelay = False
        self.statistics_logger: Any = None
        self._added_subscribers: list[tuple[Any, Any, Any]] = []

    def begin_statistics(self) -> None:
        """Publish statistics of the topic, if /enable_statistics is true."""
        from rospy.client import get_param

        if self.name not in ("/clock", "/statistics") and get_param("/enable_statistics", False):
            from rospy.impl.statistics import SubscriberStatisticsLogger

            self.statistics_logger = SubscriberStatisticsLogger(self)

    def close(self) -> None:
        """Close the topic, and stop its statistics."""
        super().close()
        if self.statistics_logger is not None:
            self.statistics_logger.shutdown()
            self.statistics_logger = None

    def set_queue_size(self, queue_size: int | None) -> None:
        """Set the maximum number of queued messages; -1 and None for no limit.

        Raises:
            ROSException: the size is 0, or not a number.
        """
        if queue_size == -1:
            self.queue_size = None
        elif queue_size == 0:
            raise ROSException("queue size may not be set to zero")
        elif queue_size is not None and not isinstance(queue_size, int):
            raise ROSException("queue size must be an integer")
        else:
            self.queue_size = queue_size

    def set_buff_size(self, buff_size: int) -> None:
        """Record the size of the buffer in bytes; it has no effect, since pyros1's buffers grow as needed.

        Raises:
            ROSException: the size is not a positive number.
        """
        if not isinstance(buff_size, int):
            raise ROSException("buffer size must be an integer")
        if buff_size <= 0:
            raise ROSException("buffer size must be a positive integer")
        self.buff_size = buff_size

    def set_tcp_nodelay(self, tcp_nodelay: bool) -> None:
        """Record whether publishers should send immediately; pyros1 always requests that."""
        self.tcp_nodelay = tcp_nodelay

    def add_callback(self, cb: Any, cb_args: Any) -> None:
        """Call another function with each message."""
        from rospy.topics import Subscriber

        self._added_subscribers.append(
            (cb, cb_args, Subscriber(self.name, self.data_class, cb, cb_args, self.queue_size))
        )

    def remove_callback(self, cb: Any, cb_args: Any) -> None:
        """Undo `add_callback`.

        Raises:
            KeyError: there is no such callback.
        """
        for entry in self._added_subscribers:
            callback, extra, subscriber = entry
            if (callback, extra) == (cb, cb_args):
                self._added_subscribers.remove(entry)
                subscriber.unregister()
                return
        raise KeyError("no matching cb")

    def receive_callback(self, msgs: Any, connection: Any) -> None:
        """Call all callbacks with some messages, as if they had just been received.

        Args:
            msgs: the messages.
            connection: accepted for compatibility.
        """
        from rospy.impl.rosout import with_error_logging

        for message in msgs:
            for callback, extra in self.callbacks:
                call = callback if extra is None else functools.partial(_call_with_extra, callback, extra)
                with_error_logging(call, callback)(message)

    def get_stats(self) -> tuple[str, list[tuple[int, int, int, int, bool]]]:
        """Return (topic, [(id, bytes, messages, -1 for the unknown number of drops, whether it is connected)])."""
        return self.name, [
            (connection.id, connection.stat_bytes, connection.stat_num_msg, -1, not connection.done)
            for connection in self.connections
        ]


class TopicManager:
    """Lists the program's topics.

    Attributes:
        pubs, subs: the published and the subscribed topics by name.
        topics: the names of all topics.
        lock: held while publishers and subscribers are added or removed.
    """

    def __init__(self) -> None:
        self.pubs: dict[str, PublisherImpl] = {}
        self.subs: dict[str, SubscriberImpl] = {}
        self.lock = threading.RLock()

    @property
    def topics(self) -> set[str]:
        """The names of all topics."""
        return {*self.pubs, *self.subs}

    def _table(self, reg_type: str) -> dict[str, Any]:
        return self.pubs if reg_type == "pub" else self.subs

    def acquire_impl(self, reg_type: str, resolved_name: str, data_class: Any) -> Any:
        """Return a topic for another publisher or subscriber; create it if necessary."""
        with self.lock:
            table = self._table(reg_type)
            if resolved_name not in table:
                table[resolved_name] = (PublisherImpl if reg_type == "pub" else SubscriberImpl)(
                    resolved_name, data_class
                )
            impl = table[resolved_name]
            impl.ref_count += 1
            return impl

    def release_impl(self, reg_type: str, resolved_name: str) -> None:
        """Release a topic; it is removed with its last publisher or subscriber."""
        with self.lock:
            impl = self._table(reg_type).get(resolved_name)
            if impl is None:
                return
            impl.ref_count -= 1
            if impl.ref_count > 0:
                return
            del self._table(reg_type)[resolved_name]
        impl.close()  # without the lock: close() waits for callbacks, which may need the lock

    def get_impl(self, reg_type: str, resolved_name: str) -> Any:
        """Return a topic; None if there is none."""
        return self._table(reg_type).get(resolved_name)

    def get_publisher_impl(self, resolved_name: str) -> PublisherImpl | None:
        """Return a published topic; None if there is none."""
        return self.pubs.get(resolved_name)

    def get_subscriber_impl(self, resolved_name: str) -> SubscriberImpl | None:
        """Return a subscribed topic; None if there is none."""
        return self.subs.get(resolved_name)

    def has_publication(self, resolved_name: str) -> bool:
        """Return whether a topic is published."""
        return resolved_name in self.pubs

    def has_subscription(self, resolved_name: str) -> bool:
        """Return whether a topic is subscribed."""
        return resolved_name in self.subs

    def get_topics(self) -> set[str]:
        """Return the names of all topics."""
        return self.topics

    def get_publications(self) -> list[list[str]]:
        """Return [name, type] of each published topic."""
        return [[name, impl.type] for name, impl in list(self.pubs.items())]

    def get_subscriptions(self) -> list[list[str]]:
        """Return [name, type] of each subscribed topic."""
        return [[name, impl.type] for name, impl in list(self.subs.items())]

    def get_pub_sub_info(self) -> list[tuple[Any, ...]]:
        """Return a description of each connection, see `TopicImpl.get_stats_info`."""
        return [info for impl in [*self.pubs.values(), *self.subs.values()] for info in impl.get_stats_info()]

    def get_pub_sub_stats(self) -> tuple[list[Any], list[Any]]:
        """Return the numbers of bytes and messages of all topics; see `PublisherImpl.get_stats` and
        `SubscriberImpl.get_stats`.
        """
        pubs, subs = list(self.pubs.values()), list(self.subs.values())
        return [impl.get_stats() for impl in pubs], [impl.get_stats() for impl in subs]

    def check_all(self) -> None:
        """Do nothing: ended connections are noticed immediately."""
