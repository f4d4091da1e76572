"""A publisher's link to one subscriber, over TCP.

A link works only in the strand of its topic (``strand.py``), so it has no lock. States of a link:

* *idle*: nothing waits. A message is sent at once, by the thread that works in the strand.
* *coalescing*: messages come less than HOT_GAP seconds apart, MIN_STREAK of them in a row. They gather in the queue
  and are sent together: by the publishing thread after BATCH messages or BATCH_TIME seconds, by the loop's timer if
  the publisher pauses. A single message never waits.
* *blocked*: the socket is full. Messages gather in the queue (the oldest are dropped whole); the loop sends when the
  socket accepts more, and a publisher in a tight loop tries as well, because it seldom lets the loop thread run.
* *closed*.

The number of bytes sent is stored by ``(self._sent,) = map(send, (frame,))``: unlike with a plain call, no signal
handler can run between `send` and the assignment. So one that raises (KeyboardInterrupt) cuts no frame: see `recover`.
"""

from __future__ import annotations

import contextlib
import select
import selectors
import socket
import time
from collections.abc import Callable
from time import perf_counter

from pyros1.net.keepalive import is_peer_dead
from pyros1.net.loop import Loop, TimerHandle
from pyros1.net.socket_close import shutdown_and_close
from pyros1.node.strand import Strand
from pyros1.wire.outqueue import Frame, OutQueue, frame_size

HOT_GAP = 30e-6
MIN_STREAK = 100
BATCH = 128
BATCH_TIME = 100e-6
MAX_BYTES_PER_TURN = 4 << 20
"""Maximum number of bytes sent in one go; the rest is sent in the loop's next round, after the other links."""
FLUSH_DELAY = 0.0005
"""Seconds after which the loop sends the messages that the publisher has left in the queue."""
PEER_CHECK_INTERVAL = 15.0
"""Seconds between checks whether the subscriber's machine is gone."""
SMALL = 4096
POLL_DELAY = 0.0001


