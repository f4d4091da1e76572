"""Encodes each message only once for all clients that request it in the same form (no I/O)."""

from __future__ import annotations

import threading
from collections import OrderedDict
from collections.abc import Callable
from concurrent.futures import Future

from pyros1.web.hub import Arrival
from pyros1.web.server.sending import Frame, frame_size

_MAX_BYTES = 16 << 20
"""Maximum total size in bytes of the frames and messages that are kept; the newest is kept, whatever its size."""
_OVERHEAD = 1_000
"""Memory in bytes that a frame and a message need in addition to their contents."""
_Key = tuple[Arrival, str, str]


class SharedEncodings:
    """A cache of the most recent frames, for all clients. Thread-safe. Kept empty with fewer than two clients."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._num_clients = 0
        self._pending: dict[_Key, Future[Frame]] = {}  # frames that a thread is encoding
        self._frames: OrderedDict[_Key, Frame] = OrderedDict()
        self._size = 0

    def add_client(self) -> None:
        """Increase the number of clients."""
        with self._lock:
            self._num_clients += 1

    def remove_client(self) -> None:
        """Decrease the number of clients."""
        with self._lock:
            self._num_clients -= 1
            if self._num_clients < 2:
                self._frames.clear()
                self._size = 0

    def get(self, arrival: Arrival, form: str, topic: str, encode: Callable[[], Frame], may_wait: bool) -> Frame:
        """Return the frame for a message.

        Args:
            arrival: the message.
            form: the client's form of compression.
            topic: the topic's name as sent by the client.
            encode: creates the frame.
            may_wait: whether to wait if another thread is already encoding the message; otherwise it is encoded again.

        Raises:
            Error: raised by ``encode``.
        """
        if self._num_clients < 2:
            return encode()
        key = (arrival, form, topic)
        with self._lock:
            frame = self._frames.get(key)
            if frame is not None:
                return frame
            pending = self._pending.get(key)
            if pending is None:
                result: Future[Frame] = Future()
                self._pending[key] = result
        if pending is not None:
            return pending.result() if may_wait else encode()
        try:
            frame = encode()
        except BaseException as error:
            with self._lock:
                del self._pending[key]
            result.set_exception(error)
            raise
        with self._lock:
            del self._pending[key]
            if self._num_clients >= 2:
                self._keep(key, frame)
        result.set_result(frame)
        return frame

    def _keep(self, key: _Key, frame: Frame) -> None:
        self._frames[key] = frame
        self._size += _memory(key, frame)
        while self._size > _MAX_BYTES and len(self._frames) > 1:
            self._size -= _memory(*self._frames.popitem(last=False))


def _memory(key: _Key, frame: Frame) -> int:
    return frame_size(frame) + len(key[0].raw._buff) + _OVERHEAD
