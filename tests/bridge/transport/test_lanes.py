"""Lanes: what waits for a slow site does not hold up others.

Feature: a slow site, or one that does not answer, does not slow down others -- it gets packets of its own for a while
"""

from __future__ import annotations

import heapq
from itertools import count

import pytest

from pyros1.bridge.exchange.actions import Send
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.rules.rules import Priority
from pyros1.bridge.transport.lanes import COMMON, DIRECT_BYTES, LINK_QUEUE_BYTES, Lanes
from pyros1.bridge.transport.pacer import FIRST_WINDOW, PATIENCE


def packet(key: str, body: bytes = b"x", priority: Priority = Priority.NORMAL) -> Send:
    return Send(key, b"", body, priority)


def bodies(lanes: Lanes, now: float = 0.0) -> list[bytes]:
    """Send everything that may be sent, and return it."""
    found = []
    while (popped := lanes.pop(now)) is not None:
        lanes.on_sent(*popped, now)
        found.append(popped[1].body)
    return found


class Network:
    """A site that sends images to two others as fast as lanes let it: base, and blue over a slow network.

    Args:
        rates: site -> bytes per second of its network.
    """

    def __init__(self, rates: dict[str, float]) -> None:
        self.lanes = Lanes(is_paced=True)
        self.rates = rates
        self.separate: set[str] = set()
        self.arrived: dict[str, list[tuple[float, int]]] = {site: [] for site in rates}
        self._free = dict.fromkeys(rates, 0.0)
        self._events: list[tuple[float, int, str, int]] = []
        self._order = count()

    def run(self, duration: float, size: int, period: float) -> None:
        """Send an image in each period; note in `arrived` when each comes, and how old it is then in periods."""
        now, number = 0.0, 0
        while now < duration:
            if now >= number * period:
                body = number.to_bytes(4, "big") + bytes(size)
                self.lanes.put(Send("t/red/image", b"", body, Priority.NORMAL, 1, True), now)
                for site in self.separate:
                    self.lanes.put(Send(f"again/{site}/red/image", b"", body, Priority.NORMAL, 1, True), now)
                number += 1
            while (popped := self.lanes.pop(now)) is not None:
                self._carry(*popped, now, int(now / period))
            for site in self.lanes.pop_slow():
                self.separate.add(site)
            now += 0.002
            while self._events and self._events[0][0] <= now:
                _, _, site, probe = heapq.heappop(self._events)
                self.lanes.on_answer(site, probe, now)

    def _carry(self, lane: str, image: Send, now: float, newest: int) -> None:
        sites = [lane] if lane != COMMON else [site for site in self.rates if site not in self.separate]
        for site in sites:
            self._free[site] = max(now, self._free[site]) + len(image.body) / self.rates[site]
            self.arrived[site].append((self._free[site], newest - int.from_bytes(image.body[:4], "big")))
        probe = self.lanes.on_sent(lane, image, now)
        if probe is not None:
            self.lanes.on_probe_sent(probe, dict.fromkeys(sites, 0.02))
            for site in sites:
                heapq.heappush(self._events, (self._free[site] + 0.02, next(self._order), site, probe.number))


@pytest.mark.parametrize("size", [20_000, 100_000])
def test_a_slow_site_does_not_slow_down_others(size: int) -> None:
    network = Network({"base": 12_500_000.0, "blue": 125_000.0})
    network.run(60.0, size, 0.1)
    assert network.separate == {"blue"}
    late = {site: [at for at, _ in arrived if 20.0 < at <= 60.0] for site, arrived in network.arrived.items()}
    assert len(late["base"]) > 390, "base gets all 10 images per second"
    assert 0.7 <= len(late["blue"]) * size / 125_000 / 40 <= 1.05, "blue gets what its network carries"
    ages = [age for at, age in network.arrived["blue"] if at > 20.0]
    assert max(ages) <= 15, "and they are new when they are sent"


def test_sites_behind_the_same_network_share_packets() -> None:
    network = Network({"base": 125_000.0, "blue": 125_000.0})
    network.run(60.0, 20_000, 0.1)
    assert network.separate == set()


def test_a_site_that_does_not_answer_holds_up_only_itself() -> None:
    lanes = Lanes(is_paced=True)
    lanes.put(packet("call/liar/red/set", bytes(FIRST_WINDOW)), 0.0)
    popped = lanes.pop(0.0)
    assert popped is not None and popped[0] == "liar"
    probe = lanes.on_sent(*popped, 0.0)
    assert probe is not None
    lanes.on_probe_sent(probe, {"liar": 0.02})
    lanes.put(packet("call/liar/red/set", b"waits"), 0.0)
    lanes.put(packet("again/base/red/map", b"for base"), 0.0)
    lanes.put(packet("t/red/odom", b"for all"), 0.0)
    assert sorted(bodies(lanes)) == [b"for all", b"for base"]
    assert bodies(lanes, PATIENCE + 0.1) == [b"waits"] and len(lanes) == 0


def test_urgent_packets_first_and_lanes_in_turns() -> None:
    lanes = Lanes(is_paced=True)
    for key in ("t/red/a", "again/base/red/a", "again/blue/red/a"):
        for number in range(2):
            lanes.put(packet(key, f"{key[-1]}{key[:7]}{number}".encode(), Priority.LOW), 0.0)
    lanes.put(packet("again/blue/red/b", b"urgent", Priority.NORMAL), 0.0)
    sent = bodies(lanes)
    assert sent[0] == b"urgent" and {each[-1:] for each in sent[1:4]} == {b"0"} and len(sent) == 7


