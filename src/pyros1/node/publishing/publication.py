"""The publication of a topic: its links, its latched message, and the order in which messages are sent.

https://wiki.ros.org/rospy/Overview/Publishers%20and%20Subscribers
"""

from __future__ import annotations

import itertools
import struct
import time
from collections.abc import Callable, Iterator, Mapping
from threading import get_ident
from time import perf_counter
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import SerializationError
from pyros1.node.publishing.publisher_links import Link, PublisherLinks
from pyros1.wire.handshake import TopicType
from pyros1.wire.outqueue import Buffer, Frame, copy_frame, frame_size

if TYPE_CHECKING:
    from pyros1.node.context import Context

_LENGTH_SIZE = 4
_U32 = struct.Struct("<I")
NUM_SEQUENCE_NUMBERS = 1 << 32
"""Number of different sequence numbers; at 1 kHz they wrap around after 50 days."""
MIN_SHARED_SIZE = 1 << 16
"""Minimum size in bytes of a message that is sent through shared memory; for smaller ones a socket is just as fast."""
CLOSE_TIMEOUT = 1.0
"""Maximum number of seconds to wait until subscribers have received the last messages of a closing publisher."""
POLL_DELAY = 0.0001
"""Seconds between checks while waiting for another thread."""
MAX_STRAND_WAIT = 1.0
"""Maximum number of seconds that a publisher without a queue waits for the thread that is running the strand's jobs: a
signal handler may delay that thread."""


