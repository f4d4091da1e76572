"""The state machine of a site: tracks other sites, and exchanges topics with them. Values in, actions out; no I/O.

Its runner calls `on_packet` for each packet, `on_message` for each message of a topic it has subscribed to,
`set_used_topics`, `set_topics` and `set_subscribed` when the graph of the site's master has changed, and `tick` several
times per second. All of them get the time in seconds by a clock that never jumps, and return actions to carry out in
order.

How a site reacts to another one, by its state (`peer.State`):

====================  ================================================================================================
event                 what follows
====================  ================================================================================================
heard                 a heartbeat is sent, since only an answer to it proves that the other site is running now
started (present)     the state of an earlier run is dropped; both send their offers, then their requests
heartbeat             lists that the other site lacks are sent again; missed messages are requested
lost                  its topics are withdrawn here, so that subscribers notice, and calls of its services fail; nothing
                      more is sent to it specifically; its state and its requests are kept
returned (present)    the same run goes on: its topics are published again, missed messages that are not too old are
                      requested, new messages flow
forgotten, goodbye    its topics are withdrawn here; its requests, and subscriptions that nobody else needs, are dropped
====================  ================================================================================================
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from itertools import count

from pyros1.bridge.conversions.conversion import Conversion
from pyros1.bridge.exchange.actions import Action, Log, Probe, ProbeReply, Send
from pyros1.bridge.exchange.announcements import Announcements
from pyros1.bridge.exchange.incoming import ReceivedTopic
from pyros1.bridge.exchange.limits import Limits
from pyros1.bridge.exchange.outgoing import OutgoingTopic, ReceivedMessage
from pyros1.bridge.exchange.peer import Change, Peer, SiteStatus
from pyros1.bridge.exchange.peer_lists import LIST_KINDS
from pyros1.bridge.exchange.received_lists import ReceivedLists
from pyros1.bridge.exchange.remote_nodes import RemoteNodes
from pyros1.bridge.exchange.services.served import LocalService
from pyros1.bridge.exchange.services.services import Services
from pyros1.bridge.exchange.slow_sites import SlowSites
from pyros1.bridge.exchange.topic_receiver import TopicReceiver
from pyros1.bridge.exchange.topic_sender import LocalTopic, TopicCounts, TopicSender
from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.calls import decode_call_head
from pyros1.bridge.protocol.key_expressions import Channel, Key, peer_key
from pyros1.bridge.protocol.packet_values import PacketError
from pyros1.bridge.protocol.packets import (
    Kind,
    decode_ask,
    decode_definition,
    decode_head,
    decode_heartbeat,
    decode_latched_list,
    decode_message_head,
    decode_probe,
    decode_resend_refusal,
    decode_resend_request,
    encode_head,
    encode_probe,
)
from pyros1.bridge.rules.namespaces import UsedTopics
from pyros1.bridge.rules.rules import Priority, Rules

_HELLO_PERIOD = 1.0
"""Seconds between hello packets, by which sites find each other."""
MAX_SITES = 256
"""Maximum number of other sites; packets from further ones are ignored."""


class Site:
    """The state machine of a site.

    Args:
        rules: its rules, which contain its name.
        epoch: a random number from 1 to 2^64 - 1, a new one for each run.
        now: the current time.

    Attributes:
        ignored: how many packets were ignored for each reason.
        services: the services of this and other sites, and the calls to them.
        topic_receiver: receives the topics that the rules accept.
    """

    def __init__(self, rules: Rules, epoch: int, now: float) -> None:
        self.ignored: dict[str, int] = {}
        self._rules = rules
        self._epoch = epoch
        self._peers: dict[str, Peer] = {}
        self._heartbeat_numbers = count(1)
        self._limits = Limits()
        self._topic_sender = TopicSender(rules, epoch)
        self.topic_receiver = TopicReceiver(rules, epoch, self._peers)
        self.services = Services(rules, epoch, self._peers)
        self._remote_nodes = RemoteNodes(rules)
        self._slow_sites = SlowSites()
        self._announcements = Announcements(
            epoch, self._peers, self._topic_sender, self.topic_receiver, self.services, self._slow_sites
        )
        self._received_lists = ReceivedLists(
            self._peers, self._limits, self._announcements, self._topic_sender, self.topic_receiver, self.services
        )
        self._hello_at = now
        self._has_namesake = False
        self._on_kind: Mapping[Kind, Callable[[str, bytes, float], list[Action]]] = {
            **{kind: partial(self._received_lists.on_page, kind) for kind in LIST_KINDS},
            Kind.ASK: lambda peer, body, now: self._topic_sender.on_ask(peer, decode_ask(body), now),
            Kind.DEFINITION: self._on_definition,
            Kind.PROBE: self._on_probe,
            Kind.PROBE_REPLY: lambda peer, body, _: [ProbeReply(peer, decode_probe(body))],
            Kind.RESEND_REQUEST: lambda peer, body, now: self._topic_sender.on_missed(
                peer, decode_resend_request(body), now
            ),
            Kind.LATCHED_LIST: lambda peer, body, now: self.topic_receiver.on_latched_list(
                peer, decode_latched_list(body), now
            ),
            Kind.RESEND_REFUSAL: lambda peer, body, now: self.topic_receiver.on_gone(
                peer, decode_resend_refusal(body), now
            ),
        }

    @property
    def name(self) -> str:
        """The site's name."""
        return self._rules.site

    # This site's master -----------------------------------------------------------------------------------------------

    def set_topics(self, topics: Iterable[LocalTopic], asked_at: float, now: float) -> list[Action]:
        """Record the topics that this site's nodes, except bridges, published when its master was queried."""
        actions = self._topic_sender.set_topics(topics, asked_at, now)
        actions += self._announcements.update(now)
        return actions + self._announcements.heartbeats(now)

    def set_used_topics(self, used: UsedTopics, now: float) -> list[Action]:
        """Record which topics this site's nodes, except bridges, use. Before this, no topics are taken from sites that
        no rule names, since they may be named like these nodes' namespaces.
        """
        return self._received_lists.apply_offers_again(self.topic_receiver.set_used_topics(used), now)

    def set_responding(self, nodes: Iterable[str], now: float) -> list[Action]:
        """Record which nodes respond, among those whose topics other sites want."""
        self._topic_sender.set_responding(nodes)
        return self._announcements.heartbeats(now)

    def set_subscribed(self, subscribed: Iterable[str], now: float) -> list[Action]:
        """Record which of the topics published here for other sites have subscribers."""
        return self.topic_receiver.set_subscribed(subscribed, now) + self._announcements.update_requests(now)

    def on_message(
        self,
        local: str,
        received: ReceivedMessage,
        is_bridged: bool,
        now: float,
        conversion: Conversion | None = None,
    ) -> list[Action]:
        """Handle a message of a topic of this site's master.

        Args:
            local: the topic's name.
            received: the message.
            is_bridged: whether its publisher is a bridge, this one or another.
            now: the current time, or the arrival time of a message that had to be converted first.
            conversion: how it was converted; None if it was not.
        """
        return self._topic_sender.on_message(local, received, is_bridged, now, conversion)

    @property
    def topic_sender(self) -> TopicSender:
        """The sender of the site's topics: it decides which messages to convert, and counts those not converted."""
        return self._topic_sender

    # Services ---------------------------------------------------------------------------------------------------------

    def set_services(self, services: Iterable[LocalService], taken: Mapping[str, str], now: float) -> list[Action]:
        """Record which services nodes of this site's master provide.

        Args:
            services: the services of nodes other than bridges, with their types.
            taken: the name of each service that this bridge does not provide -> the node that provides it.
            now: the current time.
        """
        self.services.served.set_services(services)
        self._announcements.update_services()
        return self.services.calls.set_taken(taken) + self._announcements.pages(now)

    # Time -------------------------------------------------------------------------------------------------------------

    def start(self) -> list[Action]:
        """Return the first actions."""
        return [self._announcements.hello()]

    def tick(self, now: float) -> list[Action]:
        """Return the actions that are due."""
        actions: list[Action] = []
        if now - self._hello_at >= _HELLO_PERIOD:
            self._hello_at = now
            actions.append(self._announcements.hello())
        lost = [peer for peer in self._peers.values() if peer.tick(now)]
        for peer in lost:
            actions.append(Log(f"site {peer.name} has stopped responding", is_warning=True))
            actions += self.services.on_lost(peer.name) + self._remote_nodes.drop(peer.name)
        if lost:
            actions += self.topic_receiver.apply(now) + self._announcements.update(now)
        for peer in self._peers.values():
            if peer.pop_namesake():
                actions.append(Log(f"two bridges are named {peer.name}: use another --site", is_warning=True))
        if forgotten := [peer for peer in self._peers.values() if peer.is_forgotten(now)]:
            actions += self._forget(forgotten, now, "does not respond")
        if self._slow_sites.tick(now, self._peers):
            self._topic_sender.separate = self._slow_sites.separate
        actions += self.services.tick(now)
        actions += self._topic_sender.tick(now)
        actions += self.topic_receiver.tick(now)
        actions += self._received_lists.apply(now)
        actions += self._update_if_outdated(now)
        if self.topic_receiver.end_pauses(now):
            actions += self._announcements.update(now)
        return actions + self._announcements.heartbeats(now) + self._announcements.pages(now)

    def leave(self) -> list[Action]:
        """Return the last actions, which tell other sites that this one leaves."""
        return [
            Send(peer_key(peer.name), encode_head(Kind.BYE, self._epoch, peer.epoch), priority=Priority.URGENT)
            for peer in self._peers.values()
            if peer.is_present
        ]

    def _to(self, name: str, kind: Kind, body: bytes, priority: Priority = Priority.URGENT) -> Send:
        return Send(peer_key(name), encode_head(kind, self._epoch, self._peers[name].epoch), body, priority)

    def probes(self, receiver: str, number: int, priority: Priority) -> list[Probe]:
        """Return probes for one site, or for all that get common packets, see `pyros1.bridge.transport.pacer`."""
        names = [receiver] if receiver else self._topic_sender.common_receivers()
        peers = [self._peers[name] for name in names if name in self._peers and self._peers[name].is_present]
        body = encode_probe(number)
        packets = ((peer, self._to(peer.name, Kind.PROBE, body, priority)) for peer in peers)
        return [Probe(peer.name, peer.clock.shortest_round_trip, packet) for peer, packet in packets]

    def on_slow(self, site: str, now: float) -> list[Action]:
        """Record that a site holds up others, and return the resulting actions."""
        if site in self._peers:
            self._slow_sites.add(site, now)
        self._topic_sender.separate = self._slow_sites.separate
        return self._announcements.heartbeats(now)

    # Packets ----------------------------------------------------------------------------------------------------------

    def on_packet(self, key: Key, head: bytes, body: bytes, now: float) -> list[Action]:
        """Handle a packet from another site. Invalid packets are ignored and counted.

        Args:
            key: the key on which it came.
            head, body: the packet.
            now: the current time.
        """
        site = self._rules.site
        if key.site == site:
            return self._on_namesake()
        if not self._rules.talks_to(key.site) or key.receiver not in ("", site):
            return []
        try:
            if key.topic is not None and key.channel is Channel.CALL:
                return self._on_call_packet(key.site, key.topic, head, body, now)
            if key.topic is not None:
                return self._on_message_packet(key.site, key.topic, head, body, now)
            return self._on_control(key, head, body, now)
        except PacketError as error:
            return self._ignore(f"{key.site}: {error}")

    def _on_namesake(self) -> list[Action]:
        if self._has_namesake:
            return []
        self._has_namesake = True
        text = f"another bridge is also named {self.name}: each site needs its own name"
        return [Log(text, is_warning=True)]

    def _on_message_packet(self, site: str, topic: SharedName, head: bytes, body: bytes, now: float) -> list[Action]:
        message = decode_message_head(head)
        peer = self._peers.get(site)
        if peer is None or not peer.is_current(message.epoch, message.to_epoch):
            return self._ignore(f"{site}: messages from a run that is not current")
        return self.topic_receiver.on_message(site, topic, message, body, now)

    def _on_call_packet(self, site: str, service: SharedName, head: bytes, body: bytes, now: float) -> list[Action]:
        call = decode_call_head(head)
        peer = self._peers.get(site)
        if peer is None or call.to_epoch != self._epoch or not peer.is_current(call.epoch, call.to_epoch):
            return self._ignore(f"{site}: calls from a run that is not current")
        return self.services.on_packet(site, service, call, body, now)

    def _on_control(self, key: Key, head: bytes, body: bytes, now: float) -> list[Action]:
        kind, epoch, to_epoch = decode_head(head)
        if epoch == 0:
            raise PacketError("a packet without an epoch")
        if kind is Kind.HELLO:
            peer = self._find_or_add(key.site, now)
            if peer is not None and (peer.epoch != epoch or not peer.is_present):
                peer.hear(epoch, now)
            return [] if peer is None else self._announcements.heartbeats(now)
        if key.channel is not Channel.TO:
            raise PacketError("a packet on the wrong key")
        if kind is Kind.HEARTBEAT:
            return self._on_heartbeat(key.site, epoch, to_epoch, body, now)
        peer = self._peers.get(key.site)
        if peer is None or to_epoch != self._epoch or not peer.is_current(epoch, to_epoch):
            return self._ignore(f"{key.site}: packets from a run that is not current")
        if kind is Kind.BYE:
            return [Log(f"site {peer.name} has left"), *self._forget([peer], now, "has left")]
        handler = self._on_kind.get(kind)
        if handler is None:
            raise PacketError("a packet on the wrong key")
        return handler(key.site, body, now)

    def _ignore(self, reason: str) -> list[Action]:
        if reason in self.ignored or len(self.ignored) < 1000:
            self.ignored[reason] = self.ignored.get(reason, 0) + 1
        return []

    def _find_or_add(self, name: str, now: float) -> Peer | None:
        peer = self._peers.get(name)
        if peer is None:
            if len(self._peers) >= MAX_SITES:
                self._ignore("too many sites")
                return None
            peer = self._peers[name] = Peer(name, self._epoch, self._heartbeat_numbers, now, self._rules.loss_delay)
            self._announcements.begin(name)
        return peer

    def _on_heartbeat(self, site: str, epoch: int, to_epoch: int, body: bytes, now: float) -> list[Action]:
        heartbeat = decode_heartbeat(body)
        peer = self._find_or_add(site, now)
        if peer is None:
            return []
        change = peer.on_heartbeat(epoch, to_epoch, heartbeat, now)
        if change is Change.OUTDATED:
            return []
        actions: list[Action] = []
        if change is Change.STARTED:
            actions += self._remote_nodes.drop(site)
            actions += self.topic_receiver.drop_peer(site, now) + self.topic_receiver.apply(now)
            actions += self.services.drop_peer(site, f"site {site} has started again")
            self._announcements.begin(site)
            self._limits.of(site, self._peers).lists.clear()
            actions += self._update_peers(now)
            actions += self._announcements.heartbeats(now)
            actions += self._announcements.update(now)
            if not peer.alternates:  # `tick` warns about two bridges with the same name
                actions.append(Log(f"site {site} is present"))
        elif change is Change.RETURNED:
            self.topic_receiver.on_return(site, now)
            actions += self._announcements.heartbeats(now) + self._update_if_outdated(now)
            actions.append(Log(f"site {site} responds again"))
        if peer.is_current(epoch, to_epoch):
            limits = self._limits.of(site, self._peers)
            # It should name only publishers of topics that are wanted here.
            nodes = heartbeat.nodes if self._announcements.lists[site].request.entries else ()
            actions += self._remote_nodes.update(site, nodes, limits.nodes, now)
            actions += self.topic_receiver.set_separate(site, heartbeat.is_separate, limits.separate, now)
            actions += self.topic_receiver.on_tails(site, heartbeat.tails, now)
        # Heartbeats go first: the other site may consider this one present only after receiving one.
        return actions + self._announcements.heartbeats(now) + self._announcements.pages(now)

    def _update_peers(self, now: float) -> list[Action]:
        epochs = {peer.name: peer.epoch for peer in self._peers.values() if peer.epoch}
        return self._topic_sender.set_peers(epochs, now)

    def _forget(self, peers: Iterable[Peer], now: float, reason: str) -> list[Action]:
        actions: list[Action] = []
        for peer in peers:
            actions += self._remote_nodes.drop(peer.name) + self.topic_receiver.drop_peer(peer.name, now)
            actions += self.services.drop_peer(peer.name, f"site {peer.name} {reason}")
            del self._peers[peer.name], self._announcements.lists[peer.name]
            self._limits.of(peer.name, self._peers).lists.clear()
        actions += self.topic_receiver.apply(now) + self._update_peers(now)
        return actions + self._announcements.update(now)

    def _on_definition(self, site: str, body: bytes, now: float) -> list[Action]:
        token_bucket = self._limits.of(site, self._peers).definitions
        if not token_bucket.take(now):
            return self._ignore(f"{site}: too many definitions")
        token_bucket.charge(len(body))
        self.topic_receiver.on_definition(site, decode_definition(body))
        return self._update_if_outdated(now)

    def _update_if_outdated(self, now: float) -> list[Action]:
        """Apply new definitions and the return of sites, unless that happens too often."""
        actions = self.topic_receiver.update_if_outdated(now)
        return [] if actions is None else actions + self._announcements.update_requests(now)

    def _on_probe(self, site: str, body: bytes, now: float) -> list[Action]:
        number = decode_probe(body)
        if not self._limits.of(site, self._peers).probes.take(now):
            return self._ignore(f"{site}: too many probes")
        return [self._to(site, Kind.PROBE_REPLY, encode_probe(number))]

    # Status -----------------------------------------------------------------------------------------------------------

    def sites(self) -> list[SiteStatus]:
        """Return the state of each other site."""
        nodes, slow = self._remote_nodes.names, self._slow_sites.separate
        peers = self._peers.items()
        return [
            SiteStatus(name, peer.state, peer.clock.round_trip, nodes(name), name in slow, peer.is_shared)
            for name, peer in peers
        ]

    def known_sites(self) -> frozenset[str]:
        """Return the other sites that have been present, even if they are lost now."""
        return frozenset(name for name, peer in self._peers.items() if peer.epoch)

    def sent_topics(self) -> list[tuple[OutgoingTopic, LocalTopic, TopicCounts]]:
        """Return the offered topics, each with its local topic and its flow."""
        return self._topic_sender.flows()

    def default_name(self, topic: SharedName) -> str:
        """Return the default name of a topic on this site's master, for when no rule renames it."""
        return self._rules.default_name(topic)

    def received_topics(self) -> list[ReceivedTopic]:
        """Return the topics that other sites offer."""
        return self.topic_receiver.topics()
