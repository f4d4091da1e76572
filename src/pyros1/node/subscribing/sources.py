"""Where a subscription's messages come from, and what waits of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

from pyros1.msgs import AnyMsg, Message
from pyros1.msgs.large import SplitBody

if TYPE_CHECKING:
    from pyros1.node.subscribing.inbox import Inbox
    from pyros1.node.subscribing.tcp_source import TcpSource

UNBOUNDED_LIMIT = 1000
"""Messages that wait at most when neither side set a queue size; the publisher then waits, as with TCP."""
Item = bytes | SplitBody | Message | AnyMsg
"""A message that waits: encoded, or handed over by a publisher in this process."""


class Source(Protocol):
    """Where frames come from: a link to a publisher."""

    header: dict[str, str]

    @property
    def connected(self) -> bool: ...


class HandingSource(Source, Protocol):
    """A source that hands over its messages itself, into an inbox: in this process, or over UDP."""

    uri: str
    transport: str
    address: str
    messages: int

    def close(self) -> None: ...


class Receiver(Protocol):
    """What a source that hands over its messages itself needs of the subscription: its `Delivery`."""

    def open(self, inbox: Inbox[Source, Item]) -> None:
        """Take messages out of an inbox from now on."""

    def push(self, inbox: Inbox[Source, Item], item: Item, limit: int | None) -> None:
        """Take a message; see `Delivery.push`."""

    def recover(self, inbox: Inbox[Source, Item]) -> None:
        """Look for what waits in an inbox, in case that was not said."""

    def wait_for_room(self, inbox: Inbox[Source, Item]) -> None:
        """Wait until not too many messages wait; see `Delivery.wait_for_room`."""


class Rest(NamedTuple):
    """What a link has received and had no time to deliver in its turn: the frames of ``data`` from ``position`` on."""

    link: TcpSource
    data: bytes
    frames: list[tuple[int, int]]
    position: int
