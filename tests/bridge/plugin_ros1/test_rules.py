"""Which topics and services are exchanged, under which names."""

from __future__ import annotations

from typing import Any

import pytest

from pyros1.bridge.plugin_ros1.config import make_config
from pyros1.bridge.plugin_ros1.keys import Kind, Resource
from pyros1.bridge.plugin_ros1.rules import Local, PluginRules


def rules(namespace: str = "", **words: Any) -> PluginRules:
    lists = [words.get(name, "").split() for name in ("send", "take", "serve", "call")]
    return make_config(namespace, *lists).rules


def incoming(of: PluginRules, namespace: str, name: str, kind: Kind = Kind.PUBLISHER) -> str:
    found = of.incoming(Resource(kind, "std_msgs/String", "0" * 32, namespace, name))
    return found.name if isinstance(found, Local) else f"({found})"


@pytest.mark.parametrize(
    ("own", "take", "namespace", "expected"),
    [
        ("", "/odom", "*", "/odom"),
        ("", "/odom", "robot1", "/odom"),  # as the plugin does
        ("", "/odom robot1:/odom", "robot1", "/robot1/odom"),
        ("", "/odom *:/odom", "robot1", "/robot1/odom"),
        ("", "*:/odom", "*", "(no rule takes it)"),
        ("", "*:/odom", "robot-1", "(/robot-1/odom is not a name in ROS)"),
        ("", "/odom !robot1:/odom", "robot1", "(denied by a rule)"),
        ("", "robot1:/odom !/odom", "robot1", "(denied by a rule)"),
        ("robot1", "/odom", "*", "/odom"),
        ("robot1", "/odom", "robot1", "/odom"),
        ("robot1", "/odom", "robot2", "(no rule takes it)"),
        ("robot1", "robot2:/odom", "robot2", "/robot2/odom"),
        ("robot1", "robot2:/odom", "*", "(no rule takes it)"),
        ("robot1", "/**", "robot1", "/odom"),
    ],
)
def test_what_is_taken(own: str, take: str, namespace: str, expected: str) -> None:
    assert incoming(rules(own, take=take), namespace, "/odom") == expected
    assert incoming(rules(own, call=take), namespace, "/odom", Kind.SERVICE) == expected
    assert incoming(rules(own, call=take), namespace, "/odom") == "(no rule takes it)"


@pytest.mark.parametrize(
    ("own", "send", "local", "expected"),
    [
        ("", "/odom", "/odom", ["*:/odom"]),
        ("robot1", "/odom", "/odom", ["robot1:/odom"]),
        ("", "robot1:/cmd_vel", "/robot1/cmd_vel", ["robot1:/cmd_vel"]),
        ("", "robot1:/cmd_vel", "/cmd_vel", []),
        ("", "*:/cmd_vel", "/robot2/cmd_vel", ["robot2:/cmd_vel"]),
        ("", "/** !/secret", "/secret", []),
    ],
)
def test_what_is_sent(own: str, send: str, local: str, expected: list[str]) -> None:
    for found in (
        rules(own, send=send).sent_names(local, ["*", "robot1", "robot2"]),
        rules(own, serve=send).served_names(local, ["*", "robot1", "robot2"]),
    ):
        assert [f"{remote.namespace}:{remote.name}" for remote in found] == expected


def test_which_beacons_count() -> None:
    assert rules().namespaces() == {"*"}
    assert rules("robot1", send="/odom robot2:/cmd_vel", call="robot3:/spawn").namespaces() == {
        "robot1",
        "robot2",
        "robot3",
    }
    assert "*" in rules("robot1", take="*:/odom").namespaces()
