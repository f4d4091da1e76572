"""The queue of incoming packets, with limits for each sending site. No I/O.

Sites take turns according to the cost of their packets, so a site that floods this one delays only its own packets. All
sites that are not present yet count as one, so made-up names do not get more turns. Within a site, heartbeats and lists
go before messages. All sizes are in bytes.
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
"""Stands for all unknown sites."""
_MAX_COSTS = 300
"""Maximum number of sites whose costs are kept; more than a bridge talks to."""
_PACKET_COST = 2_000
"""The fixed cost of a packet, in units of the time to copy a byte."""
_CONTROL_FACTOR = 20
"""The time to parse a byte of JSON, as a multiple of the time to copy a byte."""
_CHEAP_MESSAGE = 1_000_000
_CHEAP_CONTROL = _CHEAP_MESSAGE // _CONTROL_FACTOR
"""Maximum size of the body of a message, and of another packet, that is handled without queueing, which delays other
packets: this takes about a millisecond.
"""

Received = tuple[Key, bytes, bytes]
"""A received packet: key, head and body."""


class _SiteQueue:
    """The packets of a site.

    Attributes:
        cost: the total cost of its handled packets, on a scale shared with the other sites.
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
    """Received packets that wait to be handled.

    Attributes:
        known: the sites that have proved to be present; each has its own queue. May be set in any thread.
        dropped: how many packets were dropped because too many waited, or because they were too large.
        costs: the costs of sites that have nothing waiting now but were ahead of others.
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
        self._sites: dict[str, _SiteQueue] = {}  # only sites with waiting packets
        self._bytes = 0
        self._cost = 0  # the last served site's cost, before its last packet
        self.costs: dict[str, int] = {}

    @property
    def is_empty(self) -> bool:
        """Whether no packet waits."""
        return not self._sites

    @staticmethod
    def is_cheap(packet: Received) -> bool:
        """Return whether a packet takes so little time that it need not wait here for its turn."""
        return len(packet[2]) <= (_CHEAP_MESSAGE if packet[0].topic is not None else _CHEAP_CONTROL)

    def put(self, packet: Received) -> None:
        """Add a packet. If too many messages from its site wait, the oldest is dropped; if too many of its other
        packets wait, the new one is. If too much waits in total, packets from the site with the most are dropped.
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
        """Drop a packet from the site with the most waiting bytes; return False if there is none to drop."""
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
