"""Links within one process: the publisher passes a copy of its message to the subscription; nothing is encoded.

`publish` copies the message once for all subscribers in the process; the copy shares immutable values, which are
strings and the bytes of uint8 arrays. So a publisher may change its message immediately after `publish`, and copying
images is cheap. The subscribers in a process share the copy, like callbacks of one node in rospy and roscpp, so they
should not change it.
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
"""Smaller messages count as this many bytes."""


class LocalLink:
    """Both ends of a link within a process. The methods that accept messages are called in the topic's strand.

    Args:
        strand: the topic's strand.
        receiver: the delivery loop of the subscription.
        uri: URI of the publisher's slave API.
        header: the subscriber's connection header.
        response_header: the publisher's connection header.
        queue_size: the publisher's maximum number of queued messages; 0 for no limit. None: publishers `wait` while the
            subscriber is behind.
        inbox_bytes: maximum bytes of messages that are queued beyond ``queue_size`` for a subscriber without a limit,
            like the data in the socket buffers of other links.
        on_closed: functions that are called once, with the link, when it is closed: one from the publication, and one
            from the subscription.
    """

    transport = "INTRAPROCESS"

    def __init__(
        self,
        strand: Strand,
        receiver: DeliveryLoop,
        uri: str,
        header: dict[str, str],
        response_header: dict[str, str],
        queue_size: int | None,
        inbox_bytes: int,
        *on_closed: Callable[[LocalLink], None],
    ) -> None:
        self.peer = header.get("callerid", "")
        self.uri = uri
        self.header = response_header
        self.messages = 0
        self.bytes_sent = 0
        self.address = "INTRAPROCESS connection on port 0 to [127.0.0.1:0 on socket 0]"
        self._strand = strand
        self._receiver = receiver
        self._inbox_bytes = inbox_bytes
        self._min_limit = queue_size or 0
        self._limit = max(queue_size, inbox_bytes // _MIN_MESSAGE_SIZE) if queue_size else queue_size
        self._is_limit_raised = self._limit != queue_size
        self._on_closed = on_closed
        self._open_token = [True]  # emptied by the thread that closes the link
        self._inbox = Inbox(self)
        receiver.inboxes.add(self._inbox)

    def start(self) -> None:
        """Do nothing: no header is sent within a process."""

    @property
    def dropped(self) -> int:
        """Always 0: the subscription counts the messages that are dropped because the subscriber is too slow."""
        return 0

    @property
    def waiting(self) -> int:
        """Always 0: messages are delivered immediately."""
        return 0

    @property
    def connected(self) -> bool:
        """Whether the link is open."""
        return bool(self._open_token)

    def send_copy(self, message: Message, in_publisher_thread: bool = True) -> None:
        """Deliver a copy of a message.

        Args:
            message: the copy.
            in_publisher_thread: whether the caller is the publisher's thread, not another thread that runs the strand's
                jobs for it.
        """
        if self._open_token:
            self.messages += 1
            if self._is_limit_raised and self._receiver.limit is None and self._inbox.is_full(self._min_limit):
                message_class: Any = message.__class__
                self._adapt_limit(frame_size(message_class._encode_frame(message)))
            receiver, inbox = self._receiver, self._inbox
            if not (
                receiver.in_publisher
                and not inbox.is_ready
                and (in_publisher_thread or not is_on_loop())
                and receiver.deliver_now(self, message)
            ):
                receiver.push(inbox, message, self._limit)

    def send(self, frame: Frame) -> None:
        """Deliver an encoded message."""
        if not self._open_token:
            return
        data = frame if isinstance(frame, bytes) else b"".join(frame)
        self.messages += 1
        self.bytes_sent += len(data)
        self._adapt_limit(len(data))
        receiver, inbox = self._receiver, self._inbox
        may_deliver_now = receiver.in_publisher and not inbox.is_ready and not is_on_loop()
        if not (may_deliver_now and receiver.deliver_now(self, data[4:])):
            receiver.push(inbox, data[4:], self._limit)

    def _adapt_limit(self, size: int) -> None:
        """Queue fewer messages if they are large. The limit only shrinks, since each change creates a new queue."""
        while self._is_limit_raised and self._limit is not None and self._limit * size > self._inbox_bytes:
            self._limit = max(self._limit // 2, self._min_limit)
            self._is_limit_raised = self._limit > self._min_limit

    def recover(self) -> None:
        """Notify the subscriber of queued messages, in case an exception has interrupted the notification."""
        if len(self._inbox):
            self._receiver.recover(self._inbox)

    def wait(self) -> None:
        """Wait while the subscriber is too far behind, if neither side has set a limit."""
        if self._limit is None and self._inbox.is_full(UNBOUNDED_LIMIT):
            self._receiver.wait_for_room(self._inbox)

    def close(self) -> None:
        """Close the link; messages that are already queued are still delivered."""
        try:
            self._open_token.pop()
        except IndexError:
            return  # the link has been closed already
        for on_closed in self._on_closed:
            on_closed(self)

    def finish(self, deadline: float) -> None:
        """Close the link after the messages published so far; this side has no queue that must be sent."""
        self._strand.do(self.close)


def is_on_loop() -> bool:
    """Return whether the caller runs on a loop's thread, which must not be blocked by callbacks."""
    return isinstance(current_thread(), LoopThread)
