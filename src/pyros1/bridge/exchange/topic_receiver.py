"""The topics that a site receives from others, and the messages that are published here. No I/O.

An offered topic that a rule accepts is advertised on this site's master as soon as its definition is known, so that
programs see it. It is requested from the other site only while a local node subscribes to it.

While its site is lost, a topic is not advertised unless another site sends it too: subscribers lose their connections,
and so notice that no publisher is left. Requested topics are *paused* meanwhile: if a node subscribes again soon after
the site's return, the stream continues where it stopped.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from pyros1.bridge.conversions.prefixes import Prefixer
from pyros1.bridge.exchange.actions import Action, Listen, Log, Send
from pyros1.bridge.exchange.definitions import Definitions
from pyros1.bridge.exchange.delivering import deliver
from pyros1.bridge.exchange.incoming import IncomingTopic, ReceivedTopic
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.exchange.outputs import Candidate, Feed, Output, Outputs, choose
from pyros1.bridge.exchange.peer import Peer
from pyros1.bridge.exchange.streams import BufferedBytes, Delivery, Stream, make_stream
from pyros1.bridge.exchange.token_bucket import TokenBucket
from pyros1.bridge.exchange.topic_sender import TopicCounts
from pyros1.bridge.names import SharedName, is_topic_name
from pyros1.bridge.protocol.key_expressions import peer_key, topic_key
from pyros1.bridge.protocol.packets import (
    MAX_PUBLISHERS,
    Definition,
    Kind,
    LatchedList,
    MessageHead,
    OfferedTopic,
    Request,
    ResendRefusal,
    ResendRequest,
    Tail,
    encode_ask,
    encode_head,
    encode_resend_request,
)
from pyros1.bridge.rules.namespaces import LocalNamespaces, UsedTopics
from pyros1.bridge.rules.rules import Rules, Settings

MAX_TOPICS = 2_000
"""Maximum number of another site's topics that are published on this site's master, where each must be registered."""
_MAX_ASKED = 100
"""Maximum number of definitions to ask for at a time."""
_PAUSE = 10.0
"""Seconds that subscribers have to come back after a lost site has returned: nodes need some time to reconnect."""
UPDATE_RATE = 20_000.0
UPDATE_BURST = 60_000
"""Maximum number of topics updated because of other sites' lists and definitions, per second and in one burst. An
update covers all topics of all sites, and takes about 20 us per topic; changes that arrive between two updates are
handled together.
"""


class TopicReceiver:
    """The topics that a site receives.

    Args:
        rules: the site's rules.
        epoch: the site's epoch.
        peers: the other sites; shared with the caller, which updates it.

    Attributes:
        streams: for each topic that has been offered, whether it was latched, whether it was reliable, and its stream.
            Streams are kept for their site's whole run, so that nothing is delivered twice if a topic is offered again.
        buffered: for each site, how many bytes its streams hold back until gaps are filled.
    """

    def __init__(self, rules: Rules, epoch: int, peers: Mapping[str, Peer]) -> None:
        self._rules = rules
        self._epoch = epoch
        self._peers = peers
        self._namespaces = LocalNamespaces(rules)
        self._unwelcome: set[str] = set()  # sites with topics refused for a name conflict, which has been logged
        self._definitions = Definitions()
        self._outputs = Outputs()
        self._subscribed: frozenset[str] = frozenset()
        self._separate: set[str] = set()  # sites that send all messages to this one in separate packets
        self._incoming: dict[Feed, IncomingTopic] = {}
        self._refused: dict[Feed, tuple[str, str]] = {}  # feed -> its type, and why it is refused
        self._unusable: dict[Feed, str] = {}
        self._lacks_definitions = False
        self._is_outdated = False  # whether definitions have arrived, or sites have returned, since the last update
        self._updates = TokenBucket(UPDATE_RATE, UPDATE_BURST)
        self.streams: dict[Feed, tuple[bool, bool, Stream]] = {}
        self.buffered: dict[str, BufferedBytes] = {}

    # Current state ----------------------------------------------------------------------------------------------------

    def set_used_topics(self, used: UsedTopics) -> list[str]:
        """Record which topics this site's nodes use.

        Returns:
            The sites for which `note_offers` must be called again, since different topics may now be refused.
        """
        return self._namespaces.update(used, [peer.name for peer in self._peers.values() if peer.epoch])

    def may_update(self, now: float) -> bool:
        """Return whether to process other sites' new lists now; otherwise they wait."""
        return self._updates.take(now)

    def update(self, now: float) -> list[Action]:
        """Return the actions that result from what has been recorded."""
        self._updates.charge(len(self._incoming))
        return self.apply(now)

    def update_if_outdated(self, now: float) -> list[Action] | None:
        """Return the actions that result from new definitions and the return of sites; None if there are none, or if
        they must wait.
        """
        return self.update(now) if self._is_outdated and self.may_update(now) else None

    def note_offers(self, peer: str, offers: Iterable[OfferedTopic], now: float) -> list[Action]:
        """Record what another site offers, and return the first actions; call `update` or `apply` afterwards."""
        old = {feed: incoming for feed, incoming in self._incoming.items() if feed[0] == peer}
        for feed in old:
            del self._incoming[feed]
        self._refused = {feed: reason for feed, reason in self._refused.items() if feed[0] != peer}
        count, conflict = 0, ""
        for offered in offers:
            feed = (peer, offered.topic)
            rule = self._rules.incoming(offered.topic, peer)
            if isinstance(rule, str):
                self._refused[feed] = (offered.type, rule)
                continue
            local = self._rules.local_name(rule, offered.topic)
            problem = self._namespaces.problem(peer, rule)
            conflict = conflict or problem
            if not is_topic_name(local):
                problem = "its name here would be too long"
            if count >= MAX_TOPICS:
                problem = "the site offers too many topics"
            if problem:
                self._refused[feed] = (offered.type, problem)
                continue
            count += 1
            settings = rule.settings(local, offered.type)
            if offered.latched and not settings.may_latch:
                # Missed messages would not be resent either, since the other site keeps only latched ones.
                offered = offered._replace(latched=False, reliable=False)  # noqa: PLW2901
            before = old.get(feed)
            if before is not None and before.offered._replace(publishers=offered.publishers) == offered:
                self._incoming[feed] = before
                before.offered = offered
            else:
                nodes = self._rules.prefix(offered.topic.site)
                prefixer = Prefixer(settings.prefix_frames, settings.keep_frames, nodes)
                stream = self._stream(feed, offered, settings)
                self._incoming[feed] = IncomingTopic(offered, settings, stream, prefixer)
        actions: list[Action] = []
        if not conflict:
            self._unwelcome.discard(peer)
        elif self._namespaces.is_known and peer not in self._unwelcome:
            self._unwelcome.add(peer)
            actions.append(Log(f"topics of site {peer} are not taken: {conflict}", is_warning=True))
        actions += self._replace(old, now)
        self._forget_streams(peer)
        return actions

    def _replace(self, old: Mapping[Feed, IncomingTopic], now: float) -> list[Action]:
        actions: list[Action] = []
        for feed, before in old.items():
            incoming = self._incoming.get(feed)
            if incoming is None and before.is_wanted:
                actions += self._stop(feed, before, now)
            elif incoming is None:
                before.stream.restart(now)
            elif incoming is not None and incoming is not before:
                actions += self._continue(feed, before, incoming, now)
        return actions

    def _stream(self, feed: Feed, offered: OfferedTopic, settings: Settings) -> Stream:
        latched, reliable, stream = self.streams.get(feed, (None, None, None))
        if stream is None or (latched, reliable) != (offered.latched, offered.reliable):
            floor = stream.highest if stream else 0
            buffered = self.buffered.setdefault(feed[0], BufferedBytes())
            stream = make_stream(offered.latched, offered.reliable, settings.age, floor, buffered)
            self.streams[feed] = (offered.latched, offered.reliable, stream)
        return stream

    def _continue(self, feed: Feed, before: IncomingTopic, incoming: IncomingTopic, now: float) -> list[Action]:
        """Continue receiving a topic whose offer has changed; its latched messages are requested again."""
        incoming.flow = before.flow
        incoming.is_wanted, incoming.wanted_since = before.is_wanted, before.wanted_since
        incoming.is_paused, incoming.paused_until = before.is_paused, before.paused_until
        if not (before.is_wanted or before.is_paused):
            return []
        before.stream.restart(now)  # nothing is held back from now on
        return self._outputs.forget_feed(incoming.settings.local, feed)

    def _forget_streams(self, peer: str) -> None:
        """Forget the oldest streams of a site that offers more and more topics."""
        old = [feed for feed in self.streams if feed[0] == peer and feed not in self._incoming]
        for feed in old[: max(0, len(old) - MAX_TOPICS)]:
            del self.streams[feed]

    def drop_peer(self, peer: str, now: float) -> list[Action]:
        """Forget everything about another site, since it is gone or has restarted, and return the first actions; call
        `apply` afterwards.
        """
        actions = self.note_offers(peer, (), now)
        for feed in [feed for feed in self.streams if feed[0] == peer]:
            del self.streams[feed]
        self.buffered.pop(peer, None)
        self._definitions.forget(peer)
        self._separate.discard(peer)
        return actions

    def set_separate(self, peer: str, on: bool, changes: TokenBucket, now: float) -> list[Action]:
        """Record whether another site sends all messages in separate packets for this site: receiving the common
        packets too would waste bandwidth. `changes` limits how often this may change; heartbeats repeat the last state.
        """
        if on is (peer in self._separate) or not changes.take(now):
            return []
        (self._separate.add if on else self._separate.discard)(peer)
        wanted = [feed for feed, incoming in self._incoming.items() if feed[0] == peer and incoming.is_wanted]
        return [Listen(peer, topic_key(topic), not on) for _, topic in wanted]

    def set_subscribed(self, subscribed: Iterable[str], now: float) -> list[Action]:
        """Record which topics this site's nodes subscribe to, and return the resulting actions."""
        self._subscribed = frozenset(subscribed)
        return self.apply(now)

    def on_definition(self, peer: str, definition: Definition) -> None:
        """Record a definition; call `update_if_outdated` afterwards."""
        is_offered = any(
            (incoming.offered.type, incoming.offered.md5sum) == (definition.type, definition.md5sum)
            for incoming in self._incoming.values()
        )
        if is_offered and self._definitions.add(peer, definition):
            self._is_outdated = True

    def apply(self, now: float) -> list[Action]:
        """Update what is published and requested to match sites, offers, definitions and subscribers."""
        self._is_outdated = False
        candidates = self._candidates()
        outputs, self._unusable = choose(candidates)
        self._unusable.update(self._learn_definitions())
        self._lacks_definitions = any(
            self._definitions.is_missing(peer, incoming.offered.type, incoming.offered.md5sum)
            for (peer, _), incoming in self._incoming.items()
        )
        actions = self._ask(now)
        changed = self._outputs.changed(outputs)
        for feed, incoming in self._incoming.items():
            if incoming.is_wanted and not self._present(feed[0]):
                actions += self._pause(feed, incoming)
            elif incoming.is_wanted and incoming.settings.local in changed:
                actions += self._stop(feed, incoming, now)  # if wanted again at once, latched messages are resent
        actions += self._outputs.update(outputs, self._origins(outputs))
        for feed, incoming in self._incoming.items():
            local = incoming.settings.local
            wanted = local in self._outputs and local in self._subscribed and feed not in self._unusable
            wanted = wanted and self._present(feed[0])
            if wanted and not incoming.is_wanted:
                if not incoming.is_paused:
                    incoming.wanted_since = now
                if not incoming.is_paused or incoming.offered.latched:
                    incoming.stream.restart(now)
                incoming.is_wanted, incoming.is_paused, incoming.paused_until = True, False, float("inf")
                if feed[0] not in self._separate:
                    actions.append(Listen(feed[0], topic_key(feed[1]), True))
            elif incoming.is_wanted and not wanted:
                actions += self._stop(feed, incoming, now)
        return actions

    def _origins(self, outputs: Iterable[str]) -> dict[str, tuple[str, ...]]:
        """Return the original publishers of each topic published here, as far as their sites name them."""
        found: dict[str, list[str]] = {local: [] for local in outputs}
        for (peer, _), incoming in self._incoming.items():
            names = found.get(incoming.settings.local)
            if names is not None and self._present(peer):
                names += [f"{peer}:{publisher}" for publisher in incoming.offered.publishers]
        return {local: tuple(sorted(names)[:MAX_PUBLISHERS]) for local, names in found.items()}

    def _present(self, peer: str) -> bool:
        return self._peers[peer].is_present

    def _candidates(self) -> list[Candidate]:
        """Return the topics that could be published here; those already wanted first, so that they stay."""
        candidates = []
        for feed in sorted(self._incoming, key=lambda feed: (not self._incoming[feed].is_wanted, feed)):
            if not self._present(feed[0]):
                continue
            incoming = self._incoming[feed]
            offered = incoming.offered
            text = self._definitions.text(offered.type, offered.md5sum)
            output = None if text is None else Output(offered.type, offered.md5sum, text, offered.latched)
            candidates.append(Candidate(incoming.settings.local, feed, output))
        return candidates

    def _learn_definitions(self) -> dict[Feed, str]:
        """Prepare to add prefixes to messages; return the topics whose messages cannot get them, and why."""
        problems = {}
        for feed, incoming in self._incoming.items():
            text = self._definitions.text(incoming.offered.type, incoming.offered.md5sum)
            if text is not None and (problem := incoming.prefixer.learn(incoming.offered.type, text)):
                problems[feed] = problem
        return problems

    def _ask(self, now: float) -> list[Action]:
        """Return requests for the missing definitions."""
        if not self._lacks_definitions:
            return []
        missing: dict[str, list[str]] = {}
        for (peer, _), incoming in self._incoming.items():
            offered = incoming.offered
            if self._present(peer) and self._definitions.is_missing(peer, offered.type, offered.md5sum):
                missing.setdefault(peer, []).append(offered.md5sum)
        actions: list[Action] = []
        for peer, md5sums in missing.items():
            if due := self._definitions.take_requests(peer, md5sums, now, _MAX_ASKED):
                actions.append(Send(peer_key(peer), self._head(Kind.ASK, peer), encode_ask(due)))
        return actions

    def _stop(self, feed: Feed, incoming: IncomingTopic, now: float) -> list[Action]:
        """Stop requesting a topic. Its latched messages are forgotten, since changes to them would now go unnoticed."""
        incoming.stream.restart(now)  # nothing is held back from now on
        return self._ignore(feed, incoming)

    def _pause(self, feed: Feed, incoming: IncomingTopic) -> list[Action]:
        """Pause the request for a topic while its site is lost; missed messages are requested afterwards."""
        incoming.is_paused, incoming.paused_until = True, float("inf")
        return self._ignore(feed, incoming)

    def _ignore(self, feed: Feed, incoming: IncomingTopic) -> list[Action]:
        incoming.is_wanted = False
        peer, topic = feed
        return [Listen(peer, topic_key(topic), False), *self._outputs.forget_feed(incoming.settings.local, feed)]

    def requests(self) -> dict[str, list[Request]]:
        """Return what this site wants from each of the other sites."""
        found: dict[str, list[Request]] = {}
        for (peer, topic), incoming in self._incoming.items():
            if incoming.is_wanted or incoming.is_paused:
                found.setdefault(peer, []).append(Request(topic, incoming.settings.rate or 0.0))
        return found

    def on_return(self, peer: str, now: float) -> None:
        """Record that a lost site has returned; call `update_if_outdated` afterwards."""
        for feed, incoming in self._incoming.items():
            if feed[0] == peer and incoming.is_paused:
                incoming.paused_until = now + _PAUSE
        self._is_outdated = True

    def end_pauses(self, now: float) -> bool:
        """End the pauses that are over; return whether any topic is no longer requested, since nobody resubscribed."""
        ended = [incoming for incoming in self._incoming.values() if now >= incoming.paused_until]
        for incoming in ended:
            incoming.is_paused, incoming.paused_until = False, float("inf")
            incoming.stream.restart(now)  # nothing is held back from now on
        return bool(ended)

    # Messages ---------------------------------------------------------------------------------------------------------

    def on_message(self, peer: str, topic: SharedName, head: MessageHead, body: bytes, now: float) -> list[Action]:
        """Return the actions for a message from another site's current run."""
        incoming = self._incoming.get((peer, topic))
        if incoming is None or not incoming.is_wanted:
            return []
        if head.md5sum != incoming.offered.md5sum:
            incoming.flow.drop(DropReason.TYPE)
            return []
        deliveries = incoming.stream.accept(head, body, now)
        return deliver((peer, topic), incoming, deliveries, self._peers[peer].clock, self._outputs, now)

    def _deliver(self, feed: Feed, incoming: IncomingTopic, deliveries: Iterable[Delivery], now: float) -> list[Action]:
        return deliver(feed, incoming, deliveries, self._peers[feed[0]].clock, self._outputs, now)

    def on_tails(self, peer: str, tails: Mapping[SharedName, Tail], now: float) -> list[Action]:
        """Record where another site's topics end, and return the resulting actions."""
        actions: list[Action] = []
        for topic, tail in tails.items():
            incoming = self._incoming.get((peer, topic))
            if incoming is not None and incoming.is_wanted:
                actions += self._deliver((peer, topic), incoming, incoming.stream.on_tail(tail, now), now)
                actions += self._tick_topic((peer, topic), incoming, now)
        return actions

    def on_latched_list(self, peer: str, latched_list: LatchedList, now: float) -> list[Action]:
        """Record which latched messages another site holds, and return the resulting actions."""
        incoming = self._incoming.get((peer, latched_list.topic))
        if incoming is None or not incoming.is_wanted:
            return []
        return self._deliver((peer, latched_list.topic), incoming, incoming.stream.on_latched_list(latched_list), now)

    def on_gone(self, peer: str, gone: ResendRefusal, now: float) -> list[Action]:
        """Record that another site cannot resend some messages, and return the resulting actions."""
        incoming = self._incoming.get((peer, gone.topic))
        if incoming is None or not incoming.is_wanted:
            return []
        return self._deliver((peer, gone.topic), incoming, incoming.stream.on_gone(gone, now), now)

    def tick(self, now: float) -> list[Action]:
        """Return the actions that follow because time has passed."""
        actions = self._ask(now)
        for feed, incoming in self._incoming.items():
            if incoming.is_wanted and self._present(feed[0]):
                actions += self._tick_topic(feed, incoming, now)
        return actions

    def _tick_topic(self, feed: Feed, incoming: IncomingTopic, now: float) -> list[Action]:
        peer, topic = feed
        actions = self._deliver(feed, incoming, incoming.stream.tick(now), now)
        if numbers := incoming.stream.missed(now):
            body = encode_resend_request(ResendRequest(topic, *numbers))
            actions.append(Send(peer_key(peer), self._head(Kind.RESEND_REQUEST, peer), body))
        return actions

    def _head(self, kind: Kind, peer: str) -> bytes:
        return encode_head(kind, self._epoch, self._peers[peer].epoch)

    def _state(self, feed: Feed, incoming: IncomingTopic) -> str:
        if not self._present(feed[0]):
            return "site lost"
        return self._unusable.get(feed) or ("subscribed" if incoming.is_wanted else "no subscribers here")

    def flows(self) -> list[tuple[Feed, TopicCounts]]:
        """Return the flows of the topics that are accepted."""
        return [(feed, incoming.flow) for feed, incoming in self._incoming.items()]

    def topics(self) -> list[ReceivedTopic]:
        """Return the topics of other sites, for the status."""
        found = [
            ReceivedTopic(
                peer,
                topic,
                incoming.offered.type,
                incoming.settings.local,
                self._state((peer, topic), incoming),
                incoming.flow,
                incoming.stream.drops,
                incoming.offered.publishers,
            )
            for (peer, topic), incoming in self._incoming.items()
        ]
        for (peer, topic), (type_name, reason) in self._refused.items():
            found.append(ReceivedTopic(peer, topic, type_name, "", reason, TopicCounts(), {}))
        return found
