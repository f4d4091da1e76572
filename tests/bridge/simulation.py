"""Sites on a network in memory, what happens to them, and what must hold whatever happens.

A site's state machine, its queue of packets and its actions for the master are the real ones, see `simulated_site` and
`simulated_master`; the threads and the network are not.
"""

from __future__ import annotations

from random import Random

from pyros1.bridge.protocol.packets import MAX_PUBLISHERS
from pyros1.bridge.transport.memory_link import MemoryNetwork, NetworkConditions

from .simulated_services import check_services, check_that_calls_succeed
from .simulated_site import TOPICS, SimulatedSite, all_to_all

CALM = 65.0
"""Seconds without trouble after which everything must be right, and all calls must have ended."""


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
                "load",
            ],
            [60, 5, 3, 20, 3, 3, 5, 4, 0.7, 1.5, 25, 2, 3, 2],
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
            case "load":
                site.master.change(random)
                site.load = random.choice([0.0, 0.05, 0.5])
            case "call" | "service" as word:
                site.services.happen(word, other)
            case "pause":
                self.network.run_until(self.network.now + random.uniform(0.0, 15.0))

    def _calm_down(self) -> None:
        self.network.parted.clear()
        self.network.conditions = NetworkConditions(0.01)
        for site in self.sites.values():
            site.load = site.master.delay = site.master.failures = 0.0

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
        self.check_first_messages()

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

    def check_first_messages(self) -> None:
        """Of a reliable topic, all messages arrive that are published after its source knows who wants it, even if they
        overtake each other.
        """
        topics = [topic for topic, kind in TOPICS.items() if kind == "reliable"]
        self._subscribe_everywhere(topics, False)
        self.network.run_until(self.network.now + CALM)
        self.network.conditions = NetworkConditions(0.01, jitter=0.3)
        self._subscribe_everywhere(topics, True)
        before = {name: len(site.delivered) for name, site in self.sites.items()}
        wanted: dict[str, list[bytes]] = {name: [] for name in self.sites}
        for _ in range(60):
            self.network.run_until(self.network.now + 0.05)
            for source in self.sites.values():
                requests = {local.name: topic.requests for topic, local, _ in source.site.sent_topics()}
                for topic in topics:
                    for publisher in source.publishers.get(topic, {}).values():
                        is_connected = topic in source.subscribed
                        source.publish(topic, publisher)
                        for name in requests.get(topic, ()) if is_connected else ():
                            wanted[name].append(publisher.last or b"")
        self.network.run_until(self.network.now + 3.0)
        for site in self.sites.values():
            arrived = {body.encode() for _, _, body in site.delivered[before[site.name] :]}
            lost = [body for body in wanted[site.name] if body not in arrived]
            assert not lost, f"{site.name} did not get the first messages: {lost[:3]} of {len(wanted[site.name])}"

    def _subscribe_everywhere(self, topics: list[str], on: bool) -> None:
        for site in self.sites.values():
            for other in self.sites.values():
                for topic in topics if other is not site else ():
                    site.subscribe(f"/{other.name}{topic}", on)
