"""The lists between this site and another one. No I/O."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.protocol.calls import decode_services
from pyros1.bridge.protocol.packets import Kind, decode_offer, decode_request
from pyros1.bridge.protocol.versioned_lists import ListReceiver, ListSender

_DECODERS = {Kind.OFFER: decode_offer, Kind.REQUEST: decode_request, Kind.SERVICES: decode_services}
LIST_KINDS = tuple(_DECODERS)
"""The kinds of lists."""


class PeerLists:
    """The lists between this site and another one.

    Args:
        versions: the next version numbers; shared by all lists of a site.

    Attributes:
        offer, request, services: what this site sends.
        their_offer, their_request, their_services: what it receives.
        nodes: the nodes that the last heartbeat to the other site named.
        is_separate: whether that heartbeat said that the site gets its own packets.
    """

    def __init__(self, versions: Iterator[int]) -> None:
        self.offer, self.request, self.services = (ListSender(versions) for _ in range(3))
        self.their_offer, self.their_request, self.their_services = (ListReceiver() for _ in range(3))
        self.nodes: list[str] = []
        self.is_separate = False

    def due(self, peer: Peer, now: float) -> Iterator[tuple[Kind, bytes]]:
        """Yield the pages that the other site does not have yet, each after the kind of its list."""
        for kind, sender, seen in (
            (Kind.OFFER, self.offer, peer.offer_seen),
            (Kind.REQUEST, self.request, peer.request_seen),
            (Kind.SERVICES, self.services, peer.services_seen),
        ):
            if sender.is_due(seen, now):
                for page in sender.pages():
                    yield kind, page

    def accept(self, kind: Kind, body: bytes) -> list[Any] | None:
        """Handle a page of one of the other site's lists; return the entries of the list when it is new and complete.

        Raises:
            PacketError: the body is not valid.
        """
        receivers = {
            Kind.OFFER: self.their_offer,
            Kind.REQUEST: self.their_request,
            Kind.SERVICES: self.their_services,
        }
        return receivers[kind].accept(_DECODERS[kind](body))
