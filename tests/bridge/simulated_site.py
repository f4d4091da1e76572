"""A site with a master that is only a table, and nodes that are only names, see `simulation`.

Each message's body says where it came from and when, so what is delivered can be judged without looking into a site.
"""

from __future__ import annotations

from collections.abc import Iterable
from random import Random
from typing import Any, NamedTuple

from pyros1.bridge.conversions.conversion import Conversion, MessageType
from pyros1.bridge.deferred import Change
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
from pyros1.bridge.rules.namespaces import UsedTopics
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.rules.rules import Rules
from pyros1.bridge.transport.inbox import Inbox, Received
from pyros1.bridge.transport.memory_link import MemoryLink, MemoryNetwork
from pyros1.msgs import load_message

from .simulated_master import MasterConditions, SimulatedMaster
from .simulated_services import SimulatedServices

TICK = 0.1
POLL = 0.5
AGE = 2.0
"""Maximum age in seconds of the messages of all topics that are not latched."""
STRING: Any = load_message("std_msgs/String")
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
        decided: what the bridge has decided to publish, although its master may not know yet: topic -> whether it is
            latched, and the original publishers.
        master: how its master responds.
        load: maximum seconds that packets wait if the bridge cannot handle them at once, as on a busy machine.
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
        self.decided: dict[str, tuple[bool, tuple[str, ...]]] = {}
        self.master = MasterConditions()
        self.load = 0.0
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
        self._master = SimulatedMaster(network, random, self.master, lambda: self.now, self._do, self.act)
        self.start()

    @property
    def now(self) -> float:
        """The time by the site's own clock."""
        return self._clock_start + self.network.now * self._clock_rate

    # Running ----------------------------------------------------------------------------------------------------------

    def start(self) -> None:
        """Start the bridge, or start it again after it was killed."""
        self.run += 1
        self.subscribed, self.kept, self.decided, self.represented = set(), {}, {}, set()
        self._master.close()
        self._master = SimulatedMaster(self.network, self.random, self.master, lambda: self.now, self._do, self.act)
        self.services.start()
        self.site = Site(self._rules, self.random.getrandbits(63) + 1, self.now)
        run = self.run
        self.inbox = Inbox()
        self.link: MemoryLink = self.network.connect(self.name, lambda *packet: self._receive(run, packet))
        self.act(self.site.start())
        self._tick(run)
        self._poll(run)

    def _tick(self, run: int) -> None:
        if run == self.run:
            self.act(self.site.tick(self.now))
            self.inbox.known = self.site.known_sites()
            self._check_lost()
            self.network.at(self.network.now + TICK, lambda: self._tick(run))

    def _receive(self, run: int, packet: Received) -> None:
        """Handle a packet at once, or let it wait with others, see `pyros1.bridge.packet_worker`."""
        if not self.inbox.is_empty:
            self.inbox.put(packet)
        elif self.load and self.random.random() < 0.3:
            self.inbox.put(packet)
            self.network.at(self.network.now + self.random.uniform(0.0, self.load), lambda: self._handle_waiting(run))
        elif run == self.run:
            self.act(self.site.on_packet(*packet, self.now))

    def _handle_waiting(self, run: int) -> None:
        if run == self.run:
            while (packet := self.inbox.pop()) is not None:
                self.act(self.site.on_packet(*packet, self.now))

    def _check_lost(self) -> None:
        """While a site is lost, nothing of it is published here."""
        for name, state, *_ in self.site.sites():
            if state is State.LOST:
                left = [each for each in (*self.decided, *self.represented) if each.startswith(f"/{name}/")]
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
        self._master.poll()
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
                case Subscribe() | Advertise() | SetOrigins() | Withdraw():
                    self._decide(action)
                case Publish():
                    if not self._master.hold(action):
                        self._deliver(action)
                case RestartConversion(local, conversion):
                    assert CONVERSIONS[local] == conversion
                case Forget(local, source):
                    if not self._master.hold(action):
                        self.kept.get(local, {}).pop(source, None)
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

    def _decide(self, action: Change) -> None:
        """Leave an action to the master, which may be slow."""
        if isinstance(action, Advertise):
            assert self.decided.get(action.local, (None,))[0] != action.latched, f"{action.local} is published twice"
            self.decided[action.local] = action.latched, action.origins
        elif isinstance(action, SetOrigins):
            latched, origins = self.decided[action.local]
            assert origins != action.origins
            self.decided[action.local] = latched, action.origins
        elif isinstance(action, Withdraw):
            del self.decided[action.local]
        self._master.put(action)

    def _do(self, action: Change) -> None:
        """Do what the bridge has asked the master for."""
        match action:
            case Subscribe(local, on, conversion):
                assert conversion == CONVERSIONS.get(local)
                assert not (on and local in self.subscribed), f"{local} is subscribed to twice"
                (self.subscribed.add if on else self.subscribed.discard)(local)
                if on:
                    self._connect(local)
            case Advertise(local):
                self.kept.setdefault(local, {})
                self.origins[local] = action.origins
            case SetOrigins(local, origins):
                assert local in self.kept, f"{local} is not published"
                self.origins[local] = origins
            case Withdraw(local):
                self.kept.pop(local, None)  # what should have begun may have failed
                self.origins.pop(local, None)

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
