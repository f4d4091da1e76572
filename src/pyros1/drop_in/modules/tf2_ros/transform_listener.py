"""TransformListener: fills a buffer from /tf and /tf_static."""

from __future__ import annotations

import threading
from typing import Any

import rospy
from tf2_py import BufferCore

from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.tf.fast_decoder import make_subscription_class
from pyros1.tf.listener import add_to_buffer


class TransformListener:
    """Adds transforms to a buffer, until the node shuts down or the listener is deleted.

    When time jumps back, the buffer is cleared, except for static transforms.

    Args:
        buffer: a BufferCore, or another object with its `set_transform`, `set_transform_static` and `clear`.
        queue_size, buff_size, tcp_nodelay: see rospy.Subscriber.

    Attributes:
        tf_sub, tf_static_sub: the subscribers.
        last_update: time of the last message.

    Raises:
        ROSInitException: the node has not been started.
    """

    def __init__(
        self, buffer: Any, queue_size: int | None = None, buff_size: int = 65536, tcp_nodelay: bool = False
    ) -> None:
        self.buffer = buffer
        self.last_update = rospy.Time.now()
        self.last_update_lock = threading.Lock()
        # Buffers get whole messages unless their class overrides these methods; then they get single transforms.
        buffer_class = type(buffer)
        self._accepts_whole_messages = isinstance(buffer, BufferCore) and (
            buffer_class.set_transform,
            buffer_class.set_transform_static,
        ) == (
            BufferCore.set_transform,
            BufferCore.set_transform_static,
        )
        options: dict[str, Any] = {"queue_size": queue_size, "buff_size": buff_size, "tcp_nodelay": tcp_nodelay}
        # Fast decoding is only used if no subclass overrides a callback.
        has_standard_callbacks = self._accepts_whole_messages and (type(self).callback, type(self).static_callback) == (
            TransformListener.callback,
            TransformListener.static_callback,
        )
        message_class = make_subscription_class(TFMessage) if has_standard_callbacks else TFMessage
        self.tf_sub = rospy.Subscriber("/tf", message_class, self.callback, **options)
        self.tf_static_sub = rospy.Subscriber("/tf_static", message_class, self.static_callback, **options)

    def __del__(self) -> None:
        self.unregister()

    def unregister(self) -> None:
        """Stop listening; the buffer keeps its transforms."""
        for name in ("tf_sub", "tf_static_sub"):
            if name in vars(self):  # missing if the constructor failed
                getattr(self, name).unregister()

    def check_for_reset(self) -> None:
        """Clear the buffer if time has jumped back."""
        with self.last_update_lock:
            now = rospy.Time.now()
            if now < self.last_update:
                jump = (self.last_update - now).to_sec()
                rospy.logwarn("Detected jump back in time of %fs. Clearing TF buffer.", jump)
                self.buffer.clear()
            self.last_update = now

    def callback(self, data: Any) -> None:
        """Handle a message on /tf."""
        self._handle_message(data, False)

    def static_callback(self, data: Any) -> None:
        """Handle a message on /tf_static."""
        self._handle_message(data, True)

    def _handle_message(self, data: Any, static: bool) -> None:
        self.check_for_reset()
        sender = (data._connection_header or {}).get("callerid", "default_authority")
        if self._accepts_whole_messages:
            add_to_buffer(self.buffer, data, sender, static=static)
            return
        set_transform = self.buffer.set_transform_static if static else self.buffer.set_transform
        for transform in data.transforms:
            set_transform(transform, sender)
