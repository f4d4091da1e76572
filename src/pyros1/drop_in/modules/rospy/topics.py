"""Publishers and subscribers (https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers)."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import pyros1
from pyros1.drop_in.module_attributes import module_hooks as _module_hooks
from pyros1.drop_in.process import PROCESS
from pyros1.ground.errors import MasterError, NodeError, NodeShutdownError, SerializationError
from pyros1.ground.names import canonicalize_name
from rospy.core import *  # noqa: F403  stock's module has these names as well
from rospy.core import logfatal
from rospy.exceptions import ROSException, ROSSerializationException
from rospy.impl.encoding_errors import fill_in_frame_id, stock_error_for
from rospy.impl.registration import Registration, get_topic_manager
from rospy.impl.topic_impls import PublisherImpl as _PublisherImpl
from rospy.impl.topic_impls import SubscriberImpl as _SubscriberImpl
from rospy.impl.topic_impls import TopicImpl as _TopicImpl
from rospy.impl.topic_impls import TopicManager as _TopicManager
from rospy.msg import AnyMsg, Message, args_kwds_to_message, serialize_message
from rospy.names import (
    LAZY_IMPORTS,
    normalize_name_argument,
    resolve_name,
    resolve_name_without_node_name,
    warn_if_illegal_name,
)

DEFAULT_BUFF_SIZE = 65536
python3 = 1
TOPICS = _TopicManager()
"""The topics of this program."""
_NO_QUEUE_SIZE = (
    "The publisher should be created with an explicit keyword argument 'queue_size'. "
    "Please see http://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers for more information."
)
_UNREGISTERED = "publish() to an unregistered() handle"
_NO_NODE = "ROS node has not been initialized yet. Please call init_node() first"


class SubscribeListener:
    """Is notified when subscribers of a publisher connect and disconnect. Programs override its methods."""

    def peer_subscribe(
        self, topic_name: str, topic_publish: Callable[..., None], peer_publish: Callable[[Any], None]
    ) -> None:
        """Handle a new subscriber.

        Args:
            topic_name: full name of the topic.
            topic_publish: publishes to all subscribers.
            peer_publish: publishes only to the new connection.
        """

    def peer_unsubscribe(self, topic_name: str, num_peers: int) -> None:
        """Handle the disconnection of a subscriber; ``num_peers`` remain."""


class Topic:
    """Base class of Publisher and Subscriber.

    Args:
        name: name of the topic; remappings apply to it.
        data_class: class of the messages.
        reg_type: "pub" or "sub".

    Attributes:
        name, resolved_name: full name.
        type, data_class, md5sum: name of the message type, its class, and md5 sum.
        reg_type: "pub" or "sub".
        impl: the topic's connections, shared by all publishers or subscribers of the topic; None after `unregister`.

    Raises:
        ValueError: an argument is invalid.
        TypeError: ``reg_type`` is invalid.
    """

    impl: Any

    def __init__(self, name: str, data_class: Any, reg_type: str) -> None:
        if not name or not isinstance(name, str):
            raise ValueError("topic name is not a non-empty string")
        if data_class is None:
            raise ValueError("topic parameter 'data_class' is not initialized")
        if not isinstance(data_class, type):
            raise ValueError(f"data_class [{data_class}] is not a class")
        if not hasattr(data_class, "_md5sum") or hasattr(data_class, "_request_class"):  # services are not messages
            raise ValueError(f"data_class [{data_class.__class__.__name__}] is not a message data class")
        self._unresolved_name = canonicalize_name(normalize_name_argument(name))
        warn_if_illegal_name(name, 4)
        resolve = resolve_name if PROCESS.node is not None else resolve_name_without_node_name
        self.name = self.resolved_name = resolve(name)
        self.data_class = data_class
        self.type: str = data_class._type  # type: ignore[attr-defined]
        self.md5sum: str = data_class._md5sum
        self.reg_type = reg_type
        if reg_type not in (Registration.PUB, Registration.SUB):
            raise TypeError(f"invalid reg_type: {reg_type}")
        self.impl = TOPICS.acquire_impl(reg_type, self.resolved_name, data_class)
        self._handle: Any = None

    def _start(self, node: pyros1.Node) -> None:
        """Register the topic when the node has been started. After the node's shutdown, do nothing, like stock."""
        impl, reason = self.impl, None
        if impl is None or not node.ok():
            return
        for data_class in (self.data_class, impl.data_class):  # stock uses the class of the topic's first object
            try:
                handle = self._open(node, data_class, impl)
                break
            except NodeShutdownError:
                return
            except (NodeError, MasterError) as error:
                reason = error
        else:
            logfatal("unable to register [%s] with the master: %s", self.name, reason)
            return
        with TOPICS.lock:
            if self.impl is not None:
                self._handle = handle
                impl.handles = [*impl.handles, handle]
                return
        handle.unregister()  # another thread, such as its callback's, has closed this object in the meantime

    def _open(self, node: pyros1.Node, data_class: Any, impl: Any) -> Any:
        raise NotImplementedError

    def get_num_connections(self) -> int:
        """Return the number of connected peers."""
        return self.impl.get_num_connections()

    def unregister(self) -> None:
        """Close this publisher or subscriber; the topic is unregistered with the last one in the program."""
        PROCESS.remove_start_callback(self._start)
        with TOPICS.lock:
            impl, self.impl = self.impl, None
            handle, self._handle = self._handle, None
            if impl is None:
                return
            impl.handles = [other_handle for other_handle in impl.handles if other_handle is not handle]
            self._detach(impl)
        if handle is not None:
            handle.unregister()
        TOPICS.release_impl(self.reg_type, self.resolved_name)

    def _detach(self, impl: Any) -> None:
        """Remove everything that this object has added to the topic."""


