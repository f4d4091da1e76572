"""Publishing: one Publication per topic and node, and the Publisher handles that users hold.

https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers
"""

from __future__ import annotations

import contextlib
import itertools
import socket
import threading
from collections.abc import Callable, Mapping
from time import perf_counter
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from pyros1.errors import NodeError, SerializationError
from pyros1.msgs import AnyMsg, Message
from pyros1.msgs.base import message_class
from pyros1.node.context import wait_for_links
from pyros1.node.keepalive import keep_alive
from pyros1.node.link import SubscriberLink, WaitingLink
from pyros1.node.local import LocalLink
from pyros1.wire.handshake import ANY, Refusal, TopicType, answer_subscriber, is_true
from pyros1.wire.header import encode_header
from pyros1.wire.outqueue import Frame

if TYPE_CHECKING:
    from pyros1.node.context import Context
    from pyros1.node.datagrams import DatagramLink
    from pyros1.node.subscription import Subscription

_M = TypeVar("_M")
_U32_SIZE = 4
FAREWELL = 1.0
"""Seconds that subscribers have for taking the last messages of a publisher that ends."""
MOST_LINKS = 1024


class Link(Protocol):
    """What a publication needs to know of a link."""

    peer: str
    messages: int
    bytes_sent: int
    transport: str
    address: str

    @property
    def dropped(self) -> int: ...
    @property
    def waiting(self) -> int: ...
    @property
    def connected(self) -> bool: ...
    def starting(self) -> contextlib.AbstractContextManager[None]: ...
    def send(self, frame: Frame) -> None: ...
    def offer(self, frame: Frame) -> None: ...
    def close(self) -> None: ...
    def finish(self, until: float) -> None: ...


