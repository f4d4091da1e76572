"""What `wtf` says of bridges: nothing when all is well."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from pyros1 import __version__
from pyros1.bridge.exchange.outgoing import DropReason
from pyros1.bridge.exchange.peer import State
from pyros1.bridge.exchange.site import Site
from pyros1.bridge.protocol.packets import Kind, decode_head, encode_head
from pyros1.bridge.rules.parsing import parse_config
from pyros1.doctor.bridge_checks import DROPS, INTENDED, LOST, NO_RULE, OTHER_VERSION, PRESENT, check_bridges
from pyros1.doctor.facts import System
from pyros1.doctor.finding import Finding
from pyros1.doctor.system import collect_system
from pyros1.graph import SystemState
from pyros1.ground.errors import Error
from pyros1.node import Node

TOPIC = {"topic": "red:/odom", "local": "/red/odom", "usual": "/red/odom", "state": "subscribed", "messages": 90}
STATUS: dict[str, Any] = {
    "version": __version__,
    "site": "base",
    "link": "",
    "sites": [{"name": "red", "state": "present"}],
    "sent": [],
    "received": [{**TOPIC, "dropped": {"too old": 4, "repeated": 5000, "over the rate limit": 5000}}],
    "problems": {},
    "ignored": {"red: not a packet's head": 3},
}


def check(**changes: Any) -> list[Finding]:
    state = SystemState({}, {"/red/odom": ["/listener"]}, {})
    return check_bridges(System("http://here:11311/", state, {}, bridges={"/bridge_base": {**STATUS, **changes}}))


def received(**changes: Any) -> dict[str, Any]:
    return {"received": [{**TOPIC, "dropped": {}, **changes}]}


def test_a_topic_that_a_node_here_publishes_is_not_missed() -> None:
    state = SystemState({"/red/odom": ["/own"]}, {"/red/odom": ["/listener"]}, {})
    status = {**STATUS, **received(state=NO_RULE, local="")}
    assert check_bridges(System("http://here:11311/", state, {}, bridges={"/bridge_base": status})) == []


def test_nothing_when_all_is_well() -> None:
    assert check() == []
    assert check(**received(state="denied by a rule")) == []
    assert check(**received(state=NO_RULE, usual="/red/else")) == []
    assert check(**received(state="nobody here subscribes"), dialect="zenoh-plugin-ros1") == []
    assert check_bridges(System("http://here:11311/", SystemState({}, {}, {}), {})) == []


@pytest.mark.parametrize(
    ("changes", "kind", "items"),
    [
        ({"version": "0.1"}, "bridge-version", ("/bridge_base: 0.1",)),
        ({"ignored": {f"red: {OTHER_VERSION}": 7}}, "bridge-protocol", ("/bridge_base: red",)),
        ({"link": "no route\x1b", "sites": []}, "bridge-link", ("/bridge_base: no route\\x1b",)),
        ({"sites": []}, "bridge-alone", ("/bridge_base",)),
        (
            {"link": "refused\x1b", "sites": [], "dialect": "ros2"},
            "bridge-ros2-link",
            ("/bridge_base: refused\\x1b",),
        ),
        ({"sites": [], "dialect": "ros2"}, "bridge-ros2-alone", ("/bridge_base",)),
        ({"sites": [], "dialect": "ros2", "via": "rclpy"}, "bridge-ros2-alone", ("/bridge_base",)),
        (
            {"link": "rclpy was shut down", "sites": [], "dialect": "ros2", "via": "rclpy"},
            "bridge-rclpy",
            ("/bridge_base: rclpy was shut down",),
        ),
        ({"sites": [{"name": "red", "state": "lost"}]}, "bridge-site", ("/bridge_base: red",)),
        ({"sites": [{"name": "red", "state": "present", "shared": True}]}, "bridge-name", ("/bridge_base: red",)),
        (
            {"sites": [{"name": "red", "state": "heard"}]},
            "bridge-site",
            ("/bridge_base: red has been heard, but does not answer",),
        ),
        (
            received(state="/red/odom is already a a/B, not a c/D"),
            "bridge-refused",
            ("/bridge_base: red:/odom: /red/odom is already a a/B, not a c/D",),
        ),
        (received(state=NO_RULE, local=""), "bridge-not-taken", ("/listener: /red/odom",)),
        (
            {"problems": {"/x": "its publishers have not reported its type"}},
            "bridge-topic",
            ("/bridge_base: /x: its publishers have not reported its type",),
        ),
        (received(dropped={"too old": 10}), "bridge-drops", ("/bridge_base: red:/odom: 10 of 100",)),
        (
            {"sent": [{**TOPIC, "dropped": {"too large": 910}}]},
            "bridge-drops",
            ("/bridge_base: red:/odom: 910 of 1000",),
        ),
    ],
)
def test_findings(changes: dict[str, Any], kind: str, items: tuple[str, ...]) -> None:
    (finding,) = check(**changes)
    assert (finding.kind, finding.items) == (kind, items)
    assert finding.fix and finding.text


def test_through_rclpy_no_router_of_zenoh_is_to_be_checked() -> None:
    for changes in ({"link": ""}, {"link": "rclpy was shut down"}):
        (finding,) = check(sites=[], dialect="ros2", via="rclpy", **changes)
        assert "zenoh" not in finding.fix


def test_what_is_not_taken_names_the_rule_that_would() -> None:
    (finding,) = check(**received(state=NO_RULE, local=""))
    assert finding.fix == "restart the bridge with --take 'red:/odom'"


@pytest.mark.parametrize("status", [{"site": "base"}, {**STATUS, "sites": 5}, {**STATUS, "received": [{}]}])
def test_a_status_that_cannot_be_read(status: dict[str, Any]) -> None:
    system = System("http://here:11311/", SystemState({}, {}, {}), {}, bridges={"/b": status, "/good": STATUS})
    (finding,) = check_bridges(system)
    assert finding.kind == "bridge-version" and "/b" in finding.text


def test_the_words_are_those_of_bridges() -> None:
    reasons = {value for name, value in vars(DropReason).items() if name.isupper()}
    assert set(DROPS) <= reasons
    assert {LOST, PRESENT} <= {state.value for state in State}
    site = Site(parse_config("", "f", "base").rules, 1, 0.0)
    assert NO_RULE in INTENDED and site.name == "base"
    with pytest.raises(Error, match=OTHER_VERSION):
        decode_head(b"\x63" + encode_head(Kind.HELLO, 1)[1:])


def test_statuses_are_collected_from_a_running_system(make_node: Callable[..., Node]) -> None:
    node = make_node("bridge_base")
    node.advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, json.dumps(STATUS)))
    make_node("liar").advertise_service("~bridge_status", "std_srvs/Trigger", lambda _: (True, "[]"))
    system = collect_system(node.master)
    assert system.bridges == {"/bridge_base": STATUS}
    assert collect_system(node.master, ["/bridge_base"]).bridges == {}
