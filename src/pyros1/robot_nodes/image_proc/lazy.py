"""Subscribing only while somebody subscribes to what is made of it, as stock's image nodes do."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from pyros1.filters import Subscriber, Synchronizer
from pyros1.ground.errors import NodeShutdownError
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.node import Node

Ending = Callable[[], object]
"""Ends a subscription."""


class Lazy:
    """Calls a function when the first subscriber of some publishers comes, and another when the last one has left.

    Args:
        publishers: the publishers.
        start: subscribes; returns functions that end it.
    """

    def __init__(self, publishers: Sequence[Any], start: Callable[[], list[Ending]]) -> None:
        self._publishers = publishers
        self._start = start
        self._ends: list[Ending] = []
        self._lock = threading.Lock()
        for publisher in publishers:
            publisher.watch(joined=lambda peer: self._update(), left=lambda peer: self._update())

    def _update(self) -> None:
        with self._lock:
            is_wanted = any(publisher.num_connections for publisher in self._publishers)
            if is_wanted and not self._ends:
                with suppress(NodeShutdownError):
                    self._ends = self._start()
            elif not is_wanted:
                for end in self._ends:
                    end()
                self._ends = []


def subscribe_camera(node: Node, image: str, callback: Callable[[Any, Any], object], queue_size: int) -> list[Ending]:
    """Subscribe to images and the camera_info beside them, and call a function with those of the same time.

    Args:
        node: the node.
        image: the images' topic.
        callback: called with image and camera_info.
        queue_size: how many of each wait for the other.

    Returns:
        Functions that end it.
    """
    topics = {node.resolve(image): Image, info_topic(node, image): CameraInfo}
    inputs = [Subscriber(node, name, cls, queue_size=queue_size) for name, cls in topics.items()]
    Synchronizer(inputs, queue_size).connect(callback)
    return [source.close for source in inputs]


def info_topic(node: Node, image: str) -> str:
    """Return the topic of the camera_info that belongs to images: it is in the same namespace."""
    return node.resolve(node.resolve(image).rpartition("/")[0] + "/camera_info")
