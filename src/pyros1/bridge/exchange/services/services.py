"""Services between sites: this site's, which others may call, and other sites'. No I/O."""

from __future__ import annotations

from collections.abc import Mapping

from pyros1.bridge.exchange.actions import Action
from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.exchange.services.calls import Calls
from pyros1.bridge.exchange.services.served import ServedServices
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.calls import CallHead
from pyros1.bridge.protocol.packet_values import PacketError
from pyros1.bridge.protocol.packets import Kind
from pyros1.bridge.rules.rules import Rules


class Services:
    """The services that a site shares with others.

    Args:
        rules: the site's rules.
        epoch: the site's epoch.
        peers: the other sites; shared with the caller, which updates it.

    Attributes:
        served: the services of this site.
        calls: the services of other sites, and the calls to them.
    """

    def __init__(self, rules: Rules, epoch: int, peers: Mapping[str, Peer]) -> None:
        self.served = ServedServices(rules, epoch, peers)
        self.calls = Calls(rules, epoch, peers)
        self._site = rules.site

    def on_packet(self, peer: str, service: SharedName, head: CallHead, body: bytes, now: float) -> list[Action]:
        """Handle a packet from another site's current run, and return the resulting actions.

        Raises:
            PacketError: it is about a service of a third site.
        """
        if service.site != (self._site if head.kind in (Kind.CALL, Kind.REPLY_SEEN) else peer):
            raise PacketError("a call of a third site's service")
        if head.kind is Kind.CALL:
            return self.served.on_call(peer, service, head, body, now)
        if head.kind is Kind.REPLY:
            return self.calls.on_reply(peer, service, head, body, now)
        if head.kind is Kind.CALL_SEEN:
            self.calls.on_seen(peer, head)
        else:
            self.served.on_reply_seen(peer, head)
        return []

    def on_lost(self, peer: str) -> list[Action]:
        """End the calls to a site that has stopped responding."""
        return self.calls.fail_all(peer, f"site {peer} does not respond")

    def drop_peer(self, peer: str, reason: str) -> list[Action]:
        """Forget the services of a site whose run has ended or is forgotten, and end its calls.

        Args:
            peer: the site.
            reason: what has happened to it.
        """
        self.served.drop_peer(peer)
        return self.calls.fail_all(peer, reason) + self.calls.set_offers(peer, ())

    def tick(self, now: float) -> list[Action]:
        """Return the actions that have become due."""
        return self.served.tick(now) + self.calls.tick(now)
