"""Plans which topics a bridge to ROS 2 exchanges, given the topics of both sides. No I/O.

Each side sees the other side's topics, but messages are exchanged only if a node subscribes. The plan is
recomputed after each change. The runner then starts what is missing, and stops what is not in the plan.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple, Protocol

from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.names import Pattern
from pyros1.bridge.rules.rules import Priority, Rule
from pyros1.ground.errors import Error
from pyros1.ros2.bridge.rules import LOG, Ros2Rules
from pyros1.ros2.pairs.type_pairs import TypePair
from pyros1.ros2.zenoh.names import DataKey, data_key, is_full_name
from pyros1.ros2.zenoh.qos import Qos
from pyros1.ros2.zenoh.tokens import Entity

QUEUE = 10
"""The history depth that our publishers and subscribers announce."""
LATCHED_DEPTH = 1
"""The history depth that our publishers of a latched topic announce: there is one for each ROS 1 publisher, which keeps
its last message.
"""


class Types(Protocol):
    """Finds pairs of ROS 1 and ROS 2 types, see `pyros1.ros2.pairs.type_pairs.TypePairs`."""

    def for_ros1(self, type: str, md5sum: str, definition: str, hash: str | None = None) -> TypePair:
        """Return the pair of types for a ROS 1 type."""
        ...

    def for_ros2(self, type: str, hash: str, local: LocalTopic | None = None) -> TypePair:
        """Return the pair of types for a ROS 2 type."""
        ...


class AnnouncedTopic(NamedTuple):
    """A ROS 1 topic that ROS 2 sees.

    Attributes:
        local: the topic.
        pair: its type on both sides.
        qos: how it is published.
        is_subscribed: whether a ROS 2 node subscribes.
        priority: the priority of its messages.
    """

    local: LocalTopic
    pair: TypePair
    qos: Qos
    is_subscribed: bool
    priority: Priority

    def route(self, key: DataKey, publisher: str) -> str:
        """Return the identifier of the ROS 2 publisher that sends a ROS 1 publisher's messages."""
        return f"{data_key(key)} {publisher}" if self.qos.transient_local else data_key(key)

    def routes(self, key: DataKey) -> list[str]:
        """Return all values that `route` may return."""
        return [*dict.fromkeys(self.route(key, publisher) for publisher in self.local.publishers)]


@dataclass
class TakenTopic:
    """A ROS 2 topic that ROS 1 sees.

    Attributes:
        pair: its type on both sides.
        keys: the keys to subscribe to, each with its type on both sides and how to subscribe.
        latched: whether late subscribers get messages that were published before.
        publishers: the names of the nodes that publish it.
    """

    pair: TypePair
    keys: dict[DataKey, tuple[TypePair, Qos]] = field(default_factory=dict)
    latched: bool = False
    publishers: list[str] = field(default_factory=list)


@dataclass
class Plan:
    """The topics that a bridge exchanges, and how.

    Attributes:
        announces: the topics that ROS 2 sees, by key.
        takes: the topics that ROS 1 sees, by name.
        problems: topic -> why it is not exchanged, or not with every node.
    """

    announces: dict[DataKey, AnnouncedTopic] = field(default_factory=dict)
    takes: dict[str, TakenTopic] = field(default_factory=dict)
    problems: dict[str, str] = field(default_factory=dict)

    def keys_to_subscribe(self, subscribed: Collection[str]) -> dict[DataKey, Qos]:
        """Return the keys of ROS 2 to subscribe to.

        Args:
            subscribed: the topics that the bridge publishes in ROS 1 and that nodes there subscribe to.
        """
        return {
            key: qos
            for topic, taken in self.takes.items()
            if topic in subscribed
            for key, (_, qos) in taken.keys.items()
        }

    def add_duplicates(self, publishers: Mapping[str, Collection[str]], bridges: Collection[str]) -> None:
        """Report the topics that other bridges publish in ROS 1, too, as problems. This causes no loops, since no
        bridge forwards what another one publishes, but the same message may arrive twice. The log topic is not
        reported: each bridge publishes its own log.

        Args:
            publishers: the nodes in ROS 1 that publish each topic.
            bridges: the nodes that are other bridges.
        """
        for topic in (self.takes.keys() & publishers.keys()) - {LOG}:
            if topic not in self.problems and (others := sorted({*publishers[topic]} & {*bridges})):
                self.problems[topic] = f"{others[0]} also publishes it in ROS 1, so its messages may arrive twice"

    def publishers(self) -> dict[str, tuple[DataKey, Qos, Priority]]:
        """Return the publishers in ROS 2, by their identifiers: key, QoS and priority."""
        return {
            route: (key, announced.qos, announced.priority)
            for key, announced in self.announces.items()
            for route in announced.routes(key)
        }

    def subscribed_topics(self) -> dict[str, list[tuple[DataKey, AnnouncedTopic]]]:
        """Return the ROS 1 topics that ROS 2 nodes subscribe to, each with the keys to send it with."""
        found: dict[str, list[tuple[DataKey, AnnouncedTopic]]] = {}
        for key, announced in self.announces.items():
            if announced.is_subscribed:
                found.setdefault(announced.local.name, []).append((key, announced))
        return found


