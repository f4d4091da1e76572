"""Which nodes of other sites are represented here, and under which names."""

from __future__ import annotations

from pyros1.bridge.exchange.actions import RepresentNode
from pyros1.bridge.exchange.remote_nodes import MAX_REPRESENTED, RemoteNodes
from pyros1.bridge.rules.parsing import parse_config

LONG = "/" + "a" * 254


def make(text: str = "") -> RemoteNodes:
    return RemoteNodes(parse_config(text, "f", "base").rules)


def test_nodes_come_and_go() -> None:
    nodes = make()
    assert nodes.update("red", ["/talker"]) == [RepresentNode("/red/talker", "red", "/talker")]
    assert nodes.update("red", ["/talker"]) == []
    assert nodes.update("red", ["/other"]) == [
        RepresentNode("/red/talker", "", ""),
        RepresentNode("/red/other", "red", "/other"),
    ]
    assert nodes.names("red") == ["/red/other"]
    assert nodes.drop("red") == [RepresentNode("/red/other", "", "")]
    assert nodes.drop("red") == [] and nodes.names("red") == []


def test_names_are_always_below_that_of_the_site() -> None:
    nodes = make("prefix: {red: /, blue: /robots/blue}")
    assert nodes.update("red", ["/bridge_base"])[0].local == "/red/bridge_base"  # and not the bridge itself
    assert nodes.update("blue", ["/talker"])[0].local == "/robots/blue/talker"


def test_two_sites_with_one_name_here() -> None:
    nodes = make("prefix: {'*': /robots}")
    assert nodes.update("red", ["/talker"])
    assert nodes.update("blue", ["/talker"]) == [], "the first one keeps the name"
    nodes.drop("red")
    assert nodes.update("blue", ["/talker"]) == [RepresentNode("/robots/talker", "blue", "/talker")]


def test_there_are_not_too_many_and_not_with_names_that_are_too_long() -> None:
    nodes = make()
    assert nodes.update("red", [LONG]) == []
    count = sum(len(nodes.update(site, [f"/n{number}" for number in range(150)])) for site in ("red", "blue"))
    assert count == MAX_REPRESENTED
    assert len(nodes.update("red", ["/n1"])) == 149
    assert len(nodes.update("green", ["/a"])) == 1