class Publisher(Topic):
    """A published topic.

    Args:
        name: name of the topic.
        data_class: message class.
        subscriber_listener: a `SubscribeListener`.
        tcp_nodelay: accepted for compatibility; single messages are never delayed.
        latch: whether new subscribers receive the last message.
        headers: additional fields of the connection header.
        queue_size: maximum number of messages queued for each slow subscriber; 0 for no limit. None to send
            synchronously: `publish` waits.
    """

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
            warnings.warn(_NO_QUEUE_SIZE, SyntaxWarning, stacklevel=2)
        elif not isinstance(queue_size, int) or queue_size < 0:
            queue_size = 0
        super().__init__(name, data_class, Registration.PUB)
        impl: _PublisherImpl = self.impl
        self._latch = latch
        self._headers = {str(key): str(value) for key, value in dict(headers or {}).items()}
        impl.add_headers(self._headers)
        if latch:
            impl.enable_latch()
        if queue_size is not None:
            impl.set_queue_size(queue_size)
        if subscriber_listener is not None:
            impl.add_subscriber_listener(subscriber_listener)
        PROCESS.add_start_callback(self._start)

    def _start(self, node: pyros1.Node) -> None:
        super()._start(node)
        impl = self.impl
        if impl is not None:
            impl.start_notifications()

    def _open(self, node: pyros1.Node, data_class: Any, impl: Any) -> Any:
        return node.advertise(
            self._unresolved_name, data_class, queue_size=impl.queue_size, latch=self._latch, headers=self._headers
        )

    def publish(self, *args: Any, **kwds: Any) -> None:
        """Publish a message, or the values of its fields.

        Args:
            args: a message, or the values of all its fields.
            kwds: the values of some fields by name.

        Raises:
            ROSException: the node has not been started, or the publisher was unregistered.
            ROSSerializationException: a value does not fit its field.
            AttributeError, UnicodeEncodeError: a value has a completely different type, see
                `rospy.impl.encoding_errors`.
            TypeError: the message is of another type, or positional and named values are mixed.
        """
        handle = self._handle or self._wait_for_handle()
        if handle is None:
            return
        if len(args) == 1 and args[0].__class__ is self.data_class and not kwds:
            message = args[0]
        else:
            message = args_kwds_to_message(self.data_class, args, kwds)
        try:
            handle.publish(message)
        except SerializationError as error:
            if not fill_in_frame_id(message):
                raise stock_error_for(error) from error
            self.publish(message)
        except NodeError:  # another thread has just unregistered this publisher
            raise ROSException(_UNREGISTERED) from None

    def _wait_for_handle(self) -> Any:
        """Wait for pyros1's publisher if the node is starting, and return it; None after the node's shutdown.

        Raises:
            ROSException: the node has not been started, or the publisher was unregistered.
        """
        if self.impl is None:
            raise ROSException(_UNREGISTERED)
        if PROCESS.node is None:
            raise ROSException(_NO_NODE)
        with PROCESS.start_lock:  # another thread holds the lock while it starts the node
            return self._handle


class Subscriber(Topic):
    """A subscription.

    Args:
        name: name of the topic.
        data_class: message class, numpy_msg(class), or AnyMsg.
        callback: called with each message, and ``callback_args`` if not None. Calls for one topic never overlap.
        queue_size: maximum number of messages of each publisher queued for a slow callback; None for no limit.
        buff_size, tcp_nodelay: accepted for compatibility.

    Raises:
        ROSException: ``queue_size`` or ``buff_size`` is invalid.
    """

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
        super().__init__(name, data_class, Registration.SUB)
        impl: _SubscriberImpl = self.impl
        try:
            impl.set_queue_size(queue_size)
            impl.set_buff_size(buff_size)
        except BaseException:
            TOPICS.release_impl(self.reg_type, self.resolved_name)
            raise
        self.callback = callback
        self.callback_args = callback_args
        self._queue_size = None if queue_size == -1 else queue_size
        self._entry = (callback, callback_args)
        if callback is not None:
            with TOPICS.lock:
                impl.callbacks.append(self._entry)
        if tcp_nodelay:
            impl.set_tcp_nodelay(tcp_nodelay)
        PROCESS.add_start_callback(self._start)

    def _open(self, node: pyros1.Node, data_class: Any, impl: Any) -> Any:
        from rospy.impl.rosout import with_error_logging

        on_message: Callable[[Any], object] = _ignore
        if self.callback is not None:
            callback, extra = self.callback, self.callback_args
            on_message = with_error_logging(
                callback if extra is None else lambda message: callback(message, extra), callback
            )
        return node.subscribe(
            self._unresolved_name, data_class, on_message, queue_size=self._queue_size, tcp_nodelay=True
        )

    def _start(self, node: pyros1.Node) -> None:
        super()._start(node)
        impl = self.impl
        if self._handle is not None and impl is not None and impl.ref_count == 1:
            impl.begin_statistics()

    def _detach(self, impl: Any) -> None:
        impl.callbacks = [entry for entry in impl.callbacks if entry is not self._entry]


def _ignore(_message: Any) -> None:
    """Ignore a message of a subscriber without a callback."""


_reason = "pyros1's nodes have their own links; see Publisher.impl.connections"
__getattr__, __dir__ = _module_hooks(
    __name__,
    {
        **LAZY_IMPORTS,
        "Log": "rosgraph_msgs.msg",
        "SubscriberStatisticsLogger": "rospy.impl.statistics",
    },
    dict.fromkeys(("Poller", "QueuedConnection", "get_tcpros_handler"), _reason),
)
