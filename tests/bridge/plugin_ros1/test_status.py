"""What the status of a bridge of the dialect looks like."""

from __future__ import annotations

import json
from types import SimpleNamespace
from typing import Any

from pyros1.bridge.plugin_ros1.services import PluginServices
from pyros1.bridge.plugin_ros1.status import status_json
from pyros1.bridge.status import status_lines

from .test_keys import BEACON
from .test_plan import topic
from .test_state import KEY, received, state


def lines(bridge: Any, services: PluginServices | None = None) -> list[str]:
    session, sender = SimpleNamespace(problem=""), SimpleNamespace(drops=lambda _: {}, waiting_bytes=0)
    text = status_json(bridge, session, sender, services, {"/bad": "refused"}, {"trouble": 2}, 3)  # type: ignore[arg-type]
    return [*status_lines(json.loads(text))]


def test_topics() -> None:
    bridge = state(take="/chatter", send="/odom robot1:/cmd_vel")
    bridge.set_local([topic("/odom"), topic("/robot1/cmd_vel")], [], 1.0)
    bridge.wanted = frozenset(resource for resource in bridge.plan.sends if resource.namespace == "robot1")
    bridge.on_message("/robot1/cmd_vel", received(), False, 1.0)
    for key in (BEACON, BEACON.replace("/chatter", "/other"), BEACON.replace("/pub/", "/srv/")):
        bridge.on_beacon(key, 1.0)
    bridge.on_sample(KEY, b"text", 1.0)
    assert lines(bridge) == [
        "bridge of zenoh-plugin-ros1, without a namespace",
        "  bridges without a namespace: present",
        "sends:",
        "  /odom            no subscribers  0 messages, 0 B",
        "  /robot1/cmd_vel  to robot1       1 message, 4 B",
        "takes:",
        "  /chatter  from bridges without a namespace: nobody here subscribes  1 message, 4 B",
        "  not taken: /other from bridges without a namespace: no rule takes it",
        "  not taken: /chatter from bridges without a namespace: no rule takes it (a service)",
        "  /bad: refused",
        "  3 packets dropped, since they came faster than they could be handled",
        "  problem: trouble (2 times)",
    ]


def test_services() -> None:
    bridge = state("robot1", call="/chatter")
    bridge.on_beacon(BEACON.replace("/pub/", "/srv/").replace("/*/chatter", "/robot1/chatter"), 1.0)
    services = PluginServices(SimpleNamespace(name="/bridge"), None, bridge.key)  # type: ignore[arg-type]
    count = services.count("calls", "/chatter")
    count.calls, count.errors, count.last_error, count.note = 2, 1, "crashed", "a note"
    assert lines(bridge, services)[:3] == [
        "bridge of zenoh-plugin-ros1, in namespace robot1",
        "  robot1: present",
        "  calls /chatter as robot1:/chatter: 2 calls, 1 error, the last one: crashed (a note)",
    ]
