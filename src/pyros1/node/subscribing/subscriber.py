"""The user's handle for a subscription: holds the callback, and decodes messages into the form that the user
requests."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pyros1.ground.errors import NodeShutdownError
from pyros1.msgs import AnyMsg
from pyros1.msgs.base import View
from pyros1.msgs.large_arrays import Layout, SplitBody, decode_split, find_layout
from pyros1.node.context import wait_for_links

if TYPE_CHECKING:
    from pyros1.node.subscribing.deadline import Deadline
    from pyros1.node.subscribing.dispatcher import Stream
    from pyros1.node.subscribing.queues import Item, Source
    from pyros1.node.subscribing.subscription import Subscription

_M = TypeVar("_M")
Decode = Callable[..., Any]


def _make_view_decoder(cls: Any, view: View) -> Decode:
    if cls is AnyMsg:
        return AnyMsg._decode

    def decode(buffer: bytes, start: int, end: int, exact: bool = False) -> Any:
        return cls._decode_arrays(buffer, start, end, view, exact)

    return decode


class Subscriber(Generic[_M]):
    """A user's handle for a subscription; created by ``Node.subscribe``. As a context manager, it unregisters on exit.

    Attributes:
        name: the topic's full name.
        type: the message class.
        queue_size: maximum number of messages waiting for the callback; None for no limit.
        decode: creates a message from part of a buffer.
        stream: receives the messages undecoded, instead of the callback; None if there is a callback.
        direct: whether the callback runs in the receiving thread even in a node with ``callbacks="spin"``.
        in_publisher: whether the callback may run in the thread of a publisher in this process.
        native_class: class of the message objects that the callback can receive as they are; None if their arrays must
            be converted first.
    """

    def __init__(
        self,
        subscription: Subscription,
        message_class: type[_M],
        callback: Callable[[_M], object],
        queue_size: int | None,
        unregister: Callable[[Subscriber[Any]], None],
        direct: bool = False,
        view: View | None = None,
        stream: Stream | None = None,
        deadline: Deadline | None = None,
        in_publisher: bool = False,
    ) -> None:
        self.direct = direct or in_publisher
        self.in_publisher = in_publisher
        self.name = subscription.topic
        self.type = message_class
        self.queue_size = queue_size
        self.decode: Decode = message_class._decode if view is None else _make_view_decoder(message_class, view)  # type: ignore[attr-defined]  # Message or AnyMsg
        self.stream = stream
        self.native_class = message_class if view is None else None
        self._view = view
        self._subscription = subscription
        self._callback = callback
        self._deadline = deadline
        self._unregister: Callable[[Subscriber[Any]], None] | None = unregister

    @cached_property
    def _layout(self) -> Layout | None:
        decodes_itself = getattr(self.type, "_has_own_deserialize", False)  # AnyMsg does not have this attribute
        return None if decodes_itself else find_layout(self.type)

    def decode_item(self, item: Item, exact: bool = False) -> Any:
        """Return the message that an item contains, decoded if necessary.

        Args:
            item: a message, encoded or not.
            exact: whether an encoded message must use all its bytes.

        Raises:
            LengthError: an encoded message does not use all its bytes, and ``exact`` is True.
            MessageError: the item cannot be decoded.
        """
        if item.__class__ is self.native_class:
            return item
        if isinstance(item, SplitBody):
            return decode_split(self.type, self._layout, item, self._view, exact)
        if not isinstance(item, bytes):
            # A decoded message of the same type, whose class was made from another definition, or has other arrays.
            cls: Any = item.__class__
            item = cls._encode(item)
        body: bytes = item  # type: ignore[assignment]
        return self.decode(body, 0, len(body), exact)

    def call(self, message: _M) -> None:
        """Run the callback, unless the subscriber is unregistered, and log exceptions that it raises."""
        if self._unregister is None:
            return
        try:
            self._callback(message)
        except NodeShutdownError:
            pass  # the callback was waiting for something when the node began to shut down
        except SystemExit as error:
            if self._subscription.context.callback_queue is not None and not self.direct:
                raise  # the callback runs in the program's own thread
            text = f"callback of {self.name}: sys.exit() ends a program only from its main thread; call node.shutdown()"
            self._subscription.context.log.exception(text, error=error)
        except Exception as error:
            if not isinstance(error, KeyboardInterrupt):  # the base of rospy's exception for interrupted waits
                text = f"bad callback: {self._deadline or self._callback!r} of {self.name}"
                self._subscription.context.log.exception(text, error=error)

    def decode_for_stream(self, source: Source, item: Item) -> _M | None:
        """Decode an item that the stream has received; log it and return None if it cannot be decoded."""
        message: _M | None = self._subscription.dispatcher.decode_for_stream(self, source, item)
        return message

    def resume_publishers(self) -> None:
        """Receive again from publishers that were held back because the stream was full. Thread-safe."""
        self._subscription.delivery.wake()

    @property
    def links(self) -> tuple[Source, ...]:
        """The links to the topic's publishers, each with ``uri`` (of the node), its connection ``header``,
        ``transport``, ``address``, and the number of ``messages`` so far."""
        return self._subscription.links

    @property
    def num_connections(self) -> int:
        """Number of connected publishers."""
        return len(self._subscription.links)

    @property
    def dropped(self) -> int:
        """Number of messages dropped by this node because the callbacks were too slow."""
        return self._subscription.delivery.dropped

    def set_queue_size(self, size: int) -> None:
        """Change the number of messages that may wait for the callback; see ``queue_size``."""
        self.queue_size = size
        self._subscription.update_limit()

    def wait_for_publishers(self, count: int = 1, timeout: float | None = None) -> bool:
        """Wait until at least ``count`` publishers are connected.

        Args:
            count: the minimum number of publishers.
            timeout: maximum number of seconds to wait; None waits until the node shuts down.

        Returns:
            Whether that many publishers are connected.
        """
        return wait_for_links(self._subscription, count, timeout)

    def unregister(self) -> None:
        """Stop receiving; the topic is unregistered with its last subscriber in this node."""
        unregister, self._unregister = self._unregister, None
        if self._deadline is not None:
            self._deadline.close()
        if unregister is not None:
            unregister(self)

    def __enter__(self) -> Subscriber[_M]:
        return self

    def __exit__(self, *_: object) -> None:
        self.unregister()
