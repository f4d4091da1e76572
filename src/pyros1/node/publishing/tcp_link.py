"""A publisher's link to one subscriber, over TCP.

A link is used only in the strand of its topic (``strand.py``), so it needs no lock. States of a link:

* *idle*: the queue is empty. A message is sent immediately, by the thread that runs the strand's jobs.
* *coalescing*: more than MIN_STREAK messages in a row were published less than MAX_STREAK_GAP seconds apart. They are
  collected in the queue and sent together: by the publishing thread after MAX_BATCH messages or BATCH_TIME seconds, or
  by the loop's timer if the publisher pauses. A single message is never delayed.
* *blocked*: the socket is full. Messages are collected in the queue (if there are too many, the oldest are dropped, but
  never part of a message). The loop sends when the socket accepts more; so does a publisher in a tight loop, because it
  rarely lets the loop thread run.
* *closed*.

The number of bytes sent is stored by ``(self._sent_bytes,) = map(send, (frame,))``: unlike with a plain call, no signal
handler can run between `send` and the assignment. So a handler that raises an exception (KeyboardInterrupt) cannot
leave a frame incomplete: see `recover`.
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

MAX_STREAK_GAP = 30e-6
"""Maximum number of seconds between messages of a streak; see the module's docstring."""
MIN_STREAK = 100
MAX_BATCH = 128
BATCH_TIME = 100e-6
MAX_BYTES_PER_TURN = 4 << 20
"""Maximum number of bytes to send at once; the remaining bytes are sent in the loop's next iteration, after other links
had their turn."""
FLUSH_DELAY = 0.0005
"""Seconds after which the loop sends the messages that the publisher has left in the queue."""
PEER_CHECK_INTERVAL = 15.0
"""Seconds between checks of whether the subscriber's machine is gone."""
SMALL_FRAME_BYTES = 4096
"""Frames below this size in bytes are joined, or collected in the queue, before they are sent."""
POLL_DELAY = 0.0001


