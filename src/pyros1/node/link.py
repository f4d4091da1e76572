"""A publisher's link to one subscriber, over TCP.

`send` runs in the thread that publishes. States of a link, under its lock:

* *idle*: nothing waits. A message goes out at once, in this thread.
* *coalescing*: messages come faster than every HOT_GAP seconds, RUN_UP of them in a row. They gather in the queue and
  leave together: by the publishing thread when BATCH have gathered or WINDOW seconds passed, by the loop's timer when
  the publisher fell silent. A lone message never waits.
* *blocked*: the socket is full. Messages gather in the queue (the oldest are dropped whole); the loop sends when the
  socket takes more, and a publisher in a tight loop tries as well, because it seldom lets the loop thread run.
* *closed*.

The lock is never held while a socket is waited for: the loop takes it too.
"""

from __future__ import annotations

import contextlib
import select
import selectors
import socket
import threading
from collections.abc import Callable, Iterator
from math import inf
from time import perf_counter
from typing import Any

from pyros1.net.loop import Loop
from pyros1.wire.outqueue import Frame, OutQueue, frame_size

HOT_GAP = 30e-6
RUN_UP = 100
BATCH = 128
WINDOW = 100e-6
LINGER = 0.0005
"""Seconds after which the loop sends what the publisher left behind."""
SMALL = 4096