class Publication:
    """A topic that a node publishes, and its links.

    Args:
        context: the node.
        topic: full name.
        message_class: what is published; an AnyMsg publication needs ``type_`` to say what really travels.
        type_: type name, md5 sum and definition that are told to subscribers.
        queue_size: most waiting messages per slow subscriber; 0 unlimited; None: publishing waits for subscribers.
        latch: keep the last message and give it to every new subscriber.
        headers: further fields of the connection header.
    """

    def __init__(
        self,
        context: Context,
        topic: str,
        message_class: type[Any],
        type_: TopicType,
        queue_size: int | None,
        latch: bool,
        headers: Mapping[str, str],
    ) -> None:
        self.context = context
        self.topic = topic
        self.message_class = message_class
        self._encode = message_class._encode_frame
        self.type = type_
        self.queue_size = queue_size
        self.latch = latch
        self.headers = dict(headers)
        self.links: tuple[Link, ...] = ()
        self._remote: tuple[Link, ...] = ()  # those of the links that take frames
        self._local: tuple[LocalLink, ...] = ()  # and those that take messages
        self.handles = 0
        self.on_change: list[Callable[[], None]] = []
        self._connections = itertools.count(1)  # of datagrams
        self._seq = itertools.count(1)  # from 1, as rospy (T22)
        self._latched: dict[object, Frame] = {}  # by publisher: each has its own, as in roscpp
        self._lock = threading.Lock()
        self._order = threading.RLock()  # a signal handler may publish, too
        self._closed = False
        self.publish: Callable[[Any], None] = self._publish_numbered if message_class._has_header else self._publish
        """Send a message to all links; see Publisher.publish."""

    def _publish_numbered(self, message: Any) -> None:
        if not (self.links or self.latch):
            return
        if self.queue_size is None:  # publishing may wait, and a callback that it waits for may publish
            message.header.seq = next(self._seq)
            self._publish(message)
            return
        with self._order:  # what several threads publish leaves in the order of its numbers
            message.header.seq = next(self._seq)
            self._publish(message)

    def _publish(self, message: Any) -> None:
        remote, local, latch = self._remote, self._local, self.latch
        if not (remote or local or latch):
            return
        try:
            cls = message.__class__
            copy = cls._copy(message) if local and not latch else None
            if remote or latch or copy is None:
                frame = self._encode(message) if cls is self.message_class else cls._encode_frame(message)
        except SerializationError as error:
            raise SerializationError(f"{self.topic}: {error}") from None
        if latch:
            for link in self._keep(frame):
                link.send(frame)
            return
        for link in remote:
            link.send(frame)
        if copy is not None:
            for taker in local:
                taker.hand_over(copy)

    def _keep(self, frame: Frame, source: object = None) -> tuple[Link, ...]:
        """Make a frame the latched one of a source; return the links that must still get it: later ones get it too."""
        with self._lock:
            self._latched[source] = frame if isinstance(frame, bytes) else b"".join(frame)
            return self.links

    def publish_body(self, body: bytes, source: object = None) -> None:
        """Send an already encoded message.

        Args:
            body: its bytes.
            source: for a latched topic: whose last message it is. Later subscribers get the last one of each source.
        """
        frame = len(body).to_bytes(_U32_SIZE, "little") + body
        for link in self._keep(frame, source) if self.latch else self.links:
            link.send(frame)

    def forget(self, source: object) -> None:
        """Forget a source's latched message."""
        with self._lock:
            self._latched.pop(source, None)

    def accept(self, sock: socket.socket, header: dict[str, str]) -> None:
        """Answer a subscriber's header and take it as a link. On the loop.

        Raises:
            Refusal: the subscriber wants another type.
        """
        answer = self._answer(header)
        self._check_room()
        keep_alive(sock)
        if is_true(header.get("tcp_nodelay")):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        greeting = encode_header(answer)
        link_class = WaitingLink if self.queue_size is None else SubscriberLink
        self._add(link_class(self.context.loop, sock, header, greeting, self.queue_size, self._remove))

    def accept_datagrams(self, header: dict[str, str], place: tuple[str, int], size: int) -> DatagramLink:
        """Take a subscriber that wants datagrams. On the loop.

        Args:
            header: its connection header.
            place: its host and port.
            size: bytes of the largest datagram.

        Raises:
            Refusal: it wants another type, or cannot be reached.
        """
        from pyros1.node.datagrams import DatagramLink  # noqa: PLC0415 - few nodes need it

        answer = self._answer(header)
        self._check_room()
        number = next(self._connections)
        link = DatagramLink(self.context.loop, header, answer, place, size, number, self._remove)
        if not link.connected:
            raise Refusal(f"no datagrams can be sent to {place[0]}:{place[1]}")
        self._add(link)
        return link

    def connect_local(self, subscription: Subscription, uri: str, header: dict[str, str]) -> LocalLink:
        """Link a subscription of the same process, without a socket.

        Raises:
            Refusal: it wants another type.
        """
        try:
            answer = self._answer(header)
        except Refusal as refusal:  # over TCP the server says so
            self.context.log.warn("refused a connection of %s for %s: %s", header["callerid"], self.topic, refusal)
            raise
        link = LocalLink(subscription, uri, header, answer, self.queue_size, self._remove)
        self._add(link)
        return link

    def _check_room(self) -> None:
        if len(self.links) >= MOST_LINKS:
            raise Refusal(f"[{self.topic}] has {MOST_LINKS} subscribers already")

    def _answer(self, header: dict[str, str]) -> dict[str, str]:
        if self._closed:
            raise self._gone()
        return answer_subscriber(header, self.context.name, self.topic, self.type, self.latch, self.headers)

    def _add(self, link: Link) -> None:
        with self._lock:
            closed = self._closed
            if not closed:
                with link.starting():
                    self._set_links((*self.links, link))
                for frame in self._latched.values():  # whoever publishes a later one waits for the lock
                    link.offer(frame)
        if closed:
            link.close()  # calls _remove, which takes the lock
            raise self._gone()
        self._changed()

    def _gone(self) -> Refusal:
        return Refusal(f"[{self.context.name}] is no longer a publisher of [{self.topic}]")

    def _remove(self, link: Link) -> None:
        with self._lock:
            self._set_links(tuple(other for other in self.links if other is not link))
        self._changed()

    def _set_links(self, links: tuple[Link, ...]) -> None:
        self.links = links
        self._local = tuple(link for link in links if isinstance(link, LocalLink))
        self._remote = tuple(link for link in links if not isinstance(link, LocalLink))

    def _changed(self) -> None:
        for callback in tuple(self.on_change):
            callback()

    def close(self, until: float | None = None) -> None:
        """End all links; what still waits is sent first, as far as subscribers take it in time.

        Args:
            until: `perf_counter` time when they must have it; None: in FAREWELL seconds.
        """
        with self._lock:
            self._closed = True
            links, self._latched = self.links, {}
        if until is None:
            until = perf_counter() + FAREWELL
        for link in links:
            link.finish(until)


