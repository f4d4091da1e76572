"""The user's handle for a published topic.

https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Generic, SupportsFloat, SupportsIndex, TypeVar, overload

from pyros1.ground.errors import NodeError, SerializationError
from pyros1.ground.timing import Duration, Time
from pyros1.msgs import AnyMsg, Message
from pyros1.msgs.base import Array, message_class, nested_classes
from pyros1.node.context import wait_for_links
from pyros1.node.publishing.peers import PeerCallback, PeerWatch
from pyros1.wire.handshake import WILDCARD

if TYPE_CHECKING:
    from pyros1.node.publishing.publication import Publication
    from pyros1.node.publishing.publisher_links import Link

_M = TypeVar("_M")
_Value = SupportsFloat | SupportsIndex | str | Time | Duration | Array


class Publisher(Generic[_M]):
    """The user's handle for a published topic; created by ``Node.advertise``. As a context manager, it unregisters on
    exit.

    Attributes:
        name: the topic's full name.
        type: the message class.
    """

    def __init__(self, publication: Publication, message_class: type[_M], unregister: Callable[[], None]) -> None:
        self.name = publication.topic
        self.type = message_class
        self._publication = publication
        self._unregister: Callable[[], None] | None = unregister
        self._is_raw = message_class is AnyMsg

    # For type checkers: a message must be of the topic's type; the type of a single value depends on the definition.
    @overload
    def publish(self, message: _M, /) -> None: ...
    @overload
    def publish(self, value: _Value, /) -> None: ...
    @overload
    def publish(self, first: object, second: object, /, *more: object) -> None: ...
    @overload
    def publish(self, **fields: object) -> None: ...
    def publish(self, *args: Any, **fields: Any) -> None:
        """Publish a message. Returns immediately; a slow subscriber loses the oldest messages beyond ``queue_size``.

        Thread-safe, and allowed in signal handlers. If a handler interrupts `publish` on the same topic, the handler's
        message is sent after the interrupted one; or before it, if that `publish` had only just begun.

        Args:
            args: one message, or the values of all its fields in order.
            fields: the values of some fields by name.

        Raises:
            SerializationError: the message is of another type; or a value does not fit its field, which is noticed only
                if there are subscribers or the topic is latched.
            NodeError: the publisher has been unregistered.
            TypeError: wrong number of values, or positional and named values mixed, or a class instead of a message.
            AttributeError: the type has no field of that name.
        """
        if self._unregister is None:
            raise NodeError(f"publish() on {self.name}: it was unregistered, or its node has shut down")
        if len(args) == 1 and not fields:
            message = args[0]
            if isinstance(message, self.type):
                if self._is_raw and (self._publication.latch or self._publication.message_class is not AnyMsg):
                    self._publication.publish_body(message._buff, self)  # type: ignore[attr-defined]
                else:
                    self._publication.publish(message)
                return
            if isinstance(message, type) and hasattr(message, "_md5sum"):
                name = message.__name__
                raise TypeError(f"publish() on {self.name}: {name} is a class: pass a message, {name}(...)")
            if hasattr(message, "_md5sum"):
                self._publish_other(message)
                return
            if self._is_raw:
                self._check_bytes(message)
        self._publication.publish(self.type(*args, **fields))

    def _check_bytes(self, data: Any) -> None:
        try:
            memoryview(data)
        except TypeError:
            raise TypeError(f"publish() on {self.name} takes an AnyMsg or its bytes, not {data!r:.80}") from None

    def _publish_other(self, message: Any) -> None:
        """Publish a message of another class.

        The message may be of the same type, but from another definition or generator, or still encoded; or it may be
        the value of the type's only field.
        """
        publication = self._publication
        name, md5sum = message._type, message._md5sum
        if isinstance(message, AnyMsg):  # if the message was received, its header has the type
            header = message._connection_header or {}
            name, md5sum = header.get("type", WILDCARD), header.get("md5sum", WILDCARD)
        if isinstance(message, AnyMsg) and md5sum in (WILDCARD, publication.type.md5sum):
            publication.publish_body(message._buff)
        elif isinstance(message, Message) and md5sum == publication.type.md5sum:
            publication.publish(message)
        elif not self._is_raw and md5sum == publication.type.md5sum:
            # Messages from other generators have the same fields, but different encoding methods.
            publication.publish(self.type._copy(message))  # type: ignore[attr-defined]
        elif not self._is_raw and self._is_only_field(md5sum):
            publication.publish(self.type(message))  # type: ignore[call-arg]
        else:
            topic_type = publication.type
            reason = f"not {name}" if name != topic_type.name else f"with md5sum {topic_type.md5sum}, not {md5sum}"
            raise SerializationError(f"{self.name} carries {topic_type.name}, {reason}")

    def _is_only_field(self, md5sum: str) -> bool:
        """Return whether the type has only one field, and that field is a message with the given md5 sum."""
        cls: Any = message_class(self.type)
        nested = nested_classes(cls).get(cls._slot_types[0]) if len(cls._slot_types) == 1 else None
        return nested is not None and bool(nested._md5sum == md5sum)

    @property
    def num_connections(self) -> int:
        """Number of connected subscribers."""
        return len(self._publication.links)

    @property
    def dropped(self) -> int:
        """Number of messages dropped because connected subscribers were too slow."""
        return sum(link.dropped for link in self._publication.links)

    @property
    def waiting(self) -> int:
        """Total number of messages that are queued for slow subscribers."""
        return sum(link.waiting for link in self._publication.links)

    @property
    def links(self) -> tuple[Link, ...]:
        """The links to the topic's subscribers, each with ``peer`` (the node's name), ``transport``, ``address``, and
        the numbers of ``messages`` and ``bytes_sent`` so far.
        """
        return self._publication.links

    def watch(self, joined: PeerCallback = lambda _: None, left: PeerCallback = lambda _: None) -> PeerWatch:
        """Call functions when subscribers connect, including those already connected, and when they disconnect.

        The calls are made one at a time, in a separate thread.

        Args:
            joined: called with a `Peer`, whose ``publish(message)`` sends to that subscriber only.
            left: called with the `Peer` that has disconnected.

        Returns:
            An object whose `close` stops the calls.
        """
        return PeerWatch(self._publication, joined, left, self._publication.context.log)

    def wait_for_subscribers(self, count: int = 1, timeout: float | None = None) -> bool:
        """Wait until at least ``count`` subscribers are connected.

        Args:
            count: the minimum number of subscribers.
            timeout: maximum number of seconds to wait; None waits until the node shuts down.

        Returns:
            Whether that many subscribers are connected.
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
