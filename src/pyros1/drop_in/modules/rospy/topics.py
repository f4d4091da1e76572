"""Publishers and subscribers (https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers)."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import pyros1
from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import SerializationError
from rospy.exceptions import ROSException, ROSSerializationException
from rospy.msg import AnyMsg, args_kwds_to_message
from rospy.names import resolve_name

DEFAULT_BUFF_SIZE = 65536


class SubscribeListener:
    """Is told when subscribers of a publisher come and go."""

    def peer_subscribe(self, topic_name: str, topic_publish: Callable[[Any], None], peer_publish: Any) -> None:
        """A subscriber has come.

        Args:
            topic_name: full name of the topic.
            topic_publish: publishes to all subscribers.
            peer_publish: publishes to the new one only.
        """

    def peer_unsubscribe(self, topic_name: str, num_peers: int) -> None:
        """A subscriber has gone; ``num_peers`` are left."""


class Topic:
    """Base of Publisher and Subscriber.

    Attributes:
        name: full name, remapped. resolved_name: the same.
        type: name of the message type. data_class: its class. md5sum: of its definition.
        reg_type: "pub" or "sub".
    """

    reg_type = ""

    def __init__(self, name: str, data_class: Any) -> None:
        if not name or not isinstance(name, str):
            raise ValueError("topic name is not a non-empty string")
        if data_class is None:
            raise ValueError("topic parameter 'data_class' is not initialized")
        if not isinstance(data_class, type):
            raise ValueError(f"data_class [{data_class}] is not a class")
        if not hasattr(data_class, "_md5sum"):
            raise ValueError(f"data_class [{data_class.__class__.__name__}] is not a message data class")
        self.resolved_name = self.name = resolve_name(name)
        self.data_class = data_class
        self.type: str = data_class._type  # type: ignore[attr-defined]
        self.md5sum = data_class._md5sum
        self._handle: Any = None
        self._closed = False
        PROCESS.when_started(self._start)

    def _open(self, node: pyros1.Node) -> Any:
        raise NotImplementedError

    def _start(self, node: pyros1.Node) -> None:
        if not self._closed and node.ok():
            self._handle = self._open(node)

    def get_num_connections(self) -> int:
        """Return the number of connected peers."""
        return self._handle.num_connections if self._handle is not None else 0

    def unregister(self) -> None:
        """End this publisher or subscriber."""
        self._closed = True
        PROCESS.forget(self._start)
        if self._handle is not None:
            self._handle.unregister()


class Publisher(Topic):
    """A published topic.

    Args:
        name: topic.
        data_class: message class.
        subscriber_listener: told of subscribers that come and go.
        tcp_nodelay: accepted as in rospy; subscribers ask for it themselves, too.
        latch: whether later subscribers get the last message.
        headers: further fields of the connection header.
        queue_size: messages that wait for each slow subscriber; None: `publish` waits.
    """

    reg_type = "pub"

    def __init__(
        self,
        name: str,
        data_class: Any,
        subscriber_listener: SubscribeListener | None = None,
        tcp_nodelay: bool = False,
        latch: bool = False,
        headers: dict[str, str] | None = None,
        queue_size: int | None = None,
    ) -> None:
        if queue_size is None:
            text = (
                "The publisher should be created with an explicit keyword argument 'queue_size'. Please see "
                "http://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers for more information."
            )
            warnings.warn(text, SyntaxWarning, stacklevel=2)
        self._queue_size = queue_size
        self._latch = latch
        self._headers = headers
        self._listener = subscriber_listener
        super().__init__(name, data_class)

    def _open(self, node: pyros1.Node) -> Any:
        return node.advertise(
            self.resolved_name, self.data_class, queue_size=self._queue_size, latch=self._latch, headers=self._headers
        )

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Publish a message, or the values of its fields.

        Raises:
            ROSException: there is no node yet; or the publisher was unregistered.
            ROSSerializationException: a value does not fit its field.
        """
        if self._handle is None and PROCESS.node is None:
            raise ROSException("ROS node has not been initialized yet. Please call init_node() first")
        if self._closed or self._handle is None:
            raise ROSException("publish() to a closed topic")
        message = args_kwds_to_message(self.data_class, args, kwds)
        try:
            self._handle.publish(message)
        except SerializationError as error:
            raise ROSSerializationException(str(error)) from error


class Subscriber(Topic):
    """A subscription.

    Args:
        name: topic.
        data_class: message class, or AnyMsg.
        callback: called with each message, and ``callback_args`` if that is not None.
        queue_size: messages of each publisher that wait for a slow callback; None: no limit.
        buff_size, tcp_nodelay: as in rospy.
    """

    reg_type = "sub"

    def __init__(
        self,
        name: str,
        data_class: Any,
        callback: Callable[..., object] | None = None,
        callback_args: Any = None,
        queue_size: int | None = None,
        buff_size: int = DEFAULT_BUFF_SIZE,
        tcp_nodelay: bool = False,
    ) -> None:
        self.callback = callback
        self.callback_args = callback_args
        self._queue_size = queue_size
        self._nodelay = tcp_nodelay
        super().__init__(name, data_class)

    def _open(self, node: pyros1.Node) -> Any:
        callback, extra = self.callback, self.callback_args
        if callback is None:
            return node.subscribe(self.resolved_name, self.data_class, lambda _: None, queue_size=self._queue_size)
        call = callback if extra is None else lambda message: callback(message, extra)
        return node.subscribe(
            self.resolved_name, self.data_class, call, queue_size=self._queue_size, tcp_nodelay=self._nodelay
        )


__all__ = ["DEFAULT_BUFF_SIZE", "AnyMsg", "Publisher", "SubscribeListener", "Subscriber", "Topic"]
