"""Sites with masters that are only tables, on a network in memory, and what must hold whatever happens to them.

Each message's body says where it came from and when, so what is delivered can be judged without looking into a site.
"""

from __future__ import annotations

from collections.abc import Iterable
from random import Random
from typing import Any, NamedTuple

from pyros1.bridge.conversions.conversion import Conversion, MessageType
from pyros1.bridge.exchange.actions import (
    Action,
    Advertise,
    CallService,
    Forget,
    Listen,
    Log,
    Provide,
    Publish,
    RepresentNode,
    RestartConversion,
    Return,
    Send,
    SetOrigins,
    StopProviding,
    Subscribe,
    Withdraw,
)
from pyros1.bridge.exchange.outgoing import ReceivedMessage
from pyros1.bridge.exchange.peer import State
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.exchange.topic_sender import LocalTopic
from pyros1.bridge.protocol.packets import MAX_PUBLISHERS
from pyros1.bridge.rules.namespaces import UsedTopics
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rules
from pyros1.bridge.transport.memory_link import MemoryLink, MemoryNetwork, NetworkConditions
from pyros1.msgs import load_message

from .simulated_services import SimulatedServices, check_services, check_that_calls_succeed

TICK = 0.1
POLL = 0.5
AGE = 2.0
"""Maximum age in seconds of the messages of all topics that are not latched."""
STRING: Any = load_message("std_msgs/String")
CALM = 65.0
"""Seconds without trouble after which everything must be right, and all calls must have ended."""
TOPICS = {"/odom": "newest", "/cloud": "newest", "/goal": "reliable", "/map": "latched", "/tf_static": "latched"}
CONVERSIONS = {"/cloud": Conversion("every", 2.0)}
"""The topics that are sent converted, although the messages stay as they are."""


class Body(NamedTuple):
    """What a message's bytes say."""

    site: str
    topic: str
    publisher: str
    number: int
    time: float

    def encode(self) -> bytes:
        """Return the bytes."""
        return "|".join(map(str, self)).encode()


def decode(body: bytes) -> Body:
    """Return what a message's bytes say."""
    site, topic, publisher, number, time = body.decode().split("|")
    return Body(site, topic, publisher, int(number), float(time))


def all_to_all(name: str) -> Rules:
    """Return rules by which a site sends and takes everything."""
    reliable = "{topic: /goal, delivery: reliable, age: 2}"
    serve = "serve: ['/**']\ncall: ['*:**']\n"
    converted = "{topic: /cloud, convert: every, every: 2, age: 2}"
    text = f"send: [{reliable}, {converted}, {{topic: /odom, age: 2}}, '/**']\n"
    text += "take: [{topic: '*:/goal', age: 2}, '*:**', '/**']\n"
    return parse_config(text + serve, "rules.yaml", name).rules


class Publisher:
    """A node that publishes a topic."""

    def __init__(self, name: str, latched: bool) -> None:
        self.name = name
        self.latched = latched
        self.number = 0
        self.last: bytes | None = None


