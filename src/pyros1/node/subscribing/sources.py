"""Sources of a subscription's messages, and items that wait."""

from __future__ import annotations

from collections import deque
from typing import TYPE_CHECKING, NamedTuple, Protocol

from pyros1.msgs import AnyMsg, Message
from pyros1.msgs.large_arrays import SplitBody

if TYPE_CHECKING:
    from pyros1.node.subscribing.inbox import Inbox
    from pyros1.node.subscribing.tcp_source import TcpSource

UNBOUNDED_LIMIT = 1000
"""Maximum number of waiting messages if neither side set a queue size; beyond that the publisher waits, as with TCP."""
Item = bytes | SplitBody | Message | AnyMsg
"""A message that waits: encoded, or handed over by a publisher in this process."""


class Source(Protocol):
    """A link to a publisher."""

    header: dict[str, str]

    @property
    def connected(self) -> bool: ...


class InboxSource(Source, Protocol):
    """A source that puts its messages into an inbox: in this process, or over UDP."""

    uri: str
    transport: str
    address: str
    messages: int

    def close(self) -> None: ...


class Receiver(Protocol):
    """The part of a subscription's `Delivery` that a source with an inbox needs.

    Attributes:
        limit: maximum number of waiting messages of each source; None if the subscribers have set no limit.
        in_publisher: whether messages are to be delivered by `deliver_now`, if no other messages of the source wait.
    """

    limit: int | None
    in_publisher: bool

    def deliver_now(self, source: Source, item: Item) -> bool:
        """Deliver a message in the calling thread, or return False; see `Delivery.deliver_now`."""

    def open(self, inbox: Inbox[Source, Item]) -> None:
        """Start taking messages out of an inbox."""

    def push(self, inbox: Inbox[Source, Item], item: Item, limit: int | None) -> None:
        """Put a message into an inbox; see `Delivery.push`."""

    def recover(self, inbox: Inbox[Source, Item]) -> None:
        """Look for messages in an inbox; see `Delivery.recover`."""

    def wait_for_room(self, inbox: Inbox[Source, Item]) -> None:
        """Wait until not too many messages wait; see `Delivery.wait_for_room`."""


class Unfinished(NamedTuple):
    """Messages that a link could not deliver within its turn: frames of ``data`` from ``position`` on, or items."""

    link: TcpSource
    data: bytes
    frames: list[tuple[int, int]]
    position: int
    items: deque[bytes | SplitBody] = deque()