class Publisher(Generic[_M]):
    """A user's handle of a published topic; made by ``Node.advertise``. Also a context manager that unregisters.

    Attributes:
        name: the topic's full name.
        type: the message class.
    """

    def __init__(self, publication: Publication, message_class: type[_M], unregister: Callable[[], None]) -> None:
        self.name = publication.topic
        self.type = message_class
        self._publication = publication
        self._unregister: Callable[[], None] | None = unregister
        self._raw = message_class is AnyMsg

    def publish(self, *args: Any, **fields: Any) -> None:
        """Publish a message. Returns at once; a slow subscriber loses the oldest messages beyond ``queue_size``.

        Args:
            args: one message, or the values of all its fields in order.
            fields: the values of some fields by name.

        Raises:
            SerializationError: the message is of another type; or a value does not fit its field, which is noticed only
                when somebody listens, or the topic is latched.
            NodeError: the publisher was unregistered.
            TypeError: wrong number of values, or positional and named ones mixed.
            AttributeError: no field of that name.
        """
        if self._unregister is None:
            raise NodeError(f"publish() on {self.name}, which was unregistered or whose node has shut down")
        if len(args) == 1 and not fields:
            message = args[0]
            if isinstance(message, self.type):
                if self._raw and (self._publication.latch or self._publication.message_class is not AnyMsg):
                    self._publication.publish_body(message._buff, self)  # type: ignore[attr-defined]
                else:
                    self._publication.publish(message)
                return
            if hasattr(message, "_md5sum") and not isinstance(message, type):
                self._publish_other(message)
                return
        self._publication.publish(self.type(*args, **fields))

    def _publish_other(self, message: Any) -> None:
        """Publish a message of another class: good if it is of the same type, from another definition or generator or
        still encoded, or is the value of the type's only field."""
        publication = self._publication
        name, md5sum = message._type, message._md5sum
        if isinstance(message, AnyMsg):  # one that was received says what it is
            header = message._connection_header or {}
            name, md5sum = header.get("type", ANY), header.get("md5sum", ANY)
        if isinstance(message, AnyMsg) and md5sum in (ANY, publication.type.md5sum):
            publication.publish_body(message._buff)
        elif isinstance(message, Message) and md5sum == publication.type.md5sum:
            publication.publish(message)
        elif not self._raw and md5sum == publication.type.md5sum:
            # What other generators make has the same fields, but does not encode itself as ours do.
            publication.publish(self.type._copy(message))  # type: ignore[attr-defined]
        elif not self._raw and self._is_only_field(md5sum):
            publication.publish(self.type(message))  # type: ignore[call-arg]
        else:
            wanted = publication.type
            reason = f"not {name}" if name != wanted.name else f"with md5sum {wanted.md5sum}, not {md5sum}"
            raise SerializationError(f"{self.name} carries {wanted.name}, {reason}")

    def _is_only_field(self, md5sum: str) -> bool:
        """Whether the type has but one field, which is a message with that sum."""
        cls: Any = message_class(self.type)
        nested = cls._classes.get(cls._slot_types[0]) if len(cls._slot_types) == 1 else None
        return nested is not None and bool(nested._md5sum == md5sum)

    @property
    def num_connections(self) -> int:
        """Number of connected subscribers."""
        return len(self._publication.links)

    @property
    def dropped(self) -> int:
        """Messages that slow subscribers have lost, all together, as far as they are still connected."""
        return sum(link.dropped for link in self._publication.links)

    @property
    def waiting(self) -> int:
        """Messages that slow subscribers have not taken yet, all together."""
        return sum(link.waiting for link in self._publication.links)

    def wait_for_subscribers(self, count: int = 1, timeout: float | None = None) -> bool:
        """Wait until at least ``count`` subscribers are connected.

        Args:
            timeout: seconds; None waits until the node shuts down.

        Returns:
            Whether they are there.
        """
        return wait_for_links(self._publication, count, timeout)

    def unregister(self) -> None:
        """Stop publishing; the topic is unregistered with its last publisher in this node."""
        unregister, self._unregister = self._unregister, None
        if unregister is not None:
            self._publication.forget(self)
            unregister()

    def __enter__(self) -> Publisher[_M]:
        return self

    def __exit__(self, *_: object) -> None:
        self.unregister()


def topic_type(message_class: type[Any]) -> TopicType:
    """Return what a message class says about itself in connection headers."""
    if message_class._type == ANY:
        return TopicType(ANY, ANY, "")
    return TopicType(message_class._type, message_class._md5sum, message_class._full_text)