class SimulatedSite:
    """A site with its master and its nodes.

    Attributes:
        publishers: topic -> publishers.
        subscribers: the topics to which nodes subscribe.
        subscribed: the topics to which the bridge subscribes.
        kept: topic -> source -> the latched message that later subscribers get from the bridge.
        origins: topic -> the original publishers, as the bridge names them.
        represented: the nodes of other sites that programs here can watch.
        delivered: what the bridge published: the run of the site, the count of subscriptions then, and the message.
        services: the services of its nodes, and their calls.
    """

    def __init__(self, network: MemoryNetwork, name: str, rules: Rules, random: Random) -> None:
        self.name = name
        self.network = network
        self.publishers: dict[str, dict[str, Publisher]] = {}
        self.subscribers: set[str] = set()
        self.subscribed: set[str] = set()
        self.kept: dict[str, dict[tuple[str, int], bytes]] = {}
        self.latched: dict[str, bool] = {}
        self.represented: set[str] = set()
        self.delivered: list[tuple[int, int, Body]] = []
        self.origins: dict[str, tuple[str, ...]] = {}
        self.logged: list[str] = []
        self.run = 0
        self._rules = rules
        self.random = random
        self.services = SimulatedServices(self)
        self._clock_start = random.uniform(0, 1e6)
        self._clock_rate = 1 + random.uniform(-4e-5, 4e-5)
        self._periods: dict[str, int] = {}
        self._node_count = 0
        self.start()

    @property
    def now(self) -> float:
        """The time by the site's own clock."""
        return self._clock_start + self.network.now * self._clock_rate

    # Running ----------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Start the bridge, or start it again after it was killed."""
        self.run += 1
        self.subscribed, self.kept, self.latched, self.represented = set(), {}, {}, set()
        self.services.start()
        self.site = Site(self._rules, self.random.getrandbits(63) + 1, self.now)
        run = self.run
        self.link: MemoryLink = self.network.connect(
            self.name, lambda key, head, body: self.act(self.site.on_packet(key, head, body, self.now))
        )
        self.act(self.site.start())
        self._tick(run)
        self._poll(run)

    def _tick(self, run: int) -> None:
        if run == self.run:
            self.act(self.site.tick(self.now))
            self._check_lost()
            self.network.at(self.network.now + TICK, lambda: self._tick(run))

    def _check_lost(self) -> None:
        """While a site is lost, nothing of it is published here."""
        for name, state, *_ in self.site.sites():
            if state is State.LOST:
                left = [each for each in (*self.kept, *self.represented) if each.startswith(f"/{name}/")]
                assert not left, f"{self.name} has lost {name}, but there is {left}"

    def _poll(self, run: int) -> None:
        if run == self.run:
            self.look()
            self.network.at(self.network.now + POLL, lambda: self._poll(run))

    def look(self) -> None:
        """Let the bridge look at its master."""
        topics = [
            LocalTopic(
                topic,
                STRING._type,
                STRING._md5sum,
                STRING._full_text,
                any(publisher.latched for publisher in publishers.values()),
                tuple(publishers),
                tuple(
                    (conversion, MessageType(STRING._type, STRING._md5sum, STRING._full_text))
                    for conversion in CONVERSIONS.values()
                ),
            )
            for topic, publishers in self.publishers.items()
            if publishers
        ]
        used = UsedTopics(frozenset(topic.name for topic in topics), frozenset())
        self.act(self.site.set_used_topics(used, self.now))
        self.act(self.site.set_topics(topics, self.now, self.now))
        self.services.look()
        self.act(self.site.set_responding((name for names in self.publishers.values() for name in names), self.now))
        self.act(self.site.set_subscribed(self.subscribers & self.kept.keys(), self.now))

    def act(self, actions: Iterable[Action]) -> None:
        """Do what the site's machine asks for."""
        for action in actions:
            match action:
                case Send():
                    self.link.send(action)
                case Listen():
                    self.link.listen(*action)
                case Subscribe(local, on, conversion):
                    assert conversion == CONVERSIONS.get(local)
                    (self.subscribed.add if on else self.subscribed.discard)(local)
                    if on:
                        self._connect(local)
                case Advertise() | SetOrigins():
                    self._advertise(action)
                case Withdraw(local):
                    del self.kept[local], self.latched[local]
                case Publish():
                    self._deliver(action)
                case RestartConversion(local, conversion):
                    assert CONVERSIONS[local] == conversion
                case Forget(local, source):
                    del self.kept[local][source]
                case Provide() | StopProviding() | CallService() | Return():
                    self.services.act(action)
                case _:
                    self._represent_or_log(action)

    def _represent_or_log(self, action: Action) -> None:
        if isinstance(action, RepresentNode):
            local = action.local
            assert (local in self.represented) != bool(action.node), f"{local} is represented twice, or not at all"
            (self.represented.add if action.node else self.represented.remove)(local)
        else:
            assert isinstance(action, Log), f"nobody has sent a probe, but there is {action}"
            self.logged.append(action.text)

    def _advertise(self, action: Advertise | SetOrigins) -> None:
        if isinstance(action, Advertise):
            assert self.latched.get(action.local) != action.latched, f"{action.local} is published twice"
            self.latched[action.local] = action.latched
            self.kept.setdefault(action.local, {})
        else:
            assert action.local in self.kept and action.origins != self.origins[action.local]
        self.origins[action.local] = action.origins

    def _connect(self, local: str) -> None:
        """Let the bridge get the latched messages of a topic, its own ones and those of nodes, a little later."""

        def arrive() -> None:
            for publisher in [*self.publishers.get(local, {}).values()]:
                if publisher.latched and publisher.last is not None:
                    self._hand_over(local, publisher.name, True, publisher.last)
            for body in [*self.kept.get(local, {}).values()]:
                self._hand_over(local, "/bridge", True, body)

        self.network.at(self.network.now + 0.02, arrive)

    def _hand_over(self, local: str, publisher: str, latched: bool, body: bytes) -> None:
        if local in self.subscribed:
            received = ReceivedMessage(publisher, STRING._md5sum, latched, body)
            is_bridged, conversion = publisher == "/bridge", CONVERSIONS.get(local)
            if conversion and not self.site.topic_sender.would_send(local, conversion, received, is_bridged, self.now):
                return
            self.act(self.site.on_message(local, received, is_bridged, self.now, conversion))

    def _deliver(self, message: Publish) -> None:
        assert message.local in self.kept, f"{message.local} is not published"
        assert message.local in self.subscribers or self._periods, "nobody wants it"
        if message.latched:
            self.kept[message.local][message.source] = message.body
        self.delivered.append((self.run, self._periods.get(message.local, 0), decode(message.body)))
        body = decode(message.body)
        assert message.local == f"/{body.site}{body.topic}", f"{body} arrived as {message.local}: a loop"
        is_latched = TOPICS[body.topic] == "latched"
        age = self.network.now - body.time
        assert is_latched or age <= AGE, f"{body} is {age} s old"
        self._hand_over(message.local, "/bridge", message.latched, message.body)

    # Nodes ------------------------------------------------------------------------------------------------------------

    def publish(self, topic: str, publisher: Publisher) -> None:
        """Let a node publish a message."""
        publisher.number += 1
        body = Body(self.name, topic, publisher.name, publisher.number, self.network.now).encode()
        publisher.last = body
        self._hand_over(topic, publisher.name, publisher.latched, body)

    def add_publisher(self, topic: str) -> Publisher:
        """Start a node that publishes a topic."""
        self._node_count += 1
        publisher = Publisher(f"/node{self._node_count}", TOPICS[topic] == "latched")
        self.publishers.setdefault(topic, {})[publisher.name] = publisher
        return publisher

    def remove_publisher(self, topic: str, name: str) -> None:
        """End a node that publishes a topic."""
        del self.publishers[topic][name]

    def subscribe(self, local: str, on: bool) -> None:
        """Let a node subscribe to a topic, or no longer."""
        if on and local not in self.subscribers:
            self._periods[local] = self._periods.get(local, 0) + 1
        (self.subscribers.add if on else self.subscribers.discard)(local)


