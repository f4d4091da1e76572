"""Encodes each message only once for all clients that request it in the same form (no I/O)."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future

from pyros1.web.hub import Arrival
from pyros1.web.rosbridge.outbox import Frame

_MAX_BYTES = 16 << 20
"""Maximum total size in bytes of the frames and messages that are kept; the newest is kept, whatever its size."""
_OVERHEAD = 1_000
"""Memory in bytes that a frame and a message need in addition to their contents."""
_Key = tuple[Arrival, str, str]


class SharedEncodings:
    """The most recent frames of all clients. Thread-safe.

    Attributes:
        num_clients: number of clients that use this object; with fewer than two, no frames are kept.
    """

    def __init__(self) -> None:
        self.num_clients = 0
        self._lock = threading.Lock()
        self._frames: OrderedDict[_Key, Future[Frame]] = OrderedDict()
        self._size = 0

    def get(self, arrival: Arrival, form: str, topic: str, encode: Callable[[], Frame]) -> Frame:
        """Return the frame for a message.

        If another thread is just encoding it, wait for that.

        Args:
            arrival: the message.
            form: the client's form of compression.
            topic: the topic's name as sent by the client.
            encode: creates the frame.

        Raises:
            Error: raised by ``encode``.
        """
        if self.num_clients < 2:
            return encode()
        key = (arrival, form, topic)
        with self._lock:
            found = self._frames.get(key)
            if found is None:
                mine: Future[Frame] = Future()
                self._frames[key] = mine
        if found is not None:
            return found.result()
        try:
            frame = encode()
        except BaseException as error:
            with self._lock:
                self._frames.pop(key, None)
            mine.set_exception(error)
            raise
        mine.set_result(frame)
        with self._lock:
            self._size += _memory(key, frame)
            while self._size > _MAX_BYTES and len(self._frames) > 1:
                oldest, future = next(iter(self._frames.items()))
                if not future.done():
                    break
                del self._frames[oldest]
                self._size -= _memory(oldest, future.result())
        return frame


def _memory(key: _Key, frame: Frame) -> int:
    return len(frame) + len(key[0].raw._buff) + _OVERHEAD
