"""The status for people."""

from __future__ import annotations

import json
from collections import Counter
from random import Random

import pytest

from pyros1.bridge.exchange.outgoing import ReceivedMessage
from pyros1.bridge.names import SharedName
from pyros1.bridge.rates import Rates
from pyros1.bridge.status import flow_counts, listed, status_json, status_lines
from pyros1.bridge.transport.inbox import Inbox
from pyros1.bridge.transport.memory_link import MemoryNetwork
from pyros1.bridge.transport.sender import Sender

from .pair import STRING, Pair, rules

STATUS = {
    "site": "base",
    "link": "",
    "sites": [
        {"name": "red", "state": "present", "round_trip": 0.0123, "slow": False, "shared": True},
        {"name": "blue\x1b[2J", "state": "heard", "round_trip": None},
    ],
    "sent": [
        {
            "topic": "base:/map",
            "local": "/map",
            "type": "nav_msgs/OccupancyGrid",
            "publishers": ["/map_server"],
            "wanted_by": ["blue", "red"],
            "messages": 1,
            "bytes": 4_000_000,
            "messages_per_second": 0.0,
            "bytes_per_second": 0.0,
            "dropped": {},
        },
        {
            "topic": "base:/scan",
            "local": "/scan",
            "type": "sensor_msgs/LaserScan",
            "publishers": ["/laser"],
            "wanted_by": [],
            "messages": 0,
            "bytes": 0,
            "dropped": {"too old": 5},
        },
    ],
    "received": [
        {
            "topic": "red:/odom",
            "from": "red",
            "local": "/red/odom",
            "type": "nav_msgs/Odometry",
            "state": "wanted",
            "messages": 1500,
            "bytes": 1_080_000,
            "messages_per_second": 50.02,
            "bytes_per_second": 36_014.4,
            "dropped": {"repeated": 2, "too old": 1},
        },
        {
            "topic": "red:/cmd",
            "from": "red",
            "local": "",
            "type": "a/B",
            "state": "no rule takes it",
            "messages": 0,
            "bytes": 0,
            "dropped": {},
        },
    ],
    "waiting_bytes": 0,
    "overflowed": 3,
    "ignored": {"red: not a packet's head": 2},
    "problems": {"/x": "its publishers have not reported its type"},
    "trouble": {"packets that could not be sent": 1},
}


def test_lines() -> None:
    assert [*status_lines(json.loads(json.dumps(STATUS)))] == [
        "site base",
        "  red: present, round trip 12.3 ms, but two bridges use this name",
        "  blue\\x1b[2J: heard",
        "sends:",
        "  /map   to blue red     1 message, 4.0 MB",
        "  /scan  no subscribers  0 messages, 0 B; dropped: 5 too old",
        "takes:",
        "  /red/odom  from red: wanted  1500 messages, 1.1 MB, now 50.02 Hz, 36.0 kB/s; dropped: 2 repeated, 1 too old",
        "  not taken: red:/cmd from red: no rule takes it",
        "  /x: its publishers have not reported its type",
        "  3 packets dropped, since they came faster than they could be handled",
        "  ignored: red: not a packet's head (2 times)",
        "  problem: packets that could not be sent (1 time)",
    ]


def test_what_is_not_taken_is_counted() -> None:
    refused = [{**STATUS["received"][1], "topic": f"red:/t{number}"} for number in range(9)]  # type: ignore[dict-item]
    refused.append({**refused[0], "topic": "red:/denied", "state": "denied by a rule"})
    called = [
        {"service": f"red:/s{number}", "from": "red", "local": "", "state": "no rule calls it"} for number in (1, 2)
    ]
    lines = [*status_lines({**STATUS, "received": refused, "called": called})]
    assert [line for line in lines if line.startswith("  not ")] == [
        "  not taken: red:/t0 red:/t1 red:/t2 and 6 more topics from red: no rule takes it",
        "  not taken: red:/denied from red: denied by a rule",
        "  not provided: red:/s1 red:/s2 from red: no rule calls it",
    ]


