"""The queue of incoming packets, bounded for each sending site. No I/O.

Sites take turns by what their packets cost, so one that floods this one costs only its own packets. All sites that are
not present yet count as one, so invented names do not get more turns. Within a site, heartbeats
and lists go before messages. All sizes are in bytes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Collection

from pyros1.bridge.protocol.key_expressions import Key
from pyros1.bridge.protocol.packet_values import MAX_BODY

SITE_MESSAGE_BYTES = 32 << 20
"""Maximum total size of the waiting messages of a site; a single larger one is accepted."""
SITE_CONTROL_BYTES = 8 << 20
"""Maximum total size of the other waiting packets of a site: two long lists."""
SITE_PACKETS = 5_000
"""Maximum number of waiting messages of a site, and of its other waiting packets."""
TOTAL_BYTES = 128 << 20
"""Maximum total size of all waiting packets; a single larger one is accepted."""
UNKNOWN_SITES = ""
"""Stands for all sites that are not known."""
_MAX_COSTS = 300
"""Maximum number of sites of which costs are kept; more than a bridge talks to."""
_PACKET_COST = 2_000
"""What a packet costs besides its bytes: its fixed time, in the time to copy a byte."""
_CONTROL_FACTOR = 20
"""How many times longer it takes to read a byte of JSON."""
_CHEAP_COST = 1_000_000
"""Maximum cost of a packet for which others, which do not wait here, may wait: about a millisecond."""

Received = tuple[Key, bytes, bytes]
"""A packet that has come: key, head and body."""


class _SiteQueue:
    """The packets of a site.

    Attributes:
        cost: what was done for it, compared with the others.
    """

    def __init__(self, cost: int) -> None:
        self.cost = cost
        self.control: deque[Received] = deque()
        self.messages: deque[Received] = deque()
        self.control_bytes = self.message_bytes = 0

    @property
    def size(self) -> int:
        return self.control_bytes + self.message_bytes

    def pop_control(self) -> Received:
        packet = self.control.popleft()
        self.control_bytes -= _size(packet)
        return packet

    def pop_message(self) -> Received:
        packet = self.messages.popleft()
        self.message_bytes -= _size(packet)
        return packet


class Inbox:
    """Packets that have come and wait.

    Attributes:
        known: the sites that have shown that they are there; each has a queue of its own. May be set in any thread.
        dropped: how many packets were dropped because too many waited, or because they were too large.
        costs: what was done for sites that were ahead of others and have nothing waiting now.
    """

    def __init__(
        self,
        site_message_bytes: int = SITE_MESSAGE_BYTES,
        site_control_bytes: int = SITE_CONTROL_BYTES,
        site_packets: int = SITE_PACKETS,
        total_bytes: int = TOTAL_BYTES,
    ) -> None:
        self.known: Collection[str] = frozenset()
        self.dropped = 0
        self._site_message_bytes = site_message_bytes
        self._site_control_bytes = site_control_bytes
        self._site_packets = site_packets
        self._total_bytes = total_bytes
        self._sites: dict[str, _SiteQueue] = {}  # those of which something waits
        self._bytes = 0
        self._cost = 0  # of the site that was served last, before that
        self.costs: dict[str, int] = {}

    @property
    def is_empty(self) -> bool:
        """Whether no packet waits."""
        return not self._sites

    @staticmethod
    def is_cheap(packet: Received) -> bool:
        """Return whether handling a packet takes so little time that it need not wait here for its turn."""
        return _cost(packet) <= _CHEAP_COST

    def put(self, packet: Received) -> None:
        """Add a packet. If too many messages of its site wait, the oldest is dropped; of other packets, the new one. If
        too much waits in total, messages of the site that has most are dropped.
        """
        key, size = packet[0], _size(packet)
        is_control = key.topic is None
        if is_control and size > MAX_BODY:
            self.dropped += 1
            return
        name = key.site if key.site in self.known else UNKNOWN_SITES
        site = self._sites.get(name)
        if site is None:
            site = self._sites[name] = _SiteQueue(max(self._cost, self.costs.pop(name, 0)))
        if is_control:
            if len(site.control) >= self._site_packets or site.control_bytes + size > self._site_control_bytes:
                self.dropped += 1
                return
            site.control.append(packet)
            site.control_bytes += size
        else:
            site.messages.append(packet)
            site.message_bytes += size
        self._bytes += size
        while len(site.messages) > 1 and (
            site.message_bytes > self._site_message_bytes or len(site.messages) > self._site_packets
        ):
            self._drop_message(site)
        while self._bytes > self._total_bytes and self._drop_of_largest():
            pass

    def _drop_message(self, site: _SiteQueue) -> None:
        self._bytes -= _size(site.pop_message())
        self.dropped += 1

    def _drop_of_largest(self) -> bool:
        """Drop a packet of the site of which most waits; return whether there was one that can be dropped."""
        name, site = max(self._sites.items(), key=lambda item: item[1].size)
        if len(self._sites) == 1 and len(site.messages) + len(site.control) == 1:
            return False
        if site.messages:
            self._drop_message(site)
        else:
            self._bytes -= _size(site.pop_control())
            self.dropped += 1
        self._forget_if_empty(name, site)
        return True

    def _forget_if_empty(self, name: str, site: _SiteQueue) -> None:
        if not site.messages and not site.control:
            del self._sites[name]
            self.costs[name] = site.cost
            if len(self.costs) > _MAX_COSTS:
                self.costs = {name: cost for name, cost in self.costs.items() if cost > self._cost}
                if len(self.costs) > _MAX_COSTS:
                    del self.costs[min(self.costs, key=self.costs.__getitem__)]

    def pop(self) -> Received | None:
        """Return the packet to handle next, or None if none waits."""
        if not self._sites:
            return None
        name, site = min(self._sites.items(), key=lambda item: item[1].cost)
        self._cost = site.cost
        packet = site.pop_control() if site.control else site.pop_message()
        site.cost += _cost(packet)
        self._bytes -= _size(packet)
        self._forget_if_empty(name, site)
        return packet


def _size(packet: Received) -> int:
    return len(packet[1]) + len(packet[2])


def _cost(packet: Received) -> int:
    return _PACKET_COST + _size(packet) * (_CONTROL_FACTOR if packet[0].topic is None else 1)