class TcpLink:
    """Link to one connected subscriber.

    Args:
        loop: the node's loop.
        strand: the topic's strand. `start`, `send` and `recover` are called in it; the other methods are thread-safe.
        sock: connected socket, after the handshake; the link takes it over and closes it.
        header: the subscriber's connection header.
        encoded_header: the publisher's connection header, which `start` sends.
        queue_size: maximum number of queued messages; 0 or None for no limit.
        on_closed: called once when the link is closed.

    Attributes:
        messages, bytes_sent: numbers of messages and bytes sent over this link.
    """

    transport = "TCPROS"

    def __init__(
        self,
        loop: Loop,
        strand: Strand,
        sock: socket.socket,
        header: dict[str, str],
        encoded_header: bytes,
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
        self._batch_size = (
            0 if queue_size is None else MAX_BATCH if queue_size == 0 else min(MAX_BATCH, queue_size // 2)
        )
        self._is_idle = True
        self._is_blocked = False
        self._closed = False
        self._is_flush_scheduled = False  # whether the loop's timer is set
        self._is_writable = False  # whether the socket accepts more
        self._in_event = False  # whether the loop is in `_on_event`
        self._streak = 0
        self._last_send_at = 0.0
        self._frame_in_flight: Frame | None = None  # a frame that is being sent without the queue
        self._sent_bytes = 0  # number of bytes of this frame that were sent
        sock.setblocking(False)
        self.address = _address_text(sock)
        self._encoded_header = encoded_header
        self._peer_check_timer: TimerHandle | None = None
        loop.call_soon(self._watch)

    def start(self) -> None:
        """Send the connection header.

        A subscriber that has received the header expects all messages from then on, so the link is added to the topic
        first.
        """
        self._send_now(self._encoded_header)
        self.bytes_sent = 0

    @property
    def dropped(self) -> int:
        """Number of messages dropped because the subscriber was too slow."""
        return self._queue.dropped

    @property
    def waiting(self) -> int:
        """Number of messages that are queued for the subscriber."""
        return len(self._queue)

    @property
    def connected(self) -> bool:
        """Whether the link is open."""
        return not self._closed

    def send(self, frame: Frame) -> None:
        """Send a frame, or queue it. Never blocks."""
        if self._closed:
            return
        self.messages += 1
        now = perf_counter()
        if self._is_idle:
            if self._batch_size > 1 and now - self._last_send_at < MAX_STREAK_GAP:
                self._streak += 1
                if self._streak > MIN_STREAK and frame.__class__ is bytes and len(frame) < SMALL_FRAME_BYTES:
                    self._is_idle = False
                    self._last_send_at = now
                    self._queue.push(frame)
                    self._set_timer()
                    return
            else:
                self._streak = 0
            self._last_send_at = now
            self._send_now(frame)
            return
        self._queue.push(frame)
        if now - self._last_send_at > BATCH_TIME or (len(self._queue) >= self._batch_size and not self._is_blocked):
            self._last_send_at = now
            self._flush()

    def _send_now(self, frame: Frame) -> None:
        self._frame_in_flight, self._sent_bytes = frame, 0
        try:
            if isinstance(frame, bytes):
                size = len(frame)
                (self._sent_bytes,) = map(self._send_bytes, (frame,))
            else:
                size = frame_size(frame)
                (self._sent_bytes,) = map(self._sock.sendmsg, (frame,))
        except BlockingIOError:
            pass
        except OSError:
            self._fail()
            return
        sent = self._sent_bytes
        self.bytes_sent += sent
        if sent == size:
            self._frame_in_flight = None
            return
        self._queue_unsent()

    def _queue_unsent(self) -> None:
        """Queue the remaining part of a frame that the socket has accepted only partially."""
        frame, sent = self._frame_in_flight, self._sent_bytes
        if frame is not None:
            self._is_idle = False
            if sent:
                self._queue.push_partial(frame, sent)
            else:
                self._queue.push(frame)
            self._frame_in_flight = None
            self._block()

    def _flush(self) -> None:
        """Send as much from the queue as the socket accepts, at most MAX_BYTES_PER_TURN."""
        queue, turn_end = self._queue, self.bytes_sent + MAX_BYTES_PER_TURN
        while parts := queue.buffers():
            try:
                if len(parts) > 4 and len(parts[0]) < SMALL_FRAME_BYTES and len(parts[-1]) < SMALL_FRAME_BYTES:
                    data = b"".join(parts)
                    size = len(data)
                    (queue.sent_bytes,) = map(self._sock.send, (data,))
                else:
                    size = sum(map(len, parts))
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
            if sent < size or (self.bytes_sent >= turn_end and queue):
                self._block()
                return
        self._is_blocked = False
        if not self._is_flush_scheduled:
            self._is_idle = True
            self._streak = 0

    def recover(self) -> None:
        """Restore a valid state after an exception from a signal handler has interrupted a method; send the queue."""
        if self._closed:
            return
        if self._frame_in_flight is not None and 0 < self._sent_bytes < frame_size(self._frame_in_flight):
            self._queue_unsent()
        self._frame_in_flight = None
        self._queue.discard_sent()
        self._is_flush_scheduled = self._is_blocked = False  # the interruption may have prevented the call to the loop
        self._flush()

    def _set_timer(self) -> None:
        if not self._is_flush_scheduled:
            self._is_flush_scheduled = True
            self._loop.call_later(FLUSH_DELAY, self._on_flush_timer)

    def _on_flush_timer(self) -> None:
        """Send the messages left in the queue; set the timer again while the publisher is busy. Called on the loop."""
        self._strand.do(self._flush_batch)

    def _flush_batch(self) -> None:
        self._is_flush_scheduled = False
        if self._closed or self._is_blocked:
            return
        is_busy = perf_counter() - self._last_send_at < FLUSH_DELAY
        self._flush()
        if is_busy and not self._closed and not self._is_blocked:
            self._is_idle = False
            self._set_timer()

    def _block(self) -> None:
        if not self._is_blocked:
            self._is_blocked = True
            self._loop.call_soon(self._await_writable)

    # On the loop ------------------------------------------------------------------------------------------------------

    def _watch(self) -> None:
        if not self._closed:
            self._loop.register(self._sock, selectors.EVENT_READ, self._on_event)
            self._peer_check_timer = self._loop.call_later(PEER_CHECK_INTERVAL, self._check_peer)

    def _check_peer(self) -> None:
        """Close the link if the subscriber's machine is gone: otherwise queues would fill up, or publishers wait."""
        if is_peer_dead(self._sock):
            self.close()
        elif not self._closed:
            self._peer_check_timer = self._loop.call_later(PEER_CHECK_INTERVAL, self._check_peer)

    def _await_writable(self) -> None:
        if not self._closed:
            self._loop.modify(self._sock, selectors.EVENT_READ | selectors.EVENT_WRITE, self._on_event)

    def _on_event(self, mask: int) -> None:
        if mask & selectors.EVENT_WRITE:
            self._is_writable = self._in_event = True
            self._strand.do(self._send_more)
            self._in_event = False
            if self._is_writable or not self._is_blocked:  # another thread is sending, or everything is sent
                self._loop.modify(self._sock, selectors.EVENT_READ, self._on_event)
        if mask & selectors.EVENT_READ and not self._closed:
            try:
                is_gone = not self._sock.recv(4096)  # subscribers send nothing: only the end can arrive
            except BlockingIOError:
                is_gone = False
            except OSError:
                is_gone = True
            if is_gone:
                self.close()

    def _send_more(self) -> None:
        self._is_writable = False
        if not self._closed:
            self._flush()
            if self._is_blocked and not (self._in_event and self._loop.in_loop()):
                self._loop.call_soon(self._await_writable)  # the loop no longer waits for the socket

    def _fail(self) -> None:
        """Close a link whose socket is broken or closed. Called in the strand."""
        if not self._closed:
            self._closed = True
            self._queue.clear()
            if self._loop.running:
                self._loop.call_soon(self._dispose)
            else:
                self._dispose()

    def close(self) -> None:
        """Close the link; queued messages are lost. Thread-safe."""
        if not self._strand.runs_in_this_thread:
            with contextlib.suppress(OSError):  # so that nothing more is sent
                self._sock.shutdown(socket.SHUT_RDWR)
        self._strand.do(self._fail)

    def finish(self, deadline: float) -> None:
        """Send the queued messages, then close the link. Called when the publisher is closed.

        Args:
            deadline: the deadline in `perf_counter` time; after that, the remaining messages are dropped.
        """
        while not self._strand.runs_in_this_thread:
            if perf_counter() > deadline:
                self.close()
                return
            # The strand does this, since another thread may be sending a frame in it.
            self._strand.do(self._close_if_sent)
            if self._closed:
                return
            self._wait_and_send()
        # The caller is a signal handler that has interrupted the strand's worker, which will continue afterwards.
        self._strand.do(self._flush_if_open)
        self._strand.do(self._fail)

    def _close_if_sent(self) -> None:
        if not self._queue:
            self._fail()

    def wait(self) -> None:
        """Do nothing: publishers do not wait for this link."""

    def _wait_and_send(self) -> None:
        """Wait briefly until the socket accepts more, then send."""
        wait_writable(self._sock)
        if self._strand.free:
            self._strand.do(self._flush_if_open)
        else:
            time.sleep(POLL_DELAY)  # the thread that is running the strand's jobs will send

    def _flush_if_open(self) -> None:
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
    """A link whose publishers wait until everything is sent, as in rospy without a queue size."""

    def wait(self) -> None:
        """Wait until the messages passed to `send` so far are sent, or the link is closed. Not called in the strand."""
        num_messages = self.messages
        if self._num_sent >= num_messages:
            return
        try:
            while not self._closed and self._num_sent < num_messages:
                self._wait_and_send()
        finally:
            if self._queue:  # messages of other threads, or any messages if this wait was interrupted
                self._strand.do(self._let_loop_send)

    @property
    def _num_sent(self) -> int:
        return self.messages - len(self._queue)

    def _let_loop_send(self) -> None:
        if self._queue and not self._closed:
            super()._block()

    def start(self) -> None:
        """Start sending the connection header; the loop sends the rest of it, and the latched messages that follow."""
        super().start()
        self._loop.call_soon(self._strand.do, self._let_loop_send)

    def recover(self) -> None:
        """Recover like `TcpLink`; the loop sends the rest, since the thread that was waiting was interrupted."""
        super().recover()
        self._let_loop_send()

    def _block(self) -> None:
        """Do nothing, instead of waking the loop as `TcpLink` does: a publisher is waiting for the socket."""


def wait_writable(sock: socket.socket) -> None:
    """Wait briefly until a socket is writable; the loop may close the socket meanwhile."""
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
        port, peer_address = sock.getsockname()[1], sock.getpeername()
    except OSError:
        return "TCPROS connection on port 0 to [unknown]"
    return f"TCPROS connection on port {port} to [{peer_address[0]}:{peer_address[1]} on socket {sock.fileno()}]"
