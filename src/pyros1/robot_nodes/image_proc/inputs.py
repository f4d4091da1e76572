"""Subscriptions to images and their camera_info."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.filters import Subscriber, Synchronizer
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image
from pyros1.node import Node

Ending = Callable[[], object]
"""A function that ends a subscription."""


def subscribe_camera(node: Node, image: str, callback: Callable[[Any, Any], object], queue_size: int) -> list[Ending]:
    """Subscribe to images and their camera_info, and call a function with each pair that has the same timestamp.

    Args:
        node: the node.
        image: the images' topic.
        callback: called with image and camera_info.
        queue_size: maximum number of messages per topic that wait for their counterpart.

    Returns:
        Functions that end the subscriptions.
    """
    topics = {node.resolve(image): Image, info_topic(node, image): CameraInfo}
    inputs = [Subscriber(node, name, cls, queue_size=queue_size) for name, cls in topics.items()]
    Synchronizer(inputs, queue_size).connect(callback)
    return [source.close for source in inputs]


def info_topic(node: Node, image: str) -> str:
    """Return the camera_info topic that belongs to an image topic: it is in the same namespace."""
    return node.resolve(node.resolve(image).rpartition("/")[0] + "/camera_info")