def test_the_fullest_lane_gives_way() -> None:
    lanes = Lanes(is_paced=True, max_bytes=1_000)
    for number in range(9):
        lanes.put(packet("again/blue/red/a", bytes([number]) * 100), 0.0)
    for number in range(5):
        lanes.put(packet("t/red/a", bytes([100 + number]) * 100), 0.0)
    assert lanes.waiting_bytes == 1_000
    assert lanes.drops("again/blue/red/a") == {DropReason.QUEUE: 4} and lanes.drops("t/red/a") == {}
    assert {body[0] for body in bodies(lanes)} == {4, 5, 6, 7, 8, 100, 101, 102, 103, 104}
    lanes.put(packet("t/red/large", bytes(5_000)), 0.0)
    assert len(lanes) == 1, "a single packet may be larger"


def test_a_maximum_number_of_packets() -> None:
    lanes = Lanes(is_paced=True, max_packets=3)
    for number in range(5):
        lanes.put(packet(f"again/{number % 2}/red/a", b"%d" % number), 0.0)
    assert len(lanes) == 3


@pytest.mark.slow
def test_lanes_of_sites_that_are_gone_are_forgotten() -> None:
    lanes = Lanes(is_paced=True)
    for number in range(1_000):
        lanes.put(packet(f"to/site{number}", b"gone", Priority.URGENT), 0.0)
        popped = lanes.pop(0.0)
        assert popped is not None and popped[1].body == b"gone"
        if number == 0:
            lanes.put(packet("to/busy", b"stays"), 0.0)
        elif number == 500:  # between being taken and being sent
            for other in range(500):
                lanes.put(packet(f"again/other{other}/red/a"), 0.0)
        if (probe := lanes.on_sent(*popped, 0.0)) is not None:
            lanes.on_probe_sent(probe, {})
    assert len(lanes) == 501 and bodies(lanes)[0] == b"stays"


def test_without_pacing_there_is_one_lane() -> None:
    lanes = Lanes(is_paced=False)
    lanes.put(packet("to/base", bytes(10 * FIRST_WINDOW)), 0.0)
    lanes.put(packet("to/blue", b"next"), 0.0)
    lanes.put(packet("to/base", b"first", Priority.URGENT), 0.0)
    first, second, third = (lanes.pop(0.0) for _ in range(3))
    assert first and second and third and [each[1].body[:5] for each in (first, third)] == [b"first", b"next"]
    assert lanes.on_sent(*second, 0.0) is None and {first[0], second[0], third[0]} == {COMMON}


def test_nothing_is_sent_at_once_while_something_waits_in_any_lane() -> None:
    """Else it would go without its turn."""
    lanes = Lanes(is_paced=True)
    for waiting, other in (("t/red/a", "t/red/b"), ("again/blue/red/a", "t/red/b")):
        lanes.put(packet(waiting), 0.0)
        assert lanes.lane_if_idle(packet(other), 0.0) is None
        assert bodies(lanes) == [b"x"] and lanes.lane_if_idle(packet(other), 0.0) == COMMON


def calm(lanes: Lanes) -> None:
    """Let everything that the common lane sends be confirmed at once."""
    for step in range(2):
        probe = lanes.on_sent(COMMON, packet("t/red/image", bytes(FIRST_WINDOW)), step / 10)
        assert probe is not None
        lanes.on_probe_sent(probe, {"base": 0.001})
        lanes.on_answer("base", probe.number, step / 10 + 0.001)


def test_large_packets_go_at_once_only_where_the_link_has_room() -> None:
    lanes = Lanes(is_paced=True)
    small, large = (packet("t/red/image", bytes(size)) for size in (DIRECT_BYTES, DIRECT_BYTES + 1))
    assert lanes.lane_if_idle(small, 0.0) == COMMON
    assert lanes.lane_if_idle(large, 0.0) is None, "nothing is known of the network"
    calm(lanes)
    assert lanes.lane_if_idle(large, 1.0) == COMMON
    assert lanes.lane_if_idle(packet("t/red/image", bytes(LINK_QUEUE_BYTES)), 1.0) == COMMON
    assert lanes.lane_if_idle(packet("t/red/image", bytes(LINK_QUEUE_BYTES + 1)), 1.0) is None


def test_what_other_lanes_send_takes_up_room() -> None:
    lanes = Lanes(is_paced=True)
    lanes.put(packet("again/blue/red/image"), 0.0)
    assert bodies(lanes) == [b"x"]
    calm(lanes)
    lanes.on_sent("blue", packet("again/blue/red/image", bytes(LINK_QUEUE_BYTES - DIRECT_BYTES)), 1.0)
    assert lanes.lane_if_idle(packet("t/red/image", bytes(DIRECT_BYTES + 1)), 1.0) is None
    assert lanes.lane_if_idle(packet("t/red/image", bytes(DIRECT_BYTES)), 1.0) == COMMON


def test_urgent_packets_that_are_large_are_left_to_the_thread() -> None:
    assert Lanes(is_paced=False).lane_if_idle(packet("t/red/image", bytes(DIRECT_BYTES + 1)), 0.0) is None