class SubscriberLink:
    """One connected subscriber.

    Args:
        loop: the node's loop.
        sock: connected and past the handshake; owned by the link from now on.
        header: the subscriber's connection header.
        greeting: our connection header, encoded; goes out first, see `starting`.
        queue_size: most waiting messages; 0 or None for no limit.
        on_closed: called once, on the loop, when the link is gone.

    Attributes:
        messages, bytes_sent: what was given to this link.
    """

    transport = "TCPROS"

    def __init__(
        self,
        loop: Loop,
        sock: socket.socket,
        header: dict[str, str],
        greeting: bytes,
        queue_size: int | None,
        on_closed: Callable[[SubscriberLink], None],
    ) -> None:
        self.header = header
        self.peer = header.get("callerid", "")
        self.messages = 0
        self.bytes_sent = 0
        self._loop = loop
        self._sock = sock
        self._fd = sock.fileno()
        self._on_closed = on_closed
        self._lock = threading.Lock()
        self._queue = OutQueue(queue_size)
        self._batch = 0 if queue_size is None else BATCH if queue_size == 0 else min(BATCH, queue_size // 2)
        self._idle = True
        self._blocked = False
        self._closed = False
        self._armed = False  # the loop's timer is set
        self._streak = 0
        self._last = 0.0
        sock.setblocking(False)
        self.address = _address_text(sock)
        self._greeting = greeting
        loop.call_soon(self._watch)

    @contextlib.contextmanager
    def starting(self) -> Iterator[None]:
        """Send the greeting at the end of the block; what others send meanwhile waits behind it.

        A subscriber that has the greeting counts on every message from then on, so the link is made known first.
        """
        with self._lock:
            yield
            self._send_now(self._greeting)
            self.bytes_sent = 0

    @property
    def dropped(self) -> int:
        """Messages thrown away because the subscriber was too slow."""
        return self._queue.dropped

    @property
    def waiting(self) -> int:
        """Messages that the subscriber has not taken yet."""
        return len(self._queue)

    @property
    def connected(self) -> bool:
        """Whether the link is up."""
        return not self._closed

    def send(self, frame: Frame) -> None:
        """Send a frame, or queue it. Never waits."""
        with self._lock:
            if self._closed:
                return
            self.messages += 1
            now = perf_counter()
            if self._idle:
                if self._batch > 1 and now - self._last < HOT_GAP:
                    self._streak += 1
                    if self._streak > RUN_UP and isinstance(frame, bytes) and len(frame) < SMALL:
                        self._idle = False
                        self._last = now
                        self._queue.push(frame)
                        self._arm()
                        return
                else:
                    self._streak = 0
                self._last = now
                self._send_now(frame)
                return
            self._queue.push(frame)
            if now - self._last > WINDOW or (len(self._queue) >= self._batch and not self._blocked):
                self._last = now
                self._flush()

    offer = send

    def _send_now(self, frame: Frame) -> None:
        try:
            sent = self._sock.send(frame) if isinstance(frame, bytes) else self._sock.sendmsg(frame)
        except BlockingIOError:
            sent = 0
        except OSError:
            self._fail()
            return
        self.bytes_sent += sent
        if sent == (len(frame) if isinstance(frame, bytes) else frame_size(frame)):
            return
        if sent:
            self._queue.push_begun(frame, sent)
        else:
            self._queue.push(frame)
        self._idle = False
        self._block()

    def _flush(self) -> None:
        """Send what waits, as much as the socket takes. Lock held."""
        queue = self._queue
        while parts := queue.buffers():
            try:
                if len(parts) > 4 and len(parts[0]) < SMALL and len(parts[-1]) < SMALL:
                    data = b"".join(parts)
                    sent, whole = self._sock.send(data), len(data)
                else:
                    sent, whole = self._sock.sendmsg(parts), sum(map(len, parts))
            except BlockingIOError:
                self._block()
                return
            except OSError:
                self._fail()
                return
            self.bytes_sent += sent
            queue.sent(sent)
            if sent < whole:
                self._block()
                return
        self._blocked = False
        if not self._armed:
            self._idle = True
            self._streak = 0

    def _arm(self) -> None:
        if not self._armed:
            self._armed = True
            self._loop.call_later(LINGER, self._linger_over)

    def _linger_over(self) -> None:
        """On the loop: send what the publisher left behind; keep the watch up while it is busy."""
        with self._lock:
            self._armed = False
            if self._closed or self._blocked:
                return
            busy = perf_counter() - self._last < LINGER
            self._flush()
            if busy and not self._closed and not self._blocked:
                self._idle = False
                self._arm()

    def _block(self) -> None:
        if not self._blocked:
            self._blocked = True
            self._loop.call_soon(self._want_writable)

    # On the loop ------------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        if not self._closed:
            self._loop.register(self._sock, selectors.EVENT_READ, self._on_event)

    def _want_writable(self) -> None:
        if not self._closed:
            self._loop.modify(self._sock, selectors.EVENT_READ | selectors.EVENT_WRITE, self._on_event)

    def _on_event(self, mask: int) -> None:
        if mask & selectors.EVENT_WRITE:
            with self._lock:
                if not self._closed:
                    self._flush()
                    if not self._blocked:
                        self._loop.modify(self._sock, selectors.EVENT_READ, self._on_event)
        if mask & selectors.EVENT_READ and not self._closed:
            try:
                gone = not self._sock.recv(4096)  # a subscriber has nothing to say: only its going matters
            except BlockingIOError:
                gone = False
            except OSError:
                gone = True
            if gone:
                self.close()

    def _fail(self) -> None:
        """The socket is broken. Lock held."""
        self._closed = True
        self._queue.clear()
        self._loop.call_soon(self._dispose)

    def close(self) -> None:
        """Close the link; what still waits is lost. Any thread."""
        with contextlib.suppress(OSError):  # wakes a thread that waits for the socket
            self._sock.shutdown(socket.SHUT_RDWR)
        with self._lock:
            if not self._closed:
                self._fail()

    def finish(self, until: float) -> None:
        """Send what waits and close: for an orderly end of the publisher.

        Args:
            until: `perf_counter` time after which what is left is given up.
        """
        self._drain(until)
        self.close()

    def _drain(self, until: float) -> None:
        """Send what waits, in this thread, until a `perf_counter` time; a closed link ends the wait."""
        while True:
            with self._lock:
                if not self._closed:
                    self._flush()
                if self._closed or not len(self._queue):
                    return
            if perf_counter() > until:
                return
            _wait_writable(self._sock)

    def _dispose(self) -> None:
        with contextlib.suppress(KeyError, ValueError, OSError):
            self._loop.unregister(self._sock)
        self._sock.close()
        self._on_closed(self)


class WaitingLink(SubscriberLink):
    """A link whose `send` waits until all is written, as rospy does without a queue size; `offer` never waits."""

    def __init__(self, *args: Any) -> None:
        self._turn = threading.Lock()  # publishing threads wait for each other; the loop never takes it
        self._draining = False
        super().__init__(*args)

    def send(self, frame: Frame) -> None:
        """Send a frame after all that waits; return when it is written or the link closed."""
        with self._turn:
            self._draining = True
            try:
                self.offer(frame)
                if len(self._queue):
                    self._drain(inf)
            finally:
                self._draining = False
                if len(self._queue):  # interrupted: the loop sends the rest
                    with self._lock:
                        self._block()

    def _block(self) -> None:
        if not self._draining:  # else a publisher waits for the socket already: the loop need not wake up
            super()._block()


def _wait_writable(sock: socket.socket) -> None:
    """Wait a little for room in a socket, which the loop may close meanwhile."""
    with contextlib.suppress(OSError, ValueError):
        if hasattr(select, "poll"):
            poller = select.poll()
            poller.register(sock, select.POLLOUT)
            poller.poll(100)
        else:
            select.select([], [sock], [], 0.1)


def _address_text(sock: socket.socket) -> str:
    """Describe a connection in the form that rosnode info reads (S03)."""
    try:
        port, peer = sock.getsockname()[1], sock.getpeername()
    except OSError:
        return "TCPROS connection on port 0 to [unknown]"
    return f"TCPROS connection on port {port} to [{peer[0]}:{peer[1]} on socket {sock.fileno()}]"