class Simulation:
    """Some sites that exchange everything, and a random schedule of what happens to them.

    Args:
        seed: decides everything.
        site_count: number of sites.
    """

    def __init__(self, seed: int, site_count: int = 3) -> None:
        self.random = Random(seed)
        self.network = MemoryNetwork(Random(seed + 1))
        names = ["red", "blue", "base", "green"][:site_count]
        self.sites = {name: SimulatedSite(self.network, name, all_to_all(name), self.random) for name in names}

    def run(self, events: int = 120) -> None:
        """Let random things happen, then none for a while, and check that everything is right.

        Raises:
            AssertionError: something is not.
        """
        for site in self.sites.values():
            for topic in TOPICS:
                site.add_publisher(topic)
        for _ in range(events):
            self.network.run_until(self.network.now + self.random.expovariate(5.0))
            self._happen()
        self._calm_down()
        self.network.run_until(self.network.now + CALM)
        self.check()

    def _happen(self) -> None:
        random = self.random
        site = random.choice([*self.sites.values()])
        topic = random.choice([*TOPICS])
        nodes = [*site.publishers.get(topic, {}).values()]
        other = random.choice([name for name in self.sites if name != site.name])
        match random.choices(
            [
                "publish",
                "add",
                "remove",
                "subscribe",
                "leave",
                "part",
                "mend",
                "weather",
                "restart",
                "pause",
                "call",
                "service",
                "slow",
            ],
            [60, 5, 3, 20, 3, 3, 5, 4, 0.7, 1.5, 25, 2, 3],
        )[0]:
            case "publish":
                for _ in range(random.choice([1, 1, 3, 10])):
                    site.publish(topic, random.choice(nodes or [site.add_publisher(topic)]))
            case "add" if len(nodes) < 4:
                site.publish(topic, site.add_publisher(topic))
            case "remove" if nodes:
                site.remove_publisher(topic, random.choice(nodes).name)
            case "subscribe" | "leave" as word:
                known = random.choice(sorted({*site.kept, f"/{other}{topic}"}))
                site.subscribe(known, word == "subscribe")
            case "part" | "mend" as word:
                self.network.part(site.name, other, word == "part")
            case "weather":
                jitter, loss = random.choice([0.0, 0.05, 0.4, 3.0]), random.choice([0.0, 0.05, 0.3])
                repetition = random.choice([0.0, 0.2])
                self.network.conditions = NetworkConditions(random.choice([0.001, 0.02, 0.3]), jitter, loss, repetition)
            case "restart":
                site.start()
            case "slow":
                site.act(site.site.on_slow(other, site.now))
            case "call" | "service" as word:
                site.services.happen(word, other)
            case "pause":
                self.network.run_until(self.network.now + random.uniform(0.0, 15.0))

    def _calm_down(self) -> None:
        self.network.parted.clear()
        self.network.conditions = NetworkConditions(0.01)

    # What must hold ---------------------------------------------------------------------------------------------------

    def check(self) -> None:
        """Check everything that must hold in the end."""
        for site in self.sites.values():
            self.check_order(site)
            self.check_interest(site)
            self.check_latched(site)
            self.check_nodes(site)
        check_services(self.sites)
        check_that_calls_succeed(self.sites)
        self.check_that_all_arrives()

    def check_order(self, site: SimulatedSite) -> None:
        """Nothing twice, and nothing of a publisher after a later message."""
        last: dict[tuple[int, str, str, str], tuple[int, int]] = {}
        seen: set[tuple[str, str, str, int]] = set()
        for run, period, body in site.delivered:
            latched = TOPICS[body.topic] == "latched"
            source = (run, *body[:3])
            known_number, known_period = last.get(source, (0, 0))
            if not latched:
                assert body[:4] not in seen, f"{body} came twice to {site.name}"
                assert body.number > known_number, f"{body} came after {known_number} to {site.name}"
            elif period == known_period:
                assert body.number >= known_number, f"{body} came after {known_number} to {site.name}"
            seen.add(body[:4])
            last[source] = (body.number, period)

    def check_interest(self, site: SimulatedSite) -> None:
        """A topic is subscribed to at its source if and only if another site wants it."""
        wanted = {
            topic
            for topic, publishers in site.publishers.items()
            if publishers
            and any(f"/{site.name}{topic}" in other.subscribers for other in self.sites.values() if other is not site)
        }
        assert site.subscribed == wanted, f"{site.name} subscribes to {site.subscribed}, not to {wanted}"

    def check_latched(self, site: SimulatedSite) -> None:
        """Who subscribes gets the last message of each publisher that latches and that is still there."""
        for other in self.sites.values():
            if other is site:
                continue
            for topic, publishers in other.publishers.items():
                local = f"/{other.name}{topic}"
                if publishers:
                    assert local in site.kept, f"{local} is not published at {site.name}"
                    names = tuple(sorted(f"{other.name}:{publisher}" for publisher in publishers)[:MAX_PUBLISHERS])
                    assert site.origins[local] == names, f"{site.origins[local]} are not the publishers of {local}"
                else:
                    assert local not in site.kept, f"{local} is published at {site.name}"
                expected = {each.last for each in publishers.values() if each.latched and each.last}
                if local in site.subscribers and publishers:
                    kept = {*site.kept[local].values()}
                    assert kept == expected, f"{site.name} has {kept} on {local}, not {expected}"

    def check_nodes(self, site: SimulatedSite) -> None:
        """The nodes of other sites that publish what somebody wants here can be watched."""
        expected = {
            f"/{other.name}{name}"
            for other in self.sites.values()
            for topic, publishers in other.publishers.items()
            for name in publishers
            if other is not site and f"/{other.name}{topic}" in site.subscribers
        }
        assert site.represented == expected, f"{site.name} represents {site.represented}, not {expected}"

    def check_that_all_arrives(self) -> None:
        """In calm weather, each message arrives once where somebody wants it."""
        before = {name: len(site.delivered) for name, site in self.sites.items()}
        sent = []
        for site in self.sites.values():
            for topic, publishers in site.publishers.items():
                for publisher in publishers.values():
                    site.publish(topic, publisher)
                    sent.append((site, topic, publisher.last))
                    self.network.run_until(self.network.now + 0.05)
        self.network.run_until(self.network.now + 1.0)
        for site in self.sites.values():
            arrived = sorted(body.encode() for _, _, body in site.delivered[before[site.name] :])
            wanted = sorted(
                body for source, topic, body in sent if body and f"/{source.name}{topic}" in site.subscribers
                and source is not site
            )  # fmt: skip
            assert arrived == wanted, f"{site.name} got {arrived}, not {wanted}"
