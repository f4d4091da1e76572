"""Queues of bulky packets, in lanes: one for packets to all sites, and one for each site that gets its own packets, so
that a slow or unresponsive site does not hold up the others. No I/O.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import count
from typing import NamedTuple

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.protocol.key_expressions import receiver_of
from pyros1.bridge.transport.pacer import Pacer
from pyros1.bridge.transport.queues import OUTBOX_BYTES, OUTBOX_PACKETS, Outbox

COMMON = ""
"""The lane for packets that are for all sites."""
DIRECT_BYTES = 48 << 10
"""Maximum size of a packet that the link drops after a millisecond if it is slow; the rest of a larger packet waits."""
LINK_QUEUE_BYTES = 512 << 10
"""How many bytes the link can queue for each priority."""
_MAX_LANES = 300


class ProbeDue(NamedTuple):
    """A probe that must follow a packet: the lane whose sites get it, and its number."""

    lane: str
    number: int


class _Lane:
    def __init__(self, numbers: Iterator[int]) -> None:
        self.outbox = Outbox()
        self.pacer = Pacer(numbers)

    @property
    def is_idle(self) -> bool:
        return not len(self.outbox) and self.pacer.is_idle


class Lanes:
    """Waiting packets, each in the lane of its receiver.

    Args:
        is_paced: whether packets wait for answers to probes; otherwise there is one lane, and its packets wait only for
            the sending thread.
        max_bytes: maximum total size in bytes of the waiting packets; each lane may have at least one.
        max_packets: maximum number of waiting packets.
    """

    def __init__(self, is_paced: bool, max_bytes: int = OUTBOX_BYTES, max_packets: int = OUTBOX_PACKETS) -> None:
        self._is_paced = is_paced
        self._max_bytes = max_bytes
        self._max_packets = max_packets
        self._numbers = count(1)  # of the probes in all lanes: an answer names no lane
        self._lanes = {COMMON: _Lane(self._numbers)}
        self._last = COMMON  # the lane whose packet was sent last

    def __len__(self) -> int:
        return sum(len(lane.outbox) for lane in self._lanes.values())

    @property
    def is_empty(self) -> bool:
        """Whether no packets are waiting."""
        for lane in self._lanes.values():  # noqa: SIM110 - any() takes thrice the time, for each message
            if lane.outbox.waiting_packets:
                return False
        return True

    @property
    def waiting_bytes(self) -> int:
        """Total size of the waiting packets."""
        return sum(lane.outbox.waiting_bytes for lane in [*self._lanes.values()])

    def _name(self, key: str) -> str:
        return receiver_of(key) if self._is_paced and not key.startswith("t/") else COMMON

    def lane_if_idle(self, packet: Send, now: float) -> str | None:
        """Return the lane of a packet that need not be queued: nothing waits, it may be sent now, and the link will
        accept it at once. Otherwise return None.
        """
        name = self._name(packet.key)
        lane = self._lanes.get(name)
        if lane is None or not self.is_empty:
            return None
        if packet.expires is not None and packet.expires < now:
            return None
        if len(packet.body) > DIRECT_BYTES and not self._has_room(lane, len(packet.body)):
            return None
        return name if not self._is_paced or lane.pacer.may_send(now) else None

    def _has_room(self, lane: _Lane, size: int) -> bool:
        """Return whether the link has room for a large packet, given what may still be queued in it."""
        if not self._is_paced or not lane.pacer.is_calm:
            return False
        return size + sum(each.pacer.unconfirmed_bytes for each in self._lanes.values()) <= LINK_QUEUE_BYTES

    def put(self, packet: Send, now: float) -> None:
        """Add a packet. If too much waits, the oldest packets of the fullest lane are dropped."""
        name = self._name(packet.key)
        lane = self._lanes.get(name)
        if lane is None:
            if len(self._lanes) >= _MAX_LANES:
                self._lanes = {key: each for key, each in self._lanes.items() if key == COMMON or not each.is_idle}
            lane = self._lanes[name] = _Lane(self._numbers)
        lane.outbox.put(packet, now)
        while self.waiting_bytes > self._max_bytes or len(self) > self._max_packets:
            fullest = max(self._lanes.values(), key=lambda each: each.outbox.waiting_bytes)
            if not fullest.outbox.drop_one():
                break

    def pop(self, now: float, before: float = math.inf) -> tuple[str, Send] | None:
        """Return the next packet to send, after its lane; None if none may be sent now. The most urgent packets go
        first; among equals, lanes take turns.

        Args:
            now: the current time in seconds.
            before: packets queued at this time or later must wait, except urgent ones.
        """
        ready = [name for name, lane in self._lanes.items() if lane.outbox]
        if self._is_paced:
            ready = [name for name in ready if self._lanes[name].pacer.may_send(now)]
        for name in ready if len(ready) <= 1 else self._in_turn(ready):
            if (packet := self._lanes[name].outbox.pop(now, before)) is not None:
                self._last = name
                return name, packet
        return None

    def _in_turn(self, ready: list[str]) -> list[str]:
        """Return lanes by the priority of their first packets; lanes with equal priority take turns."""
        names = [*self._lanes]
        last = names.index(self._last) if self._last in self._lanes else -1
        places = {name: (number - last - 1) % len(names) for number, name in enumerate(names)}
        return sorted(ready, key=lambda name: (self._lanes[name].outbox.first_priority(), places[name]))

    def on_sent(self, lane: str, packet: Send, now: float) -> ProbeDue | None:
        """Record that a packet is being sent; return the probe to send after it, if there must be one."""
        if not self._is_paced or lane not in self._lanes:
            return None
        number = self._lanes[lane].pacer.on_sent(len(packet.body), now)
        return None if number is None else ProbeDue(lane, number)

    def on_probe_sent(self, probe: ProbeDue, sites: Mapping[str, float]) -> None:
        """Record to which sites a probe is sent, see `pyros1.bridge.transport.pacer.Pacer.on_probe_sent`."""
        self._lanes[probe.lane].pacer.on_probe_sent(probe.number, sites)

    def on_answer(self, site: str, number: int, now: float) -> None:
        """Record that a site has answered a probe."""
        for name in (COMMON, site):
            if name in self._lanes:
                self._lanes[name].pacer.on_answer(site, number, now)

    def pop_slow(self) -> list[str]:
        """Return the sites that hold up others in the common lane; each is returned once."""
        common = self._lanes[COMMON].pacer
        slow = common.pop_slow()
        for site in slow:
            common.remove(site)
        return slow

    def drops(self, key: str) -> dict[str, int]:
        """Return how many packets with a key were dropped for each reason."""
        lane = self._lanes.get(self._name(key))
        return {} if lane is None else dict(lane.outbox.drops.get(key, {}))
