"""Broadcasters, which publish transforms."""

from __future__ import annotations

import copy
import threading
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from pyros1.msgs import load_message

if TYPE_CHECKING:
    from pyros1.node import Node


class TransformBroadcaster:
    """Publishes transforms on /tf, for frames that move.

    Args:
        node: the node that publishes.
    """

    def __init__(self, node: Node) -> None:
        self._message_class: Any = load_message("tf2_msgs/TFMessage")
        self._publisher = node.advertise("/tf", self._message_class, queue_size=100)

    def send_transform(self, transform: Any) -> None:
        """Publish a geometry_msgs/TransformStamped, or several in one message."""
        self._publisher.publish(self._message_class(_as_list(transform)))

    def close(self) -> None:
        """Stop publishing."""
        self._publisher.unregister()


class StaticTransformBroadcaster:
    """Publishes transforms that are valid at all times, latched, on /tf_static. One broadcaster per node is enough.

    Earlier transforms are sent again with each new one, since later subscribers receive only the last message; a new
    transform for the same child frame replaces the old one.

    Args:
        node: the node that publishes.
    """

    def __init__(self, node: Node) -> None:
        self._message_class: Any = load_message("tf2_msgs/TFMessage")
        self._publisher = node.advertise("/tf_static", self._message_class, queue_size=100, latch=True)
        self._lock = threading.RLock()  # a signal handler may send as well
        self._sent_transforms: dict[str, Any] = {}
        self._num_changes = 0

    def send_transform(self, transform: Any) -> None:
        """Publish a geometry_msgs/TransformStamped, or several."""
        with self._lock:
            for stamped_transform in _as_list(transform):
                # Copied, since programs reuse message objects.
                self._sent_transforms[stamped_transform.child_frame_id] = copy.deepcopy(stamped_transform)
            self._num_changes += 1
            num_published = 0
            # Repeated if a signal handler sends more in the meantime, since the last message must be complete.
            while num_published != self._num_changes:
                num_published = self._num_changes
                self._publisher.publish(self._message_class(list(self._sent_transforms.values())))

    def close(self) -> None:
        """Stop publishing; later subscribers will not receive the transforms."""
        self._publisher.unregister()


def _as_list(transform: Any) -> list[Any]:
    return list(transform) if isinstance(transform, Iterable) else [transform]
