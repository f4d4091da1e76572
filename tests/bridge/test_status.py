"""The status for people."""

from __future__ import annotations

import json

from pyros1.bridge.status import status_lines

STATUS = {
    "site": "base",
    "link": "",
    "sites": [
        {"name": "red", "state": "present", "round_trip": 0.0123},
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
    "problems": {"/x": "its publishers have not said its type"},
    "trouble": {"packets that could not be sent": 1},
}


def test_lines() -> None:
    assert [*status_lines(json.loads(json.dumps(STATUS)))] == [
        "site base",
        "  red: present, round trip 12.3 ms",
        "  blue\\x1b[2J: heard",
        "sends:",
        "  /map   to blue red     1 message, 4.0 MB",
        "  /scan  no subscribers  0 messages, 0 B; dropped: 5 too old",
        "takes:",
        "  /red/odom  from red: wanted  1500 messages, 1.1 MB, now 50.02 Hz, 36.0 kB/s; dropped: 2 repeated, 1 too old",
        "  not taken: red:/cmd from red: no rule takes it",
        "  /x: its publishers have not said its type",
        "  3 packets dropped, since they came faster than they could be dealt with",
        "  ignored: red: not a packet's head (2 times)",
        "  problem: packets that could not be sent (1 time)",
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
        "  no connection yet: cannot reach it",
        "  no other site found yet",
    ]


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