class Publication(PublisherLinks):
    """A topic that a node publishes, and its links; for the arguments see `PublisherLinks`."""

    def __init__(
        self,
        context: Context,
        topic: str,
        message_class: type[Any],
        type_: TopicType,
        queue_size: int | None,
        latch: bool,
        headers: Mapping[str, str],
    ) -> None:
        super().__init__(context, topic, message_class, type_, queue_size, latch, headers)
        # Codecs are created on first use: here, not in a signal handler that interrupts an import.
        message_class()
        self._encode = message_class._encode_frame
        self.num_publishers = 0
        self._sequence_numbers = _sequence_numbers() if message_class._has_header else None
        self.publish: Callable[[Any], None] = self._publish
        """Send a message to all links; see Publisher.publish."""

    # `_publish` takes the strand itself instead of calling `Strand.do`, which saves a call for every message.

    def _publish(self, message: Any) -> None:  # noqa: PLR0912 - a call costs as much time as ten lines
        if not (self.links or self.latch):
            return
        thread_id, strand = get_ident(), self.strand
        if not strand.free:
            strand.spin_wait()
        try:
            del strand.free[0]
        except IndexError:
            strand.post(self._send_posted, message, *_snapshot(*self._prepare(message)))
        else:
            # The message is encoded in the strand, so that messages published by a signal handler are sent after it: if
            # the handler stops the robot, this message must not start the robot again.
            strand.worker = thread_id
            try:
                has_turn = not strand.jobs or strand.run_pending()
                if has_turn and self._sequence_numbers is not None:
                    message.header.seq = next(self._sequence_numbers)
                if not has_turn:  # some of the other jobs may be from this thread, and must be done first
                    strand.jobs.append((self._send_posted, (message, *_snapshot(*self._prepare(message)))))
                elif self._local and not (self._remote or self.latch):
                    try:
                        copy = message.__class__._copy(message)
                    except SerializationError as error:
                        raise self._with_topic(error) from None
                    for local_link in self._local:
                        local_link.send_copy(copy)
                elif self._local or self.latch or message.__class__ is not self.message_class:
                    self._send(*self._prepare(message))
                else:
                    try:
                        frame = self._encode(message)
                    except SerializationError as error:
                        raise self._with_topic(error) from None
                    if self._shared:
                        self._send_frame(frame)
                    else:
                        for link in self._remote:
                            link.send(frame)
            except BaseException:
                self._recover()
                raise
            finally:
                strand.free.append(True)
                if strand.jobs:
                    strand.work()
        if self.queue_size is None:
            self._wait_for_links()

    def _prepare(self, message: Any) -> tuple[Frame | None, Any]:
        """Return a message in the forms that the links need: as a frame, a copy, or both."""
        cls = message.__class__
        try:
            copy = cls._copy(message) if self._local and not self.latch else None
            if copy is not None and not self._remote:
                return None, copy
            return self._encode(message) if cls is self.message_class else cls._encode_frame(message), copy
        except SerializationError as error:
            raise self._with_topic(error) from None

    def _with_topic(self, error: SerializationError) -> SerializationError:
        return SerializationError(f"{self.topic}: {error}")

    def _send(self, frame: Frame | None, copy: Any, source: object = None) -> None:
        """Send a message to all links, and keep it if the topic is latched. Called in the strand.

        Links may have been added since the message was prepared.
        """
        if frame is None and (self._remote or self.latch):
            frame = copy.__class__._encode_frame(copy)
        if frame is not None:
            if self.latch:
                self._latched[source] = frame if isinstance(frame, bytes) else b"".join(frame)
            self._send_frame(frame)
        for local_link in self._local:
            if copy is not None:
                local_link.send_copy(copy, in_publisher_thread=False)
            elif frame is not None:
                local_link.send(frame)

    def _send_frame(self, frame: Frame) -> None:
        """Send an encoded message to all links; a large one is written only once for links that share memory."""
        placement = None
        if self._shared and self._pool is not None and frame_size(frame) > MIN_SHARED_SIZE and self._pool.is_own:
            for shared_link in self._shared:
                shared_link.receive_releases()
            placement = self._pool.place(
                frame, {block for shared_link in self._shared for block in shared_link.outstanding.values()}
            )
        if placement is None:
            for link in self._remote:
                link.send(frame)
            return
        for link in self._remote:
            if link not in self._shared or not link.send_reference(placement):
                link.send(frame)

    def _send_posted(self, message: Any, frame: Frame | None, copy: Any) -> None:
        """Send a message that was posted to the strand, with the sequence number of its turn."""
        if self._sequence_numbers is not None:
            message.header.seq = number = next(self._sequence_numbers)
            if copy is not None:
                copy.header.seq = number
            if frame is not None:
                frame = _with_sequence_number(frame, number)
        self._send(frame, copy)

    def _wait_for_links(self) -> None:
        """Wait until all links have sent the published messages, like a rospy publisher without a queue size."""
        strand, deadline = self.strand, perf_counter() + MAX_STRAND_WAIT
        while strand.jobs and perf_counter() < deadline:  # this thread's message may be among them
            if strand.runs_in_this_thread:
                return  # in a signal handler: the interrupted function sends them when it continues
            strand.work()
            if not strand.free:
                time.sleep(POLL_DELAY)
        if not strand.runs_in_this_thread:
            for link in self.links:
                link.wait()

    def _warn_after_shutdown(self, message: Any) -> None:
        """Warn that the node has shut down. As in rospy, this is not an error: `ok` may have returned True just before.

        The warning is logged only once, and not at all if the node was shut down by a signal.
        """
        context = self.context
        if context.warn_publish_after_shutdown:
            context.warn_publish_after_shutdown = False
            context.log.warn("publish() on %s after its node has shut down: the message is lost", self.topic)

    def publish_body(self, body: bytes, source: object = None) -> None:
        """Send an already encoded message.

        Args:
            body: the encoded message.
            source: for a latched topic, the source of the message. New subscribers receive the last message of each
                source.
        """
        if self.links or self.latch:
            self.strand.do(self._send, len(body).to_bytes(_LENGTH_SIZE, "little") + body, None, source)
            if self.queue_size is None:
                self._wait_for_links()

    def publish_to(self, link: Link, message: Any) -> None:
        """Send a message to one link; see ``Peer.publish``."""
        if self._sequence_numbers is not None:
            message.header.seq = next(self._sequence_numbers)
        try:
            frame = message.__class__._encode_frame(message)
        except SerializationError as error:
            raise self._with_topic(error) from None
        self.strand.do(link.send, copy_frame(frame))

    def forget(self, source: object) -> None:
        """Discard a source's latched message."""
        self.strand.do(self._latched.pop, source, None)

    def close(self, deadline: float | None = None) -> None:
        """Close all links; queued messages are sent first, if subscribers receive them in time.

        Args:
            deadline: the deadline in `perf_counter` time; None for CLOSE_TIMEOUT seconds from now.
        """
        self.publish = self._warn_after_shutdown
        if deadline is None:
            deadline = perf_counter() + CLOSE_TIMEOUT
        self.strand.do(self._refuse_links)
        while not (self._closed or self.strand.runs_in_this_thread) and perf_counter() < deadline:
            time.sleep(POLL_DELAY)  # another thread is running the strand's jobs
        if self._closed:
            self._finish(deadline)
        else:  # the other thread is stuck, or was interrupted by the signal handler that calls this
            self.strand.do(self._finish, deadline)

    def _refuse_links(self) -> None:
        """Accept no more links, and discard the latched messages. Called in the strand, so that links being added are
        completed first.
        """
        self._closed = True
        self._latched.clear()

    def _finish(self, deadline: float) -> None:
        for link in self.links:
            link.finish(deadline)
        if self._pool is not None:
            self.strand.do(self._pool.close)


def _sequence_numbers() -> Iterator[int]:
    """Return the sequence numbers of headers, starting at 1 like rospy (T22), and wrapping to 0 like roscpp."""
    return itertools.chain(
        range(1, NUM_SEQUENCE_NUMBERS), itertools.chain.from_iterable(itertools.repeat(range(NUM_SEQUENCE_NUMBERS)))
    )


def _snapshot(frame: Frame | None, copy: Any) -> tuple[Frame | None, Any]:
    """Return a prepared message in a form that can be queued: without references to memory that may change."""
    return None if frame is None else copy_frame(frame), copy


def _with_sequence_number(frame: Frame, number: int) -> Frame:
    """Return a frame with another sequence number; the first field of the message must be a Header."""
    other_parts: list[Buffer] = []
    first: Buffer = frame if isinstance(frame, bytes) else frame[0]
    if not isinstance(frame, bytes):
        other_parts = frame[1:]
    head = bytearray(first)
    _U32.pack_into(head, _LENGTH_SIZE, number)
    return [bytes(head), *other_parts] if other_parts else bytes(head)
