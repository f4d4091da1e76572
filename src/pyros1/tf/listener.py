"""Fills a buffer with the transforms from /tf and /tf_static."""

from __future__ import annotations

import threading
from contextlib import suppress
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import NodeError
from pyros1.msgs import load_message
from pyros1.tf.fast_decoder import ReceivedTransforms, make_subscription_class

if TYPE_CHECKING:
    from pyros1.node import Node
    from pyros1.tf.buffer import Buffer

_QUEUE_SIZE = 100


class TransformListener:
    """Adds transforms from /tf and /tf_static to a buffer until the listener is closed or the node shuts down. A
    context manager that closes the listener on exit.

    The callbacks run in separate threads, even in a node with ``callbacks="spin"``, since the thread that spins may be
    blocked in a lookup.
    When simulated time jumps back, the buffer is cleared except for static transforms. The service ``~tf2_frames``
    returns a description of the buffer's frames.

    Args:
        node: the node whose topics and time are used.
        buffer: the buffer to fill.
    """

    def __init__(self, node: Node, buffer: Buffer) -> None:
        self.buffer = buffer
        self._node = node
        self._lock = threading.RLock()
        self._last_time = node.now()
        self._closed = False
        self._subscribers: list[Any] = []
        if buffer.warn is None:
            buffer.warn = lambda text: node.log.warn("%s", text)
        message_class = make_subscription_class(load_message("tf2_msgs/TFMessage"))
        if node.params.get("/use_sim_time", False) is True:
            buffer.use_time(lambda: node.now().to_sec())
            # never unsubscribed, since lookups that wait in the buffer need the clock even after `close`
            self._subscribe("/clock", load_message("rosgraph_msgs/Clock"), self._on_clock, 1)
        self._subscribers = [
            self._subscribe("/tf", message_class, self._on_transforms, _QUEUE_SIZE),
            self._subscribe("/tf_static", message_class, self._on_static_transforms, None),
        ]
        node.on_shutdown(self._on_shutdown)
        with suppress(NodeError):  # the node already has another listener
            node.advertise_service("~tf2_frames", "tf2_msgs/FrameGraph", lambda _: buffer.all_frames_as_yaml())

    def _subscribe(self, topic: str, message_class: Any, callback: Any, queue_size: int | None) -> Any:
        # Called directly, not through the queue of a node that spins, since that thread may be blocked in a lookup.
        topics = self._node._topics
        name = self._node.resolve(topic)
        return topics.subscribe(name, message_class, callback, queue_size, direct=True)

    def _on_transforms(self, message: Any) -> None:
        self._clear_if_time_jumped_back()
        add_to_buffer(self.buffer, message, _sender_name(message), static=False)

    def _on_static_transforms(self, message: Any) -> None:
        self._clear_if_time_jumped_back()
        add_to_buffer(self.buffer, message, _sender_name(message), static=True)

    def _on_clock(self, _: Any) -> None:
        self._clear_if_time_jumped_back()
        self.buffer.wake()

    def _clear_if_time_jumped_back(self) -> None:
        with self._lock:
            now = self._node.now()
            jump = (now - self._last_time).to_sec()
            self._last_time = now
            if jump < 0 and not self._closed:
                self.buffer.clear()  # with the lock held, so that transforms with the new time are not removed
        if jump < 0 and not self._closed:
            self._node.log.warn("Detected jump back in time of %fs. Clearing TF buffer.", -jump)

    def _on_shutdown(self) -> None:
        self.buffer.end_waits()

    def close(self) -> None:
        """Stop listening; the buffer keeps its transforms."""
        self._closed = True
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._subscribers = []

    def __enter__(self) -> TransformListener:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def add_to_buffer(buffer: Any, message: Any, sender: str, *, static: bool) -> None:
    """Add the transforms of a TFMessage, or of `ReceivedTransforms`, to a buffer."""
    if message.__class__ is ReceivedTransforms:
        buffer.set_rows(message.rows, sender, static=static)
    else:
        buffer.set_transforms(message.transforms, sender, static=static)


def _sender_name(message: Any) -> str:
    header = message._connection_header
    return header.get("callerid", "default_authority") if header else "default_authority"
