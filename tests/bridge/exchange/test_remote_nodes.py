"""Which nodes of other sites are represented here, and under which names."""

from __future__ import annotations

from collections import Counter

from pyros1.bridge.exchange.actions import Log, RepresentNode
from pyros1.bridge.exchange.limits import Limits
from pyros1.bridge.exchange.remote_nodes import MAX_REPRESENTED, RemoteNodes
from pyros1.bridge.protocol.packets import MAX_NODES
from pyros1.bridge.rules.parsing import parse_config

LONG = "/" + "a" * 254


class Nodes:
    """The nodes of other sites, each site with its own limits. All times are the same unless a test changes them."""

    def __init__(self, text: str = "") -> None:
        self.nodes = RemoteNodes(parse_config(text, "f", "base").rules)
        self.now = 0.0
        self.warnings: list[str] = []
        self._limits = Limits()

    def update(self, site: str, names: list[str]) -> list[RepresentNode]:
        actions = self.nodes.update(site, names, self._limits.of(site, ()).nodes, self.now)
        self.warnings += [action.text for action in actions if isinstance(action, Log) and action.is_warning]
        return [action for action in actions if isinstance(action, RepresentNode)]


def many(count: int, first: int = 0) -> list[str]:
    return [f"/n{number:03}" for number in range(first, first + count)]


def test_nodes_come_and_go() -> None:
    each = Nodes()
    assert each.update("red", ["/talker"]) == [RepresentNode("/red/talker", "red", "/talker")]
    assert each.update("red", ["/talker"]) == []
    assert each.update("red", ["/other"]) == [
        RepresentNode("/red/talker", "", ""),
        RepresentNode("/red/other", "red", "/other"),
    ]
    assert each.nodes.names("red") == ["/red/other"]
    assert each.nodes.drop("red") == [RepresentNode("/red/other", "", "")]
    assert each.nodes.drop("red") == [] and each.nodes.names("red") == []


def test_names_are_always_below_that_of_the_site() -> None:
    each = Nodes("prefix: {red: /, blue: /robots/blue}")
    (red,) = each.update("red", ["/bridge_base"])
    assert red == RepresentNode("/red/bridge_base", "red", "/bridge_base")  # and not the bridge itself
    (blue,) = each.update("blue", ["/talker"])
    assert blue == RepresentNode("/robots/blue/talker", "blue", "/talker")


def test_two_sites_with_one_name_here() -> None:
    each = Nodes("prefix: {'*': /robots}")
    assert each.update("red", ["/talker"])
    assert each.update("blue", ["/talker"]) == [], "the first one keeps the name"
    each.nodes.drop("red")
    assert each.update("blue", ["/talker"]) == [RepresentNode("/robots/talker", "blue", "/talker")]


def test_nodes_that_are_not_represented_are_reported_once() -> None:
    each = Nodes()
    told = "some nodes of site red cannot be watched here: "
    told += "there are too many, they change too often, or their names here are taken or too long"
    assert each.update("red", ["/talker"]) and each.warnings == []
    for _ in range(2):
        assert each.update("red", [LONG, "/talker"]) == [] and each.warnings == [told]
    each.update("red", ["/talker"])
    each.update("red", [LONG, "/talker"])
    each.nodes.drop("red")
    each.update("red", [LONG, "/talker"])
    assert each.warnings == [told] * 3


def test_sites_with_many_nodes_leave_room_for_others() -> None:
    each = Nodes()
    for site in ("blue", "green"):
        assert len(each.update(site, many(MAX_NODES))) == MAX_NODES
    assert each.update("red", ["/driver"]) == [
        RepresentNode("/blue/n099", "", ""),
        RepresentNode("/red/driver", "red", "/driver"),
    ], "the site with the most gives up its newest one"
    assert each.update("blue", many(MAX_NODES)) == [], "and does not get it back"
    each.now += 100
    each.nodes.drop("red")
    assert len(each.update("blue", many(MAX_NODES))) == 1, "until there is room again"


def test_all_sites_with_many_nodes_get_as_many() -> None:
    each = Nodes()
    sites = ["red", "green", "blue", "black", "white"]
    for _ in range(3):
        for site in sites:
            each.update(site, many(MAX_NODES))
    assert {len(each.nodes.names(site)) for site in sites} == {MAX_REPRESENTED // len(sites)}
    assert [each.update(site, many(MAX_NODES)) for site in sites] == [[]] * len(sites), "none lasts at others' expense"


def test_lists_that_change_all_the_time_start_few_nodes() -> None:
    each = Nodes()
    started: Counter[bool] = Counter()
    for turn in range(1000):
        actions = each.update("red", many(MAX_NODES, first=turn % 2 * MAX_NODES))
        started.update(bool(action.node) for action in actions)
        each.now += 0.1
    assert started[True] <= MAX_NODES + 100, "one per second after the first ones"
    assert len(each.update("blue", ["/driver"])) == 1, "other sites are not affected"
    each.update("red", [])
    assert each.nodes.names("red") == [], "those that are gone end at once"
