"""The packets that announce a site, its offers and its requests to other sites. No I/O."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import count

from pyros1.bridge.exchange.actions import Action, Send
from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.exchange.peer_lists import PeerLists
from pyros1.bridge.exchange.services.services import Services
from pyros1.bridge.exchange.slow_sites import SlowSites
from pyros1.bridge.exchange.topic_receiver import TopicReceiver
from pyros1.bridge.exchange.topic_sender import TopicSender
from pyros1.bridge.protocol.key_expressions import HELLO, peer_key
from pyros1.bridge.protocol.packets import Kind, encode_head, encode_heartbeat
from pyros1.bridge.rules.rules import Priority


class Announcements:
    """Makes the hello packets, heartbeats and lists for other sites.

    Args:
        epoch: the site's epoch.
        peers: the other sites; shared with the caller, which updates it.
        topic_sender, topic_receiver, services, slow_sites: the sources of the lists.

    Attributes:
        lists: the lists exchanged with each other site.
    """

    def __init__(
        self,
        epoch: int,
        peers: Mapping[str, Peer],
        topic_sender: TopicSender,
        topic_receiver: TopicReceiver,
        services: Services,
        slow_sites: SlowSites,
    ) -> None:
        self.lists: dict[str, PeerLists] = {}
        self._epoch = epoch
        self._peers = peers
        self._topic_sender = topic_sender
        self._topic_receiver = topic_receiver
        self._services = services
        self._slow_sites = slow_sites
        self._versions = count(1)

    def begin(self, name: str) -> None:
        """Start with empty lists for a site that is new or has restarted."""
        self.lists[name] = PeerLists(self._versions)

    def hello(self) -> Action:
        """Return the packet with which sites discover each other."""
        return Send(HELLO, encode_head(Kind.HELLO, self._epoch), priority=Priority.URGENT, replaces=0, may_drop=True)

    def heartbeats(self, now: float) -> list[Action]:
        """Return the heartbeats that are due."""
        actions: list[Action] = []
        for peer in self._peers.values():
            lists = self.lists[peer.name]
            nodes = self._topic_sender.nodes(peer.name) if peer.is_present else []
            is_separate = self._slow_sites.is_flagged(peer.name, now)
            if peer.wants_heartbeat(now) or nodes != lists.nodes or is_separate != lists.is_separate:
                lists.nodes, lists.is_separate = nodes, is_separate
                seen = (lists.their_offer.version, lists.their_request.version)
                tails = self._topic_sender.tails(peer.name)
                versions = (lists.offer.version, lists.request.version)
                services = (lists.services.version, lists.their_services.version)
                epoch, heartbeat = peer.make_heartbeat(now, *versions, seen, tails, services, nodes, is_separate)
                head = encode_head(Kind.HEARTBEAT, self._epoch, epoch)
                actions.append(Send(peer_key(peer.name), head, encode_heartbeat(heartbeat), Priority.URGENT))
        return actions

    def update(self, now: float) -> list[Action]:
        """Update all lists after a change of topics, sites or subscribers; return the pages that must be sent."""
        for name, lists in self.lists.items():
            lists.offer.update(self._topic_sender.offers(name))
        self.update_services()
        return self.update_requests(now)

    def update_services(self) -> None:
        """Bring the lists of services up to date."""
        for name, lists in self.lists.items():
            lists.services.update(self._services.served.offers(name))

    def update_requests(self, now: float) -> list[Action]:
        """Update the requests after a change of subscribers or offers; return the pages that must be sent."""
        requests = self._topic_receiver.requests()
        for name, lists in self.lists.items():
            lists.request.update(requests.get(name, ()))
        return self.pages(now)

    def pages(self, now: float) -> list[Action]:
        """Return the pages of lists that are due."""
        actions: list[Action] = []
        for peer in self._peers.values():
            if not peer.is_present:
                continue
            for kind, page in self.lists[peer.name].due(peer, now):
                actions.append(Send(peer_key(peer.name), encode_head(kind, self._epoch, peer.epoch), page))
        return actions