class TcpLink:
    """Link to one connected subscriber.

    Args:
        loop: the node's loop.
        strand: the topic's strand. `start`, `send` and `recover` are called in it, the other methods from any thread.
        sock: connected socket, after the handshake; owned by the link from now on.
        header: the subscriber's connection header.
        greeting: the publisher's connection header, encoded; it is sent first, see `start`.
        queue_size: maximum number of waiting messages; 0 or None for no limit.
        on_closed: called once when the link has ended.

    Attributes:
        messages, bytes_sent: numbers of messages and bytes given to this link.
    """

    transport = "TCPROS"

    def __init__(
        self,
        loop: Loop,
        strand: Strand,
        sock: socket.socket,
        header: dict[str, str],
        greeting: bytes,
        queue_size: int | None,
        on_closed: Callable[[TcpLink], None],
    ) -> None:
        self.header = header
        self.peer = header.get("callerid", "")
        self.messages = 0
        self.bytes_sent = 0
        self._loop = loop
        self._strand = strand
        self._sock = sock
        self._send_bytes = sock.send
        self._on_closed = on_closed
        self._queue = OutQueue(queue_size)
        self._batch = 0 if queue_size is None else BATCH if queue_size == 0 else min(BATCH, queue_size // 2)
        self._is_idle = True
        self._is_blocked = False
        self._closed = False
        self._timer_set = False  # whether the loop's timer is set
        self._is_writable = False  # whether the socket accepts more
        self._in_event = False  # whether the loop is in `_on_event`
        self._streak = 0
        self._last = 0.0
        self._in_flight: Frame | None = None  # a frame that is being sent without the queue
        self._sent = 0  # number of its bytes that were sent
        sock.setblocking(False)
        self.address = _address_text(sock)
        self._greeting = greeting
        self._peer_check_timer: TimerHandle | None = None
        loop.call_soon(self._watch)

    def start(self) -> None:
        """Send the greeting.

        A subscriber that has the greeting expects all messages from then on, so the link is added to the topic first.
        """
        self._send_now(self._greeting)
        self.bytes_sent = 0

    @property
    def dropped(self) -> int:
        """Number of messages dropped because the subscriber was too slow."""
        return self._queue.dropped

    @property
    def waiting(self) -> int:
        """Number of messages that the subscriber has not received yet."""
        return len(self._queue)

    @property
    def connected(self) -> bool:
        """Whether the link is open."""
        return not self._closed

    def send(self, frame: Frame) -> None:
        """Send a frame, or queue it. Never waits."""
        if self._closed:
            return
        self.messages += 1
        now = perf_counter()
        if self._is_idle:
            if self._batch > 1 and now - self._last < HOT_GAP:
                self._streak += 1
                if self._streak > MIN_STREAK and frame.__class__ is bytes and len(frame) < SMALL:
                    self._is_idle = False
                    self._last = now
                    self._queue.push(frame)
                    self._set_timer()
                    return
            else:
                self._streak = 0
            self._last = now
            self._send_now(frame)
            return
        self._queue.push(frame)
        if now - self._last > BATCH_TIME or (len(self._queue) >= self._batch and not self._is_blocked):
            self._last = now
            self._flush()

    def _send_now(self, frame: Frame) -> None:
        self._in_flight, self._sent = frame, 0
        try:
            if isinstance(frame, bytes):
                size = len(frame)
                (self._sent,) = map(self._send_bytes, (frame,))
            else:
                size = frame_size(frame)
                (self._sent,) = map(self._sock.sendmsg, (frame,))
        except BlockingIOError:
            pass
        except OSError:
            self._fail()
            return
        sent = self._sent
        self.bytes_sent += sent
        if sent == size:
            self._in_flight = None
            return
        self._queue_rest()

    def _queue_rest(self) -> None:
        """Queue the rest of a frame that the socket has accepted only partly."""
        frame, sent = self._in_flight, self._sent
        if frame is not None:
            self._is_idle = False
            if sent:
                self._queue.push_partial(frame, sent)
            else:
                self._queue.push(frame)
            self._in_flight = None
            self._block()

    def _flush(self) -> None:
        """Send from the queue as much as the socket accepts, at most one turn."""
        queue, end = self._queue, self.bytes_sent + MAX_BYTES_PER_TURN
        while parts := queue.buffers():
            try:
                if len(parts) > 4 and len(parts[0]) < SMALL and len(parts[-1]) < SMALL:
                    data = b"".join(parts)
                    whole = len(data)
                    (queue.sent_bytes,) = map(self._sock.send, (data,))
                else:
                    whole = sum(map(len, parts))
                    (queue.sent_bytes,) = map(self._sock.sendmsg, (parts,))
            except BlockingIOError:
                self._block()
                return
            except OSError:
                self._fail()
                return
            sent = queue.sent_bytes
            self.bytes_sent += sent
            queue.discard_sent()
            if sent < whole or (self.bytes_sent >= end and queue):
                self._block()
                return
        self._is_blocked = False
        if not self._timer_set:
            self._is_idle = True
            self._streak = 0

    def recover(self) -> None:
        """Restore a valid state after a signal handler has raised within a method, and send what is queued."""
        if self._closed:
            return
        if self._in_flight is not None and 0 < self._sent < frame_size(self._in_flight):
            self._queue_rest()
        self._in_flight = None
        self._queue.discard_sent()
        self._timer_set = self._is_blocked = False  # the loop may not know yet
        self._flush()

    def _set_timer(self) -> None:
        if not self._timer_set:
            self._timer_set = True
            self._loop.call_later(FLUSH_DELAY, self._on_flush_timer)

    def _on_flush_timer(self) -> None:
        """Send the messages left in the queue; set the timer again while the publisher is busy. On the loop."""
        self._strand.do(self._flush_batch)

    def _flush_batch(self) -> None:
        self._timer_set = False
        if self._closed or self._is_blocked:
            return
        busy = perf_counter() - self._last < FLUSH_DELAY
        self._flush()
        if busy and not self._closed and not self._is_blocked:
            self._is_idle = False
            self._set_timer()

    def _block(self) -> None:
        if not self._is_blocked:
            self._is_blocked = True
            self._loop.call_soon(self._want_writable)

    # On the loop ------------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        if not self._closed:
            self._loop.register(self._sock, selectors.EVENT_READ, self._on_event)
            self._peer_check_timer = self._loop.call_later(PEER_CHECK_INTERVAL, self._check_peer)

    def _check_peer(self) -> None:
        """End the link if the subscriber's machine is gone: queues would fill, or publishers would wait."""
        if is_peer_dead(self._sock):
            self.close()
        elif not self._closed:
            self._peer_check_timer = self._loop.call_later(PEER_CHECK_INTERVAL, self._check_peer)

    def _want_writable(self) -> None:
        if not self._closed:
            self._loop.modify(self._sock, selectors.EVENT_READ | selectors.EVENT_WRITE, self._on_event)

    def _on_event(self, mask: int) -> None:
        if mask & selectors.EVENT_WRITE:
            self._is_writable = self._in_event = True
            self._strand.do(self._send_more)
            self._in_event = False
            if self._is_writable or not self._is_blocked:  # left to another thread, or everything is sent
                self._loop.modify(self._sock, selectors.EVENT_READ, self._on_event)
        if mask & selectors.EVENT_READ and not self._closed:
            try:
                gone = not self._sock.recv(4096)  # a subscriber sends nothing: only the end of the connection matters
            except BlockingIOError:
                gone = False
            except OSError:
                gone = True
            if gone:
                self.close()

    def _send_more(self) -> None:
        self._is_writable = False
        if not self._closed:
            self._flush()
            if self._is_blocked and not (
                self._in_event and self._loop.in_loop()
            ):  # the loop no longer watches the socket
                self._loop.call_soon(self._want_writable)

    def _fail(self) -> None:
        """Close a link whose socket is broken or closed. In the strand."""
        if not self._closed:
            self._closed = True
            self._queue.clear()
            if self._loop.running:
                self._loop.call_soon(self._dispose)
            else:
                self._dispose()

    def close(self) -> None:
        """Close the link; waiting messages are lost. Any thread."""
        if not self._strand.is_mine:
            with contextlib.suppress(OSError):  # so that nothing more is sent
                self._sock.shutdown(socket.SHUT_RDWR)
        self._strand.do(self._fail)

    def finish(self, deadline: float) -> None:
        """Send what is queued, then close: for an orderly end of the publisher.

        Args:
            deadline: the deadline, as `perf_counter` time; the rest is then dropped.
        """
        while not self._strand.is_mine:
            if perf_counter() > deadline:
                self.close()
                return
            # In the strand: a thread that works there may be handling a frame, or have sent half of it.
            self._strand.do(self._close_if_sent)
            if self._closed:
                return
            self._wait_and_send()
        # A signal handler ends the node on top of a function that is sending here, which continues afterwards.
        self._strand.do(self._flush_open)
        self._strand.do(self._fail)

    def _close_if_sent(self) -> None:
        if not self._queue:
            self._fail()

    def wait(self) -> None:
        """Do nothing: publishers do not wait for this link."""

    def _wait_and_send(self) -> None:
        """Wait a little until the socket accepts more, and send."""
        wait_writable(self._sock)
        if self._strand.free:
            self._strand.do(self._flush_open)
        else:
            time.sleep(POLL_DELAY)  # the thread that works in the strand sends

    def _flush_open(self) -> None:
        if not self._closed:
            self._flush()

    def _dispose(self) -> None:
        if self._peer_check_timer is not None:
            self._peer_check_timer.cancel()
        with contextlib.suppress(KeyError, ValueError, OSError):
            self._loop.unregister(self._sock)
        shutdown_and_close(self._sock)
        self._on_closed(self)


class WaitingLink(TcpLink):
    """A link whose publishers wait until everything is sent, like in rospy without a queue size."""

    def wait(self) -> None:
        """Wait until the messages given to `send` so far are sent, or the link is closed. Not in the strand."""
        number = self.messages
        if self._num_sent >= number:
            return
        try:
            while not self._closed and self._num_sent < number:
                self._wait_and_send()
        finally:
            if self._queue:  # messages of other threads, or this thread was interrupted: the loop sends them
                self._strand.do(self._leave_to_loop)

    @property
    def _num_sent(self) -> int:
        return self.messages - len(self._queue)

    def _leave_to_loop(self) -> None:
        if self._queue and not self._closed:
            super()._block()

    def start(self) -> None:
        """Send the greeting; no publisher waits for it, or for the latched messages that follow it in this job."""
        super().start()
        self._loop.call_soon(self._strand.do, self._leave_to_loop)

    def recover(self) -> None:
        """Recover as other links do; the loop sends the rest, as the thread that would have waited was interrupted."""
        super().recover()
        self._leave_to_loop()

    def _block(self) -> None:
        """Do not wake the loop, since a publisher waits for the socket."""


def wait_writable(sock: socket.socket) -> None:
    """Wait a little for room in a socket, which the loop may close meanwhile."""
    with contextlib.suppress(OSError, ValueError):
        if hasattr(select, "poll"):
            poller = select.poll()
            poller.register(sock, select.POLLOUT)
            poller.poll(100)
        else:
            select.select([], [sock], [], 0.1)


def _address_text(sock: socket.socket) -> str:
    """Describe a connection in the form that rosnode info parses (S03)."""
    if sock.family == getattr(socket, "AF_UNIX", None):
        return f"LOCAL connection on port 0 to [127.0.0.1:0 on socket {sock.fileno()}]"
    try:
        port, peer = sock.getsockname()[1], sock.getpeername()
    except OSError:
        return "TCPROS connection on port 0 to [unknown]"
    return f"TCPROS connection on port {port} to [{peer[0]}:{peer[1]} on socket {sock.fileno()}]"
