"""Links within one process: the publisher hands a copy of its message to the subscription; nothing is encoded.

The copy rule: `publish` copies the message once for all subscribers of the process; the copy shares immutable values:
strings and the bytes of uint8 arrays. So a publisher may change its message at once, and images cost nothing. The
subscribers of a process share one copy, like callbacks of one node in rospy and roscpp: they should not change it.
"""

from __future__ import annotations

from collections.abc import Callable
from threading import current_thread
from typing import TYPE_CHECKING, Any

from pyros1.net.loop import LoopThread
from pyros1.node.subscribing.queues import UNBOUNDED_LIMIT, Inbox
from pyros1.wire.outqueue import frame_size

if TYPE_CHECKING:
    from pyros1.msgs import Message
    from pyros1.node.strand import Strand
    from pyros1.node.subscribing.delivery_loop import DeliveryLoop
    from pyros1.wire.outqueue import Frame

_MIN_MESSAGE_SIZE = 256
"""Minimum number of bytes counted for a message."""


class LocalLink:
    """Both ends of a link within a process. The methods that accept messages are called in the topic's strand.

    Args:
        strand: the topic's strand.
        receiver: the delivery loop of the subscription.
        uri: the publisher's slave API.
        header: the subscriber's connection header.
        answer: the publisher's connection header.
        queue_size: the publisher's: maximum number of messages that wait here; None: publishers `wait` while the
            subscriber is behind; 0: no limit.
        inbox_bytes: bytes of messages that may wait here even beyond ``queue_size``, as in the sockets of other links:
            for a subscriber without a limit.
        on_closed: two functions, for the publication and the subscription, each called once after the link has ended.
    """

    transport = "INTRAPROCESS"

    def __init__(
        self,
        strand: Strand,
        receiver: DeliveryLoop,
        uri: str,
        header: dict[str, str],
        answer: dict[str, str],
        queue_size: int | None,
        inbox_bytes: int,
        *on_closed: Callable[[LocalLink], None],
    ) -> None:
        self.peer = header.get("callerid", "")
        self.uri = uri
        self.header = answer
        self.messages = 0
        self.bytes_sent = 0
        self.address = "INTRAPROCESS connection on port 0 to [127.0.0.1:0 on socket 0]"
        self._strand = strand
        self._receiver = receiver
        self._inbox_bytes = inbox_bytes
        self._min_limit = queue_size or 0
        self._limit = max(queue_size, inbox_bytes // _MIN_MESSAGE_SIZE) if queue_size else queue_size
        self._has_room = self._limit != queue_size
        self._on_closed = on_closed
        self._open = [True]
        self._inbox = Inbox(self)
        receiver.inboxes.open(self._inbox)

    def start(self) -> None:
        """Do nothing: there is no greeting within a process."""

    @property
    def dropped(self) -> int:
        """Always 0: the subscription counts the messages that it drops because it is too slow."""
        return 0

    @property
    def waiting(self) -> int:
        """Always 0: messages are handed over at once."""
        return 0

    @property
    def connected(self) -> bool:
        """Whether the link is open."""
        return bool(self._open)

    def send_copy(self, message: Message, direct: bool = True) -> None:
        """Hand over a copy of a message.

        Args:
            direct: whether its publisher's thread calls this, not another thread that works in the strand for it.
        """
        if self._open:
            self.messages += 1
            if self._has_room and self._receiver.limit is None and self._inbox.full(self._min_limit):
                message_class: Any = message.__class__
                self._adapt_limit(frame_size(message_class._encode_frame(message)))
            receiver, inbox = self._receiver, self._inbox
            if not (
                receiver.in_publisher
                and not inbox.is_ready
                and (direct or not on_loop())
                and receiver.deliver_now(self, message)
            ):
                receiver.push(inbox, message, self._limit)

    def send(self, frame: Frame) -> None:
        """Hand over an encoded message."""
        if not self._open:
            return
        data = frame if isinstance(frame, bytes) else b"".join(frame)
        self.messages += 1
        self.bytes_sent += len(data)
        self._adapt_limit(len(data))
        receiver, inbox = self._receiver, self._inbox
        now = receiver.in_publisher and not inbox.is_ready and not on_loop()
        if not (now and receiver.deliver_now(self, data[4:])):
            receiver.push(inbox, data[4:], self._limit)

    def _adapt_limit(self, size: int) -> None:
        """Let fewer messages wait if they are large. The limit only shrinks: each change begins a new queue."""
        while self._has_room and self._limit is not None and self._limit * size > self._inbox_bytes:
            self._limit = max(self._limit // 2, self._min_limit)
            self._has_room = self._limit > self._min_limit

    def recover(self) -> None:
        """Announce waiting messages to the subscriber, in case that was interrupted."""
        if len(self._inbox):
            self._receiver.recover(self._inbox)

    def wait(self) -> None:
        """Wait until the subscriber is not too far behind, if neither side has set a limit."""
        if self._limit is None and self._inbox.full(UNBOUNDED_LIMIT):
            self._receiver.wait_for_room(self._inbox)

    def close(self) -> None:
        """End the link; messages that were handed over are still delivered."""
        try:
            self._open.pop()
        except IndexError:
            return  # it has been closed already
        for closed in self._on_closed:
            closed(self)

    def finish(self, deadline: float) -> None:
        """End the link after all published messages; none are queued on this side."""
        self._strand.do(self.close)


def on_loop() -> bool:
    """Return whether this is a loop's thread, which does greetings and other jobs: no callback may block it."""
    return isinstance(current_thread(), LoopThread)