def test_a_site_alone() -> None:
    status = {
        **STATUS,
        "link": "cannot reach it",
        "sites": [],
        "sent": [],
        "received": [],
        "overflowed": 0,
        "ignored": {},
        "problems": {},
        "trouble": {},
    }
    assert [*status_lines(status)] == [
        "site base",
        "  no connection: cannot reach it",
        "  no other site found yet",
    ]


def test_a_site_that_offers_too_much(monkeypatch: pytest.MonkeyPatch) -> None:
    """The status would be too large to be read."""
    monkeypatch.setattr("pyros1.bridge.status.LISTED_BYTES", 100_000)
    pair = Pair(rules("take: ['*:/t/**']", "base"), rules("send: ['/**']", "arm"))
    pair.wait()
    pair.publish("arm", *(f"/{'tx'[number % 2]}/n{number}" for number in range(3000)))
    link = MemoryNetwork(Random(1)).connect("base", lambda *_: None)
    sender = Sender(link, lambda: 0.0, lambda _: None)
    try:
        text = status_json(pair.sites["base"], link, sender, Inbox(), Rates(), {}, {})
    finally:
        sender.close()
    status = json.loads(text)
    more = status["not_listed"]["arm"]
    assert len(text) < 200_000 and len(status["received"]) + more == 3000
    assert f"  {more} more topics and services of arm are not listed" in [*status_lines(status)]


def test_topics_that_flow_are_counted() -> None:
    pair = Pair(rules("take: ['*:**']", "base"), rules("send: ['/**']", "arm"))
    pair.wait()
    pair.publish("arm", "/a", "/b")
    pair.wait()
    pair.pass_on("base", pair.sites["base"].set_subscribed({"/arm/a", "/arm/b"}, pair.now))
    pair.wait()
    message = ReceivedMessage("/node", STRING._md5sum, False, b"\x01\0\0\0x")
    for _ in range(2):
        pair.pass_on("arm", pair.sites["arm"].on_message("/a", message, False, pair.now))
    topic = SharedName("arm", "/a")
    assert flow_counts(pair.sites["arm"]) == {("", topic): (2, 10)}
    assert flow_counts(pair.sites["base"]) == {("arm", topic): (2, 10)}


@pytest.mark.parametrize(
    ("sizes", "kept"),
    [
        ({"red": 50, "blue": 50}, {"red": 50, "blue": 50}),
        ({"red": 10, "liar": 1000}, {"red": 10, "liar": 90}),
        ({"liar": 1000, "red": 10, "other": 900}, {"red": 10, "liar": 45, "other": 45}),
        ({}, {}),
    ],
)
def test_no_site_hides_others(sizes: dict[str, int], kept: dict[str, int], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("pyros1.bridge.status.LISTED_BYTES", 100)
    entries = [site for site, size in sizes.items() for _ in range(size)]
    found, more = listed(entries, str, lambda _: 1)
    assert Counter(found) == kept and Counter(more) == Counter(sizes) - Counter(kept)


def test_services_are_listed_in_columns() -> None:
    calls = {"from": "red", "state": "", "calls": 1, "errors": 0, "last_error": ""}
    failed = {"from": "blue", "state": "", "calls": 2, "errors": 1, "last_error": "no"}
    called = [{**calls, "local": "/red/set_map"}, {**failed, "local": "/blue/set"}]
    lines = [*status_lines({**STATUS, "called": called})]
    start = lines.index("provides services of others:")
    assert lines[start + 1 : start + 3] == [
        "  /red/set_map  from red   1 call",
        "  /blue/set     from blue  2 calls, 1 error, the last: no",
    ]


def test_actions_are_listed_below_one_title() -> None:
    action = {"action": "/fibonacci", "type": "actionlib_tutorials/Fibonacci", "node": "/server", "server": "ROS 2"}
    lines = [*status_lines({**STATUS, "actions": [action, {**action, "action": "/dock", "type": "my_msgs/Dock"}]})]
    start = lines.index("  actions:")
    assert lines[start + 1 : start + 3] == [
        "    /fibonacci (actionlib_tutorials/Fibonacci): server /server in ROS 2",
        "    /dock (my_msgs/Dock): server /server in ROS 2",
    ]
