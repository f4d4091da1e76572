"""Links within one process: the publisher hands a copy of its message to the subscription; nothing is encoded.

The copy rule: `publish` copies the message once for all subscribers of the process, sharing what cannot change: strings
and the bytes of uint8 arrays. So a publisher may change its message at once, and images cost nothing. Subscribers in a
process share one copy, as the callbacks of one node do in rospy, and as roscpp's do: they should not change it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from pyros1.node.subscribing.inbox import Inbox
from pyros1.node.subscribing.sources import UNBOUNDED_LIMIT
from pyros1.wire.outqueue import Frame

if TYPE_CHECKING:
    from pyros1.msgs import Message
    from pyros1.node.lane import Lane
    from pyros1.node.subscribing.sources import Item, Receiver, Source


class LocalLink:
    """Both ends of a link within the process. The methods that take messages are called in the lane of the topic.

    Args:
        lane: of the topic.
        receiver: the receiving end, of a subscription.
        uri: the publisher's slave API.
        header: the subscriber's connection header.
        answer: the publisher's.
        queue_size: of the publisher: bounds what waits here; None: publishers `wait` while the subscriber is behind.
        on_closed: called once each, when the link is gone: for the publication, and for the subscription.
    """

    transport = "INTRAPROCESS"

    def __init__(
        self,
        lane: Lane,
        receiver: Receiver,
        uri: str,
        header: dict[str, str],
        answer: dict[str, str],
        queue_size: int | None,
        *on_closed: Callable[[LocalLink], None],
    ) -> None:
        self.peer = header.get("callerid", "")
        self.uri = uri
        self.header = answer
        self.messages = 0
        self.bytes_sent = 0
        self.address = "INTRAPROCESS connection on port 0 to [127.0.0.1:0 on socket 0]"
        self._lane = lane
        self._receiver = receiver
        self._limit = queue_size
        self._on_closed = on_closed
        self._open = [True]
        self._inbox: Inbox[Source, Item] = Inbox(self)
        receiver.open(self._inbox)

    def start(self) -> None:
        """There is no greeting within the process."""

    @property
    def dropped(self) -> int:
        """Messages thrown away because the subscription was too slow: the subscription counts them."""
        return 0

    @property
    def waiting(self) -> int:
        """Messages that have not been sent: they are handed over at once."""
        return 0

    @property
    def connected(self) -> bool:
        """Whether the link is up."""
        return bool(self._open)

    def hand_over(self, message: Message) -> None:
        """Hand over a copy of a message."""
        if self._open:
            self.messages += 1
            self._receiver.push(self._inbox, message, self._limit)

    def send(self, frame: Frame) -> None:
        """Hand over what is encoded already."""
        if not self._open:
            return
        data = frame if isinstance(frame, bytes) else b"".join(frame)
        self.messages += 1
        self.bytes_sent += len(data)
        self._receiver.push(self._inbox, data[4:], self._limit)

    def recover(self) -> None:
        """Let the subscriber know of what waits, in case it was not told yet."""
        if len(self._inbox):
            self._receiver.recover(self._inbox)

    def wait(self) -> None:
        """Wait until the subscriber is not too far behind, if neither side has bounded what may wait."""
        if self._limit is None and self._inbox.full(UNBOUNDED_LIMIT):
            self._receiver.wait_for_room(self._inbox)

    def close(self) -> None:
        """End the link; what was handed over is still delivered."""
        try:
            self._open.pop()
        except IndexError:
            return  # somebody has done so
        for closed in self._on_closed:
            closed(self)

    def finish(self, until: float) -> None:
        """End the link after all that was published; nothing waits on this side."""
        self._lane.do(self.close)