def make_plan(
    domain: int,
    rules: Ros2Rules,
    topics: Iterable[LocalTopic],
    publishers: Mapping[str, Collection[Entity]],
    subscribers: Mapping[str, Collection[Entity]],
    types: Types,
) -> Plan:
    """Return the plan for the current state of both sides.

    Args:
        domain: the ROS domain.
        rules: what may be exchanged.
        topics: what nodes other than bridges publish in ROS 1.
        publishers, subscribers: ROS 2's publishers and subscribers by topic, without bridges of the same master.
        types: knows the types of both sides.
    """
    plan = Plan()
    by_name = {topic.name: topic for topic in topics}
    for topic in by_name.values():
        if rules.sends(topic.name):
            _announce(plan, domain, topic, subscribers.get(topic.name, ()), types)
    for name in sorted(publishers):
        if rules.takes(name):
            _take(plan, domain, name, publishers[name], by_name.get(name), types)
    return plan


def _announce(plan: Plan, domain: int, topic: LocalTopic, subscribers: Collection[Entity], types: Types) -> None:
    if not is_full_name(topic.name):
        plan.problems[topic.name] = "ROS 2 does not allow such a name"
        return
    try:
        default = types.for_ros1(topic.type, topic.md5sum, topic.definition)
    except Error as error:
        plan.problems[topic.name] = str(error)
        return
    pairs = {default.hash: default}
    wanted = set()
    for subscriber in subscribers:
        if subscriber.type != default.ros2:
            plan.problems[topic.name] = f"{subscriber.full_node_name} expects {subscriber.type}, not {default.ros2}"
            continue
        try:
            if subscriber.hash not in pairs:
                pairs[subscriber.hash] = types.for_ros1(topic.type, topic.md5sum, topic.definition, subscriber.hash)
            wanted.add(subscriber.hash)
        except Error as error:
            plan.problems[topic.name] = f"{subscriber.full_node_name}: {error}"
    qos = Qos(True, topic.latched, LATCHED_DEPTH if topic.latched else QUEUE)
    priority = Rule(Pattern(topic.name)).settings(topic.name, topic.type).priority
    for type_hash, pair in pairs.items():
        if type_hash in wanted or not wanted:
            key = DataKey(domain, topic.name, pair.ros2, type_hash)
            plan.announces[key] = AnnouncedTopic(topic, pair, qos, type_hash in wanted, priority)


def _take(
    plan: Plan, domain: int, name: str, publishers: Collection[Entity], local: LocalTopic | None, types: Types
) -> None:
    for publisher in publishers:
        try:
            pair = types.for_ros2(publisher.type, publisher.hash, local)
        except Error as error:
            plan.problems[name] = str(error)
            continue
        if local is not None and local.md5sum != pair.md5sum:
            plan.problems[name] = (
                f"{local.publishers[0]} publishes it as {local.type}, "
                f"{publisher.full_node_name} of ROS 2 as {pair.ros2}"
            )
            continue
        taken = plan.takes.setdefault(name, TakenTopic(pair))
        if taken.pair.md5sum != pair.md5sum:
            plan.problems[name] = f"it has two types in ROS 2: {taken.pair.ros2} and {pair.ros2}"
            continue
        offered = publisher.qos
        key = DataKey(domain, name, pair.ros2, publisher.hash)
        before = taken.keys.get(key)
        # A subscriber that requests more than the publisher's QoS offers gets no messages.
        reliable = offered.reliable and (before is None or before[1].reliable)
        # Late subscribers in ROS 1 do not expect the log lines from before the bridge started.
        is_latched = offered.transient_local and name != LOG
        latched = is_latched and (before is None or before[1].transient_local)
        taken.keys[key] = (pair, Qos(reliable, latched, max(QUEUE, min(offered.depth, 1000)) if latched else QUEUE))
        taken.latched = taken.latched or is_latched
        if publisher.full_node_name not in taken.publishers:
            taken.publishers.append(publisher.full_node_name)
