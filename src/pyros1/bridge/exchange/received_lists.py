"""Applies the lists of other sites: what they offer, want and serve. No I/O."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from pyros1.bridge.exchange.actions import Action
from pyros1.bridge.exchange.announcements import Announcements
from pyros1.bridge.exchange.limits import Limits
from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.exchange.services.services import Services
from pyros1.bridge.exchange.topic_receiver import TopicReceiver
from pyros1.bridge.exchange.topic_sender import TopicSender
from pyros1.bridge.protocol.packets import Kind


class ReceivedLists:
    """The lists that other sites have sent.

    Args:
        peers: the other sites; shared with the caller, which updates it.
        limits: their limits.
        announcements: has the lists, and makes the requests that follow from offers.
        topic_sender, topic_receiver, services: what the lists change.
    """

    def __init__(
        self,
        peers: Mapping[str, Peer],
        limits: Limits,
        announcements: Announcements,
        topic_sender: TopicSender,
        topic_receiver: TopicReceiver,
        services: Services,
    ) -> None:
        self._peers = peers
        self._limits = limits
        self._announcements = announcements
        self._topic_sender = topic_sender
        self._topic_receiver = topic_receiver
        self._services = services

    def on_page(self, kind: Kind, site: str, body: bytes, now: float) -> list[Action]:
        """Handle a page of a list, and return the resulting actions.

        Args:
            kind: the kind of the list.
            site: the site that has sent it.
            body: the page.
            now: the current time in seconds.

        Raises:
            PacketError: the page is not valid.
        """
        entries = self._announcements.lists[site].accept(kind, body)
        if entries is None:
            return []
        self._limits.of(site, self._peers).lists.put(kind, entries)
        return self.apply(now)

    def apply(self, now: float) -> list[Action]:
        """Apply the lists that sites have sent, unless they change too often."""
        actions: list[Action] = []
        if not self._topic_receiver.may_update(now):
            return actions
        has_offers = False
        for site in self._peers:
            for kind, entries in self._limits.of(site, self._peers).lists.take(now):
                if kind is Kind.REQUEST:
                    actions += self._topic_sender.set_requests(site, entries, now)
                    self._peers[site].answer_due = True  # a heartbeat tells it where the topics begin
                elif kind is Kind.SERVICES:
                    actions += self._services.calls.set_offers(site, entries)
                else:
                    has_offers = True
                    actions += self._topic_receiver.note_offers(site, entries, now)
        actions += self._announcements.heartbeats(now)
        if not has_offers:
            return actions
        return actions + self._topic_receiver.update(now) + self._announcements.update_requests(now)

    def apply_offers_again(self, sites: Collection[str], now: float) -> list[Action]:
        """Apply the last offers of some sites again, since different topics may now be refused."""
        if not sites:
            return []
        actions: list[Action] = []
        for site in sites:
            actions += self._topic_receiver.note_offers(site, self._announcements.lists[site].their_offer.entries, now)
        return actions + self._topic_receiver.apply(now) + self._announcements.update_requests(now)
