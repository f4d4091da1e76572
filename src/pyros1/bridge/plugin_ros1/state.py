"""The state of a bridge in the dialect of zenoh-plugin-ros1: values in, packets and messages out. No I/O, no clock."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from zlib import crc32

from pyros1.bridge.exchange.actions import Publish, Send, Source
from pyros1.bridge.exchange.outgoing import DropReason, ReceivedMessage
from pyros1.bridge.exchange.token_bucket import TokenBucket
from pyros1.bridge.exchange.topic_sender import LocalTopic, TopicCounts
from pyros1.bridge.names import SharedName
from pyros1.bridge.plugin_ros1.beacons import PERIOD, HeardBeacons, OwnBeacons
from pyros1.bridge.plugin_ros1.keys import Resource, data_key
from pyros1.bridge.plugin_ros1.plan import LocalService, Plan, TakenResource, make_plan
from pyros1.bridge.plugin_ros1.rules import PluginRules
from pyros1.bridge.rules.rules import Priority

_MAX_PUBLISHERS = 10_000
"""Maximum number of publishers with separate rate limits; further ones share one limit per topic."""
_PLAN_RATE = 4.0
_PLAN_BURST = 20
"""Maximum number of plans made because beacons come or go, per second and in one burst: with thousands of topics,
making one takes 50 ms.
"""
UNKNOWN = "messages of topics that are not taken"
_NO_SOURCE = Source("", SharedName("", ""), 0)
"""The source of all messages: nothing is latched, so sources do not matter."""


class PluginState:
    """The state of a bridge.

    Args:
        rules: its rules.
        random: returns a random number from 0 to 1, for the turns of beacons.

    Attributes:
        plan: what the bridge does now; replaced by a new object on each change.
        heard: the topics and services that other bridges announce.
        wanted: the sent topics that have receivers elsewhere.
        subscribed: the topics published here that nodes subscribe to.
        sent: counts of each sent topic's messages.
        taken: counts of the messages published here, by local topic.
        ignored: reason -> how many messages from elsewhere were ignored for it.
    """

    def __init__(self, rules: PluginRules, random: Callable[[], float]) -> None:
        self.plan = Plan()
        self._plans = TokenBucket(_PLAN_RATE, _PLAN_BURST)
        self._is_outdated = False  # whether the plan is outdated
        self.heard = HeardBeacons(lambda resource: not isinstance(rules.incoming(resource), str))
        self.wanted: frozenset[Resource] = frozenset()
        self.subscribed: frozenset[str] = frozenset()
        self.sent: dict[Resource, TopicCounts] = {}
        self.taken: dict[str, TopicCounts] = {}
        self.ignored: dict[str, int] = {}
        self.rules = rules
        self._own = OwnBeacons(random)
        self._topics: Sequence[LocalTopic] = ()
        self._services: Sequence[LocalService] = ()
        self._local_by_key: dict[str, tuple[str, TakenResource]] = {}
        self._sent_by_local: dict[str, list[Resource]] = {}
        self._due: dict[tuple[str, str], float] = {}

    def key(self, resource: Resource) -> str:
        """Return the key of a topic's messages or a service's calls."""
        return data_key(resource, self.rules.old_keys)

    # Current state ----------------------------------------------------------------------------------------------------

    def set_local(self, topics: Sequence[LocalTopic], services: Sequence[LocalService], now: float) -> None:
        """Record the topics and services of this master's nodes, except bridges."""
        if (topics, services) != (self._topics, self._services):
            self._topics, self._services = topics, services
            self._make_plan(now)

    def set_subscribed(self, subscribed: Collection[str], now: float) -> None:
        """Record which of this bridge's topics have subscribers."""
        self.subscribed = frozenset(subscribed)
        self._own.set_announced(self.plan.announced(self.subscribed), now)

    def on_beacon(self, key: str, now: float) -> None:
        """Handle another bridge's beacon."""
        self._own.on_beacon(key)
        if self.heard.on_beacon(key, now):
            self._is_outdated = True
            self._renew_plan(now)

    def tick(self, now: float) -> list[Send]:
        """Forget what is no longer announced, and return the beacons to send.

        The plugin sends beacons with the lowest priority. Here they get a high one: they are few, and if they did not
        get through, what they announce would be lost just when traffic is heavy.
        """
        self._is_outdated |= self.heard.expire(now)
        self._renew_plan(now)
        return [Send(key, b"", b"", Priority.HIGH, 0, expires=now + PERIOD) for key in self._own.tick(now)]

    def _renew_plan(self, now: float) -> None:
        if self._is_outdated and self._plans.take(now):
            self._make_plan(now)

    def _make_plan(self, now: float) -> None:
        self._is_outdated = False
        self.plan = plan = make_plan(self.rules, self._topics, self._services, self.heard.used)
        self._local_by_key = {
            self.key(source): (local, taken) for local, taken in plan.takes.items() for source in taken.sources
        }
        self._sent_by_local = {}
        for resource, sent in plan.sends.items():
            self._sent_by_local.setdefault(sent.local.name, []).append(resource)
        self.sent = {resource: self.sent.get(resource, TopicCounts()) for resource in plan.sends}
        self.taken = {local: self.taken.get(local, TopicCounts()) for local in plan.takes}
        self._due = {
            key: due for key, due in self._due.items() if key[0] in self.taken or key[0] in self._sent_by_local
        }
        self._own.set_announced(plan.announced(self.subscribed), now)

    # Messages ---------------------------------------------------------------------------------------------------------

    def on_message(self, local: str, message: ReceivedMessage, is_bridged: bool, now: float) -> list[Send]:
        """Return the packets to send for a message on a topic of this master.

        Args:
            local: the topic.
            message: the message.
            is_bridged: whether a bridge has published it.
            now: the current time in seconds.
        """
        packets = []
        for resource in self._sent_by_local.get(local, ()):
            flow, settings = self.sent[resource], self.plan.sends[resource].settings
            if is_bridged:
                flow.drop(DropReason.BRIDGED)
            elif message.md5sum != resource.md5sum:
                flow.drop(DropReason.TYPE)
            elif len(message.body) > settings.max_size:
                flow.drop(DropReason.SIZE)
            elif not self._is_due(local, f"{message.publisher} {resource.namespace}", settings.rate, now):
                flow.drop(DropReason.RATE)
            elif resource in self.wanted:
                flow.count(len(message.body))
                packets.append(
                    Send(
                        self.key(resource),
                        b"",
                        message.body,
                        settings.priority,
                        None if settings.reliable else crc32(message.publisher.encode()),
                        may_drop=True,
                        expires=now + settings.age,
                    )
                )
        return packets

    def on_sample(self, key: str, body: bytes, now: float) -> Publish | None:
        """Return the message to publish on this master for one from elsewhere; None if that is ignored.

        Args:
            key: its key.
            body: the encoded message.
            now: the current time in seconds.
        """
        found = self._local_by_key.get(key)
        if found is None:
            self.ignored[UNKNOWN] = self.ignored.get(UNKNOWN, 0) + 1
            return None
        local, taken = found
        flow = self.taken[local]
        if len(body) > taken.settings.max_size:
            flow.drop(DropReason.SIZE)
        elif not self._is_due(local, key, taken.settings.rate, now):
            flow.drop(DropReason.RATE)
        else:
            flow.count(len(body))
            return Publish(local, _NO_SOURCE, body, False)
        return None

    def _is_due(self, local: str, publisher: str, rate: float | None, now: float) -> bool:
        """Return whether the rate limit lets a publisher's message pass; if so, count it."""
        if rate is None:
            return True
        key, period = (local, publisher), 1.0 / rate
        if key not in self._due and len(self._due) >= _MAX_PUBLISHERS:
            key = (local, "")
        due = self._due.get(key, now)
        # Accept a message that is a little early: publishers are not exact.
        if now < due - 0.1 * period:
            return False
        self._due[key] = max(due, now - period) + period
        return True
