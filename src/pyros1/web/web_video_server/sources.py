"""The images on a topic, for all streams that show it: one subscription, and each image encoded once."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any, NamedTuple

from pyros1.msgs.sensor_msgs.msg import CompressedImage, Image
from pyros1.node import Node
from pyros1.web.web_video_server.pictures import render
from pyros1.web.web_video_server.requests import Rendering


class Frame(NamedTuple):
    """An image that arrived.

    Attributes:
        number: the image's number, counted from 1.
        message: the image.
        arrived_at: the monotonic time of arrival in seconds.
    """

    number: int
    message: Any
    arrived_at: float


class Source:
    """The newest image on a topic.

    Args:
        node: the node that subscribes.
        topic: the topic's full name.
        is_compressed: whether the topic has compressed images.
    """

    def __init__(self, node: Node, topic: str, is_compressed: bool) -> None:
        self.num_users = 0
        self._changed = threading.Condition()
        self._frame: Frame | None = None
        self._closed = False
        self._encode_lock = threading.Lock()
        self._encoded: dict[Rendering, tuple[int, bytes]] = {}
        message_class = CompressedImage if is_compressed else Image
        self._subscriber = node.subscribe(topic, message_class, self._on_message, queue_size=1)

    def _on_message(self, message: Any) -> None:
        with self._changed:
            number = self._frame.number + 1 if self._frame else 1
            self._frame = Frame(number, message, monotonic())
            self._changed.notify_all()

    @property
    def is_closed(self) -> bool:
        """Whether no more images will arrive."""
        return self._closed

    @property
    def newest(self) -> Frame | None:
        """The newest image; None if none has arrived."""
        return self._frame

    def wait(self, after: int, timeout: float) -> Frame | None:
        """Wait for an image; return None if none arrives in time, or the source is closed.

        Args:
            after: the number of the last image that the caller has seen; 0 for none.
            timeout: maximum number of seconds to wait.
        """
        deadline = monotonic() + timeout
        with self._changed:
            while not self._closed and (self._frame is None or self._frame.number <= after):
                remaining = deadline - monotonic()
                if remaining <= 0.0:
                    return None
                self._changed.wait(remaining)
            return None if self._closed else self._frame

    def encode(self, frame: Frame, rendering: Rendering) -> bytes:
        """Return an image as a file, which is made only once if several streams request the same.

        Raises:
            MessageError: the image cannot be converted.
        """
        with self._encode_lock:
            number, data = self._encoded.get(rendering, (0, b""))
            if number != frame.number:
                data = render(frame.message, rendering)
                if len(self._encoded) >= self.num_users:  # some belong to streams that have ended
                    self._encoded.clear()
                self._encoded[rendering] = frame.number, data
            return data

    def close(self) -> None:
        """Unsubscribe, and end all waits."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()
        self._subscriber.unregister()


class Sources:
    """The sources in use.

    Args:
        node: the node that subscribes.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()
        self._sources: dict[tuple[str, bool], Source] = {}
        self._closed = False

    @contextmanager
    def use(self, topic: str, is_compressed: bool) -> Iterator[Source]:
        """Return a context manager with a topic's source, which is shared, and closed when nobody uses it any more.

        Args:
            topic: the topic's full name.
            is_compressed: whether the topic has compressed images.
        """
        key = (topic, is_compressed)
        with self._lock:
            source = self._sources.get(key)
            if source is None:
                source = self._sources[key] = Source(self._node, topic, is_compressed)
                if self._closed:
                    source.close()
            source.num_users += 1
        try:
            yield source
        finally:
            with self._lock:
                source.num_users -= 1
                if not source.num_users:
                    del self._sources[key]
                    source.close()

    def close(self) -> None:
        """Close all sources, including any that are requested later."""
        with self._lock:
            self._closed = True
            for source in self._sources.values():
                source.close()
