"""Where a subscription's messages come from, and what waits of them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, Protocol

from pyros1.msgs import AnyMsg, Message
from pyros1.msgs.large import SplitBody

if TYPE_CHECKING:
    from pyros1.node.inlink import InLink

Item = bytes | SplitBody | Message | AnyMsg
"""A message that waits: encoded, or handed over by a publisher in this process."""


class Source(Protocol):
    """Where frames come from: a link to a publisher."""

    header: dict[str, str]

    @property
    def connected(self) -> bool: ...


class Rest(NamedTuple):
    """What a link has received and had no time to deliver in its turn: the frames of ``data`` from ``position`` on."""

    link: InLink
    data: bytes
    frames: list[tuple[int, int]]
    position: int
