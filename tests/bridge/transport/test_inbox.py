"""What waits until a site handles it: a site that floods another one costs only its own packets.

Feature: a site that floods others delays nothing of third ones
"""

from __future__ import annotations

import pytest

from pyros1.bridge.names import SharedName
from pyros1.bridge.protocol.key_expressions import Channel, Key
from pyros1.bridge.protocol.packet_values import MAX_BODY
from pyros1.bridge.transport.inbox import UNKNOWN_SITES, Inbox, Received

TOPIC = SharedName("red", "/t")


def message(body: bytes, site: str = "red") -> Received:
    return Key(site, Channel.TOPIC, "", TOPIC), b"", body


def control(body: bytes, site: str = "red") -> Received:
    return Key(site, Channel.TO, "base"), b"", body


def inbox_of(**limits: int) -> Inbox:
    inbox = Inbox(**limits)
    inbox.known = {"red", "blue", "green"}
    return inbox


def drain(inbox: Inbox) -> list[bytes]:
    bodies = []
    while (each := inbox.pop()) is not None:
        bodies.append(each[2])
    return bodies


def test_heartbeats_and_lists_of_a_site_go_first() -> None:
    inbox = inbox_of()
    for packet in (message(b"1"), message(b"2"), control(b"heartbeat"), control(b"list")):
        inbox.put(packet)
    assert drain(inbox) == [b"heartbeat", b"list", b"1", b"2"] and inbox.dropped == 0


def test_what_a_site_may_have_waiting_is_bounded() -> None:
    inbox = inbox_of(site_message_bytes=10, site_control_bytes=20, site_packets=3)
    for number in range(5):
        inbox.put(message(b"%d" % number))
    for number in range(5):
        inbox.put(control(b"%d" % number))
    inbox.put(message(b"of blue", "blue"))
    assert inbox.dropped == 4
    assert sorted(drain(inbox)) == sorted([b"0", b"1", b"2", b"2", b"3", b"4", b"of blue"])
    inbox.put(message(bytes(20)))  # one may always wait
    assert inbox.dropped == 4
    inbox.put(message(b"x"))
    inbox.put(control(bytes(15)))
    inbox.put(control(bytes(15)))
    assert inbox.dropped == 6 and drain(inbox) == [bytes(15), b"x"]


def test_packets_that_are_too_large_are_not_read() -> None:
    inbox = inbox_of()
    inbox.put(control(bytes(MAX_BODY + 1)))
    assert inbox.pop() is None and inbox.dropped == 1
    inbox.put(control(bytes(MAX_BODY)))
    inbox.put(message(bytes(MAX_BODY + 1)))
    assert [len(body) for body in drain(inbox)] == [MAX_BODY, MAX_BODY + 1]


@pytest.mark.slow
def test_a_site_that_floods_waits_for_itself_only() -> None:
    inbox = inbox_of()
    for number in range(1000):
        inbox.put(control(b"%d" % number))
        inbox.put(message(b"%d" % number))
    inbox.pop()
    inbox.put(message(b"first", "blue"))
    inbox.put(message(b"second", "blue"))
    bodies = [packet[2] for _ in range(4) if (packet := inbox.pop())]
    assert b"first" in bodies and b"second" in bodies


def test_a_site_whose_packets_come_one_by_one_gets_no_more_turns() -> None:
    inbox = inbox_of()
    for _ in range(100):
        inbox.put(message(b"red"))
    turns = ["blue"]
    for _ in range(100):
        if turns[-1] == "blue":
            inbox.put(control(bytes(1000), "blue"))
        packet = inbox.pop()
        assert packet is not None
        turns.append(packet[0].site)
    assert 80 <= turns.count("red") <= 95


def test_turns_go_by_what_packets_cost() -> None:
    inbox = inbox_of()
    for _ in range(20):
        inbox.put(control(bytes(100_000)))
        inbox.put(message(bytes(100_000), "blue"))
        inbox.put(message(bytes(100), "green"))
    order = [key.site for key, _, _ in (inbox.pop() for _ in range(60)) if key]  # type: ignore[misc]
    last = {site: max(place for place, each in enumerate(order) if each == site) for site in set(order)}
    assert last["green"] < last["blue"] < last["red"] and order[:30].count("red") <= 2


def test_a_site_that_was_silent_has_not_saved_up_turns() -> None:
    inbox = inbox_of()
    for number in range(100):
        inbox.put(message(b"%d" % number))
    for _ in range(50):
        inbox.pop()
    for number in range(100):
        inbox.put(message(b"%d" % number, "blue"))
    sites = [packet[0].site for _ in range(40) if (packet := inbox.pop())]
    assert 18 <= sites.count("red") <= 22


def test_the_total_is_bounded_at_the_cost_of_who_has_most() -> None:
    inbox = inbox_of(total_bytes=1000)
    for number in range(10):
        inbox.put(message(bytes(100), "red" if number < 8 else "blue"))
    inbox.put(control(b"heartbeat", "green"))
    assert inbox.dropped == 1
    for _ in range(20):
        inbox.put(control(bytes(90)))  # more than fits, even without red's messages
    sites = [packet[0].site for _ in range(40) if (packet := inbox.pop())]
    assert sites.count("green") == 1 and sites.count("blue") == 2 and inbox.pop() is None
    inbox.put(control(bytes(2000)))
    assert len(drain(inbox)) == 1


def test_who_invents_names_gets_no_more_turns() -> None:
    inbox = inbox_of()
    inbox.put(message(b"before"))
    for number in range(2000):
        inbox.put(control(b"x", f"first{number}"))
    for number in range(10):
        inbox.put(message(b"%d" % number))
    turns = []
    for number in range(30):  # each time under another name
        packet = inbox.pop()
        assert packet is not None
        turns.append(packet[0].site)
        inbox.put(control(b"x", f"later{number}"))
    assert turns[:24].count("red") == 11 and inbox.dropped == 0


def test_all_invented_names_have_one_place_to_wait() -> None:
    inbox = inbox_of(site_packets=100)
    for number in range(400):
        inbox.put(control(b"x", f"site{number}"))
    inbox.put(control(b"x", "red"))
    assert inbox.dropped == 300 and len(drain(inbox)) == 101
    for number in range(1000):
        inbox.put(control(b"x", f"site{number}"))
        inbox.put(message(b"x", "red"))
        inbox.pop()
    assert inbox.costs.keys() <= {"red", UNKNOWN_SITES}


def test_costs_are_kept_of_few_sites() -> None:
    inbox = Inbox()
    inbox.known = {"red", *(f"site{number}" for number in range(1000))}
    for number in range(1000):
        inbox.put(control(b"x", f"site{number}"))
        inbox.put(message(b"x", "red"))
        inbox.pop()
    assert len(inbox.costs) <= 301
