"""The lists between this site and another one. No I/O."""

from __future__ import annotations

from collections.abc import Iterator

from pyros1.bridge.protocol.versioned_lists import ListReceiver, ListSender


class PeerLists:
    """The lists between this site and another one.

    Args:
        versions: the next version; shared by all lists of a site.

    Attributes:
        offer, request, services: what this site sends.
        their_offer, their_request, their_services: what it receives.
        nodes: the nodes that the other site's last heartbeat named.
    """

    def __init__(self, versions: Iterator[int]) -> None:
        self.offer, self.request, self.services = (ListSender(versions) for _ in range(3))
        self.their_offer, self.their_request, self.their_services = (ListReceiver() for _ in range(3))
        self.nodes: list[str] = []
