"""Sends the topics that the rules allow to the sites that request them. No I/O.

The bridge subscribes to a topic only while another site requests it. Nothing that came over a bridge is forwarded:
topics that only bridges publish are not offered, and messages from bridges are dropped.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from itertools import chain, islice
from typing import NamedTuple

from pyros1.bridge.conversions.conversion import Conversion, MessageType
from pyros1.bridge.exchange.actions import Action, RestartConversion, Send, Subscribe
from pyros1.bridge.exchange.answer_limits import AnswerLimits
from pyros1.bridge.exchange.latched_repeats import LatchedRepeats, Source
from pyros1.bridge.exchange.outgoing import DropReason, NumberedMessage, OutgoingTopic, ReceivedMessage
from pyros1.bridge.exchange.topic_packets import TopicPackets
from pyros1.bridge.names import SharedName, is_topic_name
from pyros1.bridge.protocol.packets import (
    MAX_DEFINITION,
    MAX_NODES,
    MAX_PUBLISHERS,
    Definition,
    OfferedTopic,
    Request,
    ResendRequest,
    Tail,
)
from pyros1.bridge.rules.rules import RuleMatch, Rules

_MAX_DEFINITIONS = 100
"""Maximum number of definitions sent in response to one request."""
MAX_ENDED_TOPICS = 10_000
"""Maximum number of topics, no longer sent, whose last numbers are remembered."""


class LocalTopic(NamedTuple):
    """A topic of this site's master that nodes other than bridges publish.

    Attributes:
        name: its full name.
        type, md5sum, definition: its message type.
        latched: whether a publisher latches its messages.
        publishers: the names of those nodes.
        convertible: the possible conversions, each with the message type that it produces.
        conversion: the conversion that has been applied; None for the original messages.
    """

    name: str
    type: str
    md5sum: str
    definition: str
    latched: bool
    publishers: tuple[str, ...]
    convertible: tuple[tuple[Conversion, MessageType], ...] = ()
    conversion: Conversion | None = None

    def converted(self, conversion: Conversion | None) -> LocalTopic:
        """Return the topic after a possible conversion; None leaves it unchanged."""
        if conversion is None:
            return self
        name, md5sum, definition = dict(self.convertible)[conversion]
        latched = self.latched and conversion.keeps_latched
        return self._replace(type=name, md5sum=md5sum, definition=definition, latched=latched, conversion=conversion)


class TopicCounts:
    """Counts the messages of a topic that were sent or delivered, and those dropped, by reason."""

    def __init__(self) -> None:
        self.messages = 0
        self.bytes = 0
        self.drops: dict[str, int] = {}

    def count(self, size: int) -> None:
        """Count a message of a given number of bytes."""
        self.messages += 1
        self.bytes += size

    def drop(self, reason: str) -> None:
        """Count a message that is dropped."""
        self.drops[reason] = self.drops.get(reason, 0) + 1


class _Sent(NamedTuple):
    topic: OutgoingTopic
    receivers: frozenset[str]
    is_private: bool  # other sites must not be able to read its messages
    local: LocalTopic
    flow: TopicCounts


class TopicSender:
    """The topics that a site sends.

    Args:
        rules: the site's rules.
        epoch: the site's epoch.

    Attributes:
        separate: the sites that get all messages in packets of their own, since they are slower than others.
    """

    def __init__(self, rules: Rules, epoch: int) -> None:
        self._rules = rules
        self._epoch = epoch
        self._locals: dict[str, LocalTopic] = {}
        self._peers: dict[str, int] = {}  # known other sites -> their epochs
        self._packets = TopicPackets(epoch)
        self._limits = AnswerLimits()
        self._requests: dict[str, dict[SharedName, float]] = {}
        self._sent: dict[SharedName, _Sent] = {}
        self._by_local: dict[Source, list[_Sent]] = {}
        # Numbering never restarts within an epoch. The last numbers of topics that are no longer sent, the newest last:
        self._last: dict[SharedName, int] = {}
        self._highest_forgotten = 0  # of the numbers that are no longer in `_last`
        self._subscribed: set[Source] = set()
        self._latched_repeats = LatchedRepeats()
        self._responding: frozenset[str] = frozenset()
        self._nodes: dict[str, list[str]] = {}  # peer -> see `nodes`
        self.separate: frozenset[str] = frozenset()

    # Current state ----------------------------------------------------------------------------------------------------

    def set_topics(self, topics: Iterable[LocalTopic], asked_at: float, now: float) -> list[Action]:
        """Record the topics of this site's master, and return the resulting actions.

        Args:
            topics: the topics.
            asked_at: when the master was asked for them, in seconds.
            now: the current time.
        """
        new_topics = {topic.name: topic for topic in topics if is_topic_name(topic.name) and topic.publishers}
        notes: list[Action] = []
        for sent in self._sent.values():
            remaining = new_topics.get(sent.local.name)
            gone = sent.topic.gone_publishers(remaining.publishers if remaining else (), asked_at)
            for note in sent.topic.drop_publishers(gone, now):
                notes += self._send(sent, note)
        self._locals = new_topics
        return notes + self._apply(now)

    def set_registered(self, publishers: Mapping[str, Collection[str]], asked_at: float) -> None:
        """Record which nodes are registered as publishers, even if they do not respond or no rule names their topics.

        Args:
            publishers: topic -> nodes.
            asked_at: when the master was asked for them, in seconds.
        """
        self._latched_repeats.drop_publishers(publishers, asked_at)

    def set_peers(self, epochs: Mapping[str, int], now: float) -> list[Action]:
        """Record which other sites are known, each with its epoch, and return the resulting actions."""
        for name in [name for name in self._requests if name not in epochs or self._peers.get(name) != epochs[name]]:
            del self._requests[name]
        self._peers = self._packets.epochs = dict(epochs)
        return self._apply(now)

    def set_requests(self, peer: str, requests: Iterable[Request], now: float) -> list[Action]:
        """Record what another site wants, and return the resulting actions."""
        before = self._requests.get(peer, {})
        wanted = self._requests[peer] = {request.topic: request.rate for request in requests}
        changed = {topic for topic in before.keys() | wanted.keys() if before.get(topic) != wanted.get(topic)}
        return self._apply_requests(self._sent[topic] for topic in sorted(changed) if topic in self._sent)

    def offers(self, peer: str) -> list[OfferedTopic]:
        """Return what is offered to another site."""
        return [
            sent.topic.offered._replace(publishers=_sendable_names(sent.local.publishers))
            for sent in self._sent.values()
            if peer in sent.receivers
        ]

    def _apply(self, now: float) -> list[Action]:
        """Update the outgoing topics to match topics, sites and requests."""
        self._update_sent()
        return self._apply_requests(self._sent.values())

    def _apply_requests(self, changed: Iterable[_Sent]) -> list[Action]:
        """Update the given outgoing topics to match requests, and the local subscriptions to match all requests."""
        self._nodes.clear()
        actions: list[Action] = []
        for sent in changed:
            requests = {
                peer: requested[sent.topic.topic]
                for peer, requested in self._requests.items()
                if peer in sent.receivers and sent.topic.topic in requested
            }
            new_peers = requests.keys() - sent.topic.requests.keys()
            if new_peers and not sent.topic.requests and sent.topic.offered.latched:
                for other in self._by_local[sent.local.name, sent.local.conversion]:
                    if other.topic.requests:
                        sent.topic.copy_latched(other.topic)
                        break
            sent.topic.set_requests(requests)
            if not requests:
                sent.topic.forget_all()
            elif sent.topic.offered.latched:
                for peer in sorted(new_peers):
                    actions += self._packets.latched_list(sent.topic, peer)
            if new_peers and sent.local.conversion is not None:
                actions.append(RestartConversion(sent.local.name, sent.local.conversion))
        needed = {(sent.local.name, sent.local.conversion) for sent in self._sent.values() if sent.topic.requests}
        for on, sources in ((False, self._subscribed - needed), (True, needed - self._subscribed)):
            in_order = sorted(sources, key=lambda source: (source[0], source[1] or ()))
            actions += [Subscribe(local, on, conversion) for local, conversion in in_order]
        for source in needed - self._subscribed:
            self._latched_repeats.on_subscribe(source)
        self._subscribed = needed
        return actions

    def _update_sent(self) -> None:
        old, self._sent, self._by_local = self._sent, {}, {}
        for outgoing, local in self._outgoing():
            shared, rule = outgoing
            if shared in self._sent:
                continue  # two local topics would have the same name between sites: the first one is sent
            name, conversion = local.name, local.conversion
            settings = rule.settings(name, local.type)
            is_latched = local.latched and settings.may_latch
            offered = OfferedTopic(shared, local.type, local.md5sum, is_latched, settings.reliable)
            before = old.get(shared)
            is_same = before is not None and (before.local.name, before.local.conversion) == (name, conversion)
            if before is not None and is_same and before.topic.offered._replace(latched=is_latched) == offered:
                topic, flow = before.topic, before.flow
                topic.offered = offered  # other sites request the latched messages themselves
            else:
                topic, flow = OutgoingTopic(offered, settings, self._epoch), TopicCounts()
                topic.last = before.topic.last if before else self._last.pop(shared, self._highest_forgotten)
            receivers = frozenset(self._rules.receivers(outgoing, self._peers))
            is_private = bool(rule.sites) or shared.site != self._rules.site
            sent = self._sent[shared] = _Sent(topic, receivers, is_private, local, flow)
            self._by_local.setdefault((name, conversion), []).append(sent)
        self._last.update(
            (shared, sent.topic.last)
            for shared, sent in old.items()
            if shared not in self._sent and sent.topic.last > self._highest_forgotten
        )
        while len(self._last) > MAX_ENDED_TOPICS:
            self._highest_forgotten = max(self._highest_forgotten, self._last.pop(next(iter(self._last))))

    def _outgoing(self) -> list[tuple[RuleMatch, LocalTopic]]:
        """Return what the rules allow, with conversions last, since a node may publish the converted topic itself."""
        found = []
        for name in sorted(self._locals):
            topic = self._locals[name]
            possible = {conversion for conversion, _ in topic.convertible}
            for outgoing in self._rules.outgoing(name, self._peers, possible):
                found.append((outgoing, topic.converted(outgoing.rule.convert)))
        return sorted(found, key=lambda each: each[1].conversion is not None)

    # Messages ---------------------------------------------------------------------------------------------------------

    def would_send(
        self, local: str, conversion: Conversion, received: ReceivedMessage, is_bridged: bool, now: float
    ) -> bool:
        """Return whether a message would be sent after a conversion; if not, it is counted as dropped.

        Args:
            local: the topic's name on this site's master.
            conversion: the conversion.
            received: the message before the conversion.
            is_bridged: whether a bridge has published it.
            now: the time in seconds that `on_message` will be given.
        """
        requested = [sent for sent in self._by_local.get((local, conversion), ()) if sent.topic.requests]
        if not is_bridged and any(sent.topic.is_due(received, now) for sent in requested):
            return True
        self._drop(requested, DropReason.BRIDGED if is_bridged else DropReason.RATE)
        return False

    def drop(self, local: str, conversion: Conversion, publisher: str, reason: str, now: float) -> list[Action]:
        """Count a message that was not converted, and return the packets to send.

        Args:
            local: the topic's name on this site's master.
            conversion: the conversion.
            publisher: who published it.
            reason: why it was not converted.
            now: the current time in seconds.
        """
        actions: list[Action] = []
        for sent in self._by_local.get((local, conversion), ()):
            actions += self._drop_message(sent, publisher, reason, now)
        return actions

    def _drop_message(self, sent: _Sent, publisher: str, reason: str, now: float) -> list[Send]:
        """Count a message that is dropped. Its publisher's latched message is then outdated, unless a newer one will
        replace it.
        """
        sent.flow.drop(reason)
        if reason in (DropReason.RATE, DropReason.OVERTAKEN):
            return []
        return [packet for note in sent.topic.withdraw_latched(publisher, now) for packet in self._send(sent, note)]

    def _drop(self, sent_topics: Iterable[_Sent], reason: str) -> None:
        for sent in sent_topics:
            sent.flow.drop(reason)

    def on_message(
        self,
        local: str,
        received: ReceivedMessage,
        is_bridged: bool,
        now: float,
        conversion: Conversion | None = None,
    ) -> list[Action]:
        """Return the packets to send for a message.

        Args:
            local: the topic's name on this site's master.
            received: the message.
            is_bridged: whether a bridge has published it.
            now: the current time in seconds, or the arrival time of a message that had to be converted first.
            conversion: how it was converted; None if it was not.
        """
        actions: list[Action] = []
        requested = [sent for sent in self._by_local.get((local, conversion), ()) if sent.topic.requests]
        if not requested:
            return []
        source = (local, conversion)
        is_repeated = received.latched and self._latched_repeats.take(source, received.publisher, received.uri, now)
        for sent in requested:
            message = DropReason.BRIDGED if is_bridged else sent.topic.take(received, now, is_repeated)
            if isinstance(message, str):
                actions += self._drop_message(sent, received.publisher, message, now)
            else:
                actions += self._send(sent, message)
        return actions

    def _send(self, sent: _Sent, message: NumberedMessage) -> list[Send]:
        sent.flow.count(len(message.body))
        separate = (
            sent.topic.requests if sent.is_private else self.separate and sent.topic.requests.keys() & self.separate
        )
        return self._packets.of_message(sent.topic, message, separate)

    def tick(self, now: float) -> list[Action]:
        """Return the packets to send because time has passed."""
        actions: list[Action] = []
        for sent in self._sent.values():
            if sent.topic.is_lossless:
                for message in sent.topic.due(now):
                    actions += self._send(sent, message)
        return actions

    # Requests from other sites ----------------------------------------------------------------------------------------

    def tails(self, peer: str) -> dict[SharedName, Tail]:
        """Return the end of each lossless topic that another site has requested."""
        return {
            shared: sent.topic.tail(peer)
            for shared, sent in self._sent.items()
            if sent.topic.is_lossless and peer in sent.topic.requests
        }

    def set_responding(self, nodes: Iterable[str]) -> None:
        """Record which nodes respond, among those whose topics other sites want."""
        self._responding = frozenset(nodes)
        self._nodes.clear()

    def nodes(self, peer: str) -> list[str]:
        """Return the responding nodes whose topics another site wants."""
        if peer not in self._nodes:
            wanted = (sent.local.publishers for sent in self._sent.values() if peer in sent.topic.requests)
            self._nodes[peer] = sorted(self._responding.intersection(chain.from_iterable(wanted)))[:MAX_NODES]
        return self._nodes[peer]

    def on_missed(self, peer: str, missed: ResendRequest, now: float) -> list[Action]:
        """Return the packets to send because another site missed messages."""
        sent = self._sent.get(missed.topic)
        if sent is None or peer not in sent.topic.requests or not self._limits.may_resend(peer, missed.topic, now):
            return []
        packets = self._packets.resend(sent.topic, peer, missed)
        self._limits.note_resent(peer, sum(len(packet.body) for packet in packets))
        return [*packets]

    def on_ask(self, peer: str, md5sums: Iterable[str], now: float) -> list[Action]:
        """Return the requested definitions that belong to topics offered to the requesting site."""
        if not self._limits.may_answer(peer, None, now):
            return []
        known = {
            sent.local.md5sum: Definition(
                sent.local.type, sent.local.md5sum, _bounded_definition(sent.local.definition)
            )
            for sent in self._sent.values()
            if peer in sent.receivers
        }
        asked = islice(dict.fromkeys(md5sums), _MAX_DEFINITIONS)
        return [self._packets.definition(peer, known[md5sum]) for md5sum in asked if md5sum in known]

    def common_receivers(self) -> list[str]:
        """Return the sites that get messages in common packets."""
        peers = {peer for sent in self._sent.values() if not sent.is_private for peer in sent.topic.requests}
        return sorted(peers - self.separate)

    def flows(self) -> list[tuple[OutgoingTopic, LocalTopic, TopicCounts]]:
        """Return the outgoing topics, each with its local topic and its flow, for the status."""
        return [(sent.topic, sent.local, sent.flow) for sent in self._sent.values()]


def _sendable_names(publishers: Iterable[str]) -> tuple[str, ...]:
    return tuple(sorted(filter(is_topic_name, publishers))[:MAX_PUBLISHERS])


def _bounded_definition(definition: str) -> str:
    """Return a definition's text; empty if it is too long to send, since messages are usable without it."""
    return definition if len(definition) <= MAX_DEFINITION else ""
