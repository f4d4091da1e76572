"""A simulated network for tests, which set its clock: it delays, loses, repeats and reorders packets, and can break."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from functools import partial
from itertools import count
from random import Random
from typing import NamedTuple

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.protocol.key_expressions import Channel, Key, parse_key, site_key
from pyros1.bridge.transport.connections import Connection
from pyros1.bridge.transport.link import Receive


class NetworkConditions(NamedTuple):
    """The delays and losses of packets in a network.

    Attributes:
        delay: minimum seconds in transit.
        jitter: maximum additional seconds, different for each packet, so that packets overtake each other.
        loss, repetition: the fractions of packets that are lost and that arrive twice, from 0 to 1.
    """

    delay: float = 0.01
    jitter: float = 0.0
    loss: float = 0.0
    repetition: float = 0.0


class MemoryNetwork:
    """A network between sites.

    Args:
        random: decides what happens to packets.
        conditions: the delays and losses; may be replaced at any time.

    Attributes:
        now: the current time in seconds; `run_until` changes it.
        parted: pairs of disconnected sites; each pair in alphabetical order.
    """

    def __init__(self, random: Random, conditions: NetworkConditions = NetworkConditions()) -> None:  # noqa: B008 - immutable
        self.now = 0.0
        self.conditions = conditions
        self.parted: set[tuple[str, str]] = set()
        self._random = random
        self._links: dict[str, MemoryLink] = {}
        self._events: list[tuple[float, int, Callable[[], object]]] = []
        self._order = count()

    def connect(self, site: str, receive: Receive) -> MemoryLink:
        """Return the link of a site; an earlier link of that site gets nothing from now on.

        Args:
            site: the site's name.
            receive: called with the packets for it.
        """
        self._links[site] = link = MemoryLink(self, site, receive)
        return link

    def part(self, first: str, second: str, apart: bool = True) -> None:
        """Break the connection between two sites, or mend it if `apart` is false."""
        pair = (min(first, second), max(first, second))
        (self.parted.add if apart else self.parted.discard)(pair)

    def at(self, time: float, event: Callable[[], object]) -> None:
        """Schedule the call of a function at a given time."""
        heapq.heappush(self._events, (max(time, self.now), next(self._order), event))

    def run_until(self, time: float) -> None:
        """Run all events up to a time."""
        while self._events and self._events[0][0] <= time:
            self.now, _, event = heapq.heappop(self._events)
            event()
        self.now = time

    def carry(self, sender: MemoryLink, packet: Send) -> None:
        """Carry a packet from a site to others: it arrives sooner or later, repeatedly or never."""
        key = parse_key(site_key(sender.site, packet.key))
        assert key is not None, packet.key
        for link in [*self._links.values()]:
            if link is sender or not link.receives(key, packet.key):
                continue
            copies = 1 + (self._random.random() < self.conditions.repetition)
            for _ in range(copies):
                if self._random.random() >= self.conditions.loss:
                    delay = self.conditions.delay + self._random.random() * self.conditions.jitter
                    self.at(self.now + delay, partial(self._arrive, sender.site, link, key, packet))

    def _arrive(self, sender: str, link: MemoryLink, key: Key, packet: Send) -> None:
        pair = (min(sender, link.site), max(sender, link.site))
        if pair not in self.parted and self._links.get(link.site) is link:
            link.receive(key, packet.head, packet.body)


class MemoryLink:
    """A site's link; see `pyros1.bridge.transport.link.Link`. Created by `MemoryNetwork.connect`."""

    def __init__(self, network: MemoryNetwork, site: str, receive: Receive) -> None:
        self.problem = ""
        self.site = site
        self.receive = receive
        self._network = network
        self._topics: set[tuple[str, str]] = set()

    def send(self, packet: Send) -> None:
        """Send a packet."""
        self._network.carry(self, packet)

    def try_send(self, packet: Send) -> bool:
        """Send a packet."""
        self.send(packet)
        return True

    def connections(self) -> list[Connection]:
        """Return nothing: tests that use this do not need connections."""
        return []

    def listen(self, site: str, key: str, on: bool) -> None:
        """Receive what another site sends on a key, or stop."""
        (self._topics.add if on else self._topics.discard)((site, key))

    def receives(self, key: Key, sent_key: str) -> bool:
        """Return whether the site receives packets with a key."""
        if key.channel is Channel.TOPIC:
            return (key.site, sent_key) in self._topics
        return key.receiver in ("", self.site)

    def close(self) -> None:
        """Stop receiving."""
        self.receive = lambda *_: None
