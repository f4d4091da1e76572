"""diagnostic_aggregator's aggregator_node beside stock's: the same analyzers, diagnostics and trees."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from harness import Master, until

from pyros1.ground.timing import Duration
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from pyros1.msgs.diagnostic_msgs.srv import AddDiagnostics
from pyros1.node import Node
from pyros1.robot_nodes.diagnostic_aggregator.added_analyzers import SERVICE
from pyros1.robot_nodes.diagnostic_aggregator.configuration import PACKAGE
from pyros1.robot_nodes.diagnostic_aggregator.node import AggregatorNode
from pyros1.robot_nodes.shared.bond_link import BondLink

OWN_MASTER = True
MASTERS = ("ours",)  # stock's node and ours are compared, whatever the master

STOCK = Path("/usr/lib/diagnostic_aggregator/aggregator_node")
PR2 = Path("/usr/share/diagnostic_aggregator/demo/pr2_analyzers.yaml")

pytestmark = [
    pytest.mark.ours_only,
    pytest.mark.skipif(
        not (STOCK.exists() and PR2.exists()),
        reason="libdiagnostic-aggregator-tools or -dev is not installed; run interop/setup",
    ),
]

SHORT = 0.4
"""The timeout, in seconds, of analyzers whose items become stale during the test."""
WORDS = ["imu_node", "left motor", "EtherCAT", "Joint", "HD Temp", "a/b", "CPU", ":", "", "base_hokuyo_node"]
NAMES = [
    *(f"{word}{between}{what}" for word in WORDS for between in (": ", "/", " ") for what in ("x", "Frequency/ok")),
    *["/a/b:c", "a", "IBPS 0", "Smart Battery 0.1", "Power board 1", " lead", "base_hokuyo_node:: x", "CPU Usage"],
]
PATHS = ["Part", "Front/Part", "/P/", "", "/"]
"""They do not contain what is removed from names: there stock searches paths, too, so summaries lose their names."""
ROBOT = """
pub_rate: 20.0
base_path: ''
analyzers:
  computer:
    type: AnalyzerGroup
    path: Computer
    analyzers:
      cpu: {type: GenericAnalyzer, path: CPU, startswith: CPU, timeout: 60}
      disk: {type: diagnostic_aggregator/GenericAnalyzer, path: Disk, contains: [Temp, Usage], num_items: 2}
  drivers:
    type: diagnostic_aggregator/GenericAnalyzer
    path: Drivers
    find_and_remove_prefix: [imu_node, base_hokuyo_node]
    remove_prefix: 'x'
    expected: ['left motor: x', missing one]
  others: {type: diagnostic_aggregator/DiscardAnalyzer, path: none, regex: 'Joint.*'}
  unused: {type: diagnostic_aggregator/IgnoreAnalyzer, contains: [Smart]}
"""


def random_analyzers(chance: random.Random, depth: int = 0) -> dict[str, Any]:
    return {
        f"{chance.choice('abcAB01')}{index}": random_analyzer(chance, depth) for index in range(chance.randint(1, 4))
    }


def random_analyzer(chance: random.Random, depth: int) -> dict[str, Any]:
    kind = chance.choice(
        ["GenericAnalyzer"] * 7 + ["AnalyzerGroup"] * 3 + ["DiscardAnalyzer", "IgnoreAnalyzer", "None"]
    )
    out: dict[str, Any] = {"type": f"diagnostic_aggregator/{kind}", "path": chance.choice(PATHS)}
    if kind == "AnalyzerGroup":
        if chance.random() < 0.2:
            del out["path"]
        out["analyzers"] = random_analyzers(chance, depth + 1) if depth < 3 else {}
        return out

    def some(source: list[str]) -> Any:
        return chance.choice(source) if chance.random() < 0.5 else chance.sample(source, chance.randint(0, 3))

    if chance.random() < 0.2:
        out["regex"] = some([r".*node.*", r"[a-z]+", r"(CPU|HD) \w+", r"((", r"\d|.*/x$"])
    for name, source in (
        ("find_and_remove_prefix", WORDS),
        ("startswith", WORDS),
        ("contains", WORDS),
        ("name", NAMES),
        ("remove_prefix", WORDS),
        ("expected", NAMES),
    ):
        if chance.random() < 0.35:
            out[name] = some(source)
    out["timeout"] = chance.choice([SHORT, SHORT, 60, 60.0, -1, 0, "long"])
    out["discard_stale"] = out["timeout"] == SHORT and chance.random() < 0.5
    out["num_items"] = chance.choice([None, None, -1, 0, 1, 3, "2"])
    for name in ("path", "contains"):  # not the type: stock ends if that is not a string
        if chance.random() < 0.05:
            out[name] = chance.choice([5, None, [1]])
    return {name: value for name, value in out.items() if value is not None}


def configurations() -> list[dict[str, Any]]:
    found = [yaml.safe_load(ROBOT), {"pub_rate": 20, **yaml.safe_load(PR2.read_text())}, {"base_path": "alone"}]
    for seed in range(10):
        chance = random.Random(seed)
        found.append(
            {
                "base_path": chance.choice(["", "robot", "/r", "/", "/r/", "a/b"]),
                "other_as_errors": chance.random() < 0.3,
                "analyzers": random_analyzers(chance),
            }
        )
    return [{**each, "pub_rate": 20.0} for each in found]


class Latest:
    """The latest tree, and the status that sums it up, of one node."""

    def __init__(self, node: Node, name: str) -> None:
        self.tree: list[Any] = []
        self.stamp: Any = None
        self.state: Any = None
        node.subscribe(f"/{name}/tree", DiagnosticArray, self._on_tree)
        node.subscribe(f"/{name}/state", DiagnosticStatus, self._on_state)

    def _on_tree(self, message: Any) -> None:
        self.tree, self.stamp = message.status, message.header.stamp

    def _on_state(self, message: Any) -> None:
        self.state = message

    @property
    def shown(self) -> tuple[list[Any], Any]:
        return self.tree, self.state


def remappings(name: str) -> list[str]:
    return [
        f"__name:={name}",
        f"/diagnostics_agg:=/{name}/tree",
        f"/diagnostics_toplevel_state:=/{name}/state",
    ]


@pytest.fixture
def make_node(launcher: Master) -> Iterator[Callable[..., Node]]:
    nodes: list[Node] = []

    def make(name: str, *words: str) -> Node:
        environ = launcher.environ("ours")
        nodes.append(Node(name, argv=list(words), environ=environ, handle_signals=False))
        return nodes[-1]

    yield make
    for node in nodes:
        node.shutdown()


def random_statuses(chance: random.Random, number: int) -> list[DiagnosticStatus]:
    out = []
    for name in chance.sample(NAMES, 25):
        level = chance.choice([0, 0, 0, 1, 2, 3, 3, 7, -2])
        values = [KeyValue(chance.choice(NAMES), str(index)) for index in range(chance.randrange(3))]
        text = chance.choice(["", "fine", "line\nline", "ä"])
        out.append(DiagnosticStatus(level=level, name=name, message=text, hardware_id=str(number), values=values))
    chance.shuffle(out)
    return out


def test_the_same_trees(launcher: Master, make_node: Callable[..., Node]) -> None:
    """Feature: diagnostics of a robot as a tree (diagnostic_aggregator), with the analyzers of its yaml files"""
    user = make_node("user")
    pairs: list[tuple[int, Latest, Latest]] = []
    running = []
    for number, parameters in enumerate(configurations()):
        names = [f"{whose}{number}" for whose in ("stock", "ours")]
        for name in names:
            user.params[f"/{name}"] = parameters
        launcher.run([str(STOCK), *remappings(names[0])], label=names[0])
        running.append(AggregatorNode(make_node(names[1], *remappings(names[1]))))
        pairs.append((number, Latest(user, names[0]), Latest(user, names[1])))
    publisher = user.advertise("/diagnostics", DiagnosticArray, queue_size=10)
    assert publisher.wait_for_subscribers(2 * len(pairs), 30.0)
    for number in range(4):
        chance = random.Random(number)
        message = DiagnosticArray(status=random_statuses(chance, number))
        message.header.stamp = user.now()
        publisher.publish(message)
        settle(pairs, user.now() + Duration(0.1))
    settle(pairs, user.now() + Duration(3 * SHORT))  # the time in which items become stale
    assert any(status.level == 3 and status.hardware_id for _, stock, _ in pairs for status in stock.tree)


def test_analyzers_that_a_node_adds(launcher: Master, make_node: Callable[..., Node]) -> None:
    """Feature: analyzers added to a running diagnostic_aggregator by a node with a bond"""
    user = make_node("user")
    extra = {"b": {"type": f"{PACKAGE}/GenericAnalyzer", "path": "B", "contains": ["CPU", "imu"]}}
    first = {"a": {"type": f"{PACKAGE}/GenericAnalyzer", "path": "A", "contains": "node"}}
    for number, base_path in enumerate(["", "robot"]):
        names = [f"{whose}_{number}" for whose in ("stock", "ours")]
        for name in names:
            user.params[f"/{name}"] = {"base_path": base_path, "pub_rate": 20.0, "analyzers": first}
        words = [[*remappings(name), f"{SERVICE}:=/{name}/add"] for name in names]
        launcher.run([str(STOCK), *words[0]], label=names[0])
        AggregatorNode(make_node(names[1], *words[1]))
        latest = [Latest(user, name) for name in names]
        pairs = [(number, latest[0], latest[1])]
        links = []
        for name in names:
            service = user.service(f"/{name}/add", AddDiagnostics)
            user.wait_for_service(f"/{name}/add", 30.0)
            namespace = f"/extra_{name}"
            user.params[namespace] = {"analyzers": extra}
            user.params[f"/bad_{name}"] = {"analyzers": {**extra, "c": {"type": f"{PACKAGE}/GenericAnalyzer"}}}
            answers = [service(each) for each in ("extra", f"/none_{name}", f"/bad_{name}", namespace, namespace)]
            assert [answer.success for answer in answers] == [False, False, False, True, False], name
            links.append(BondLink(user, f"/diagnostics_agg/bond{namespace}", namespace, lambda: None, lambda: None))
        path = f"/{base_path}/B".replace("//", "/")
        for each in latest:
            until(lambda: path in [status.name for status in each.tree], "its analyzers are there")  # noqa: B023
        publisher = user.advertise("/diagnostics", DiagnosticArray, queue_size=10)
        assert publisher.wait_for_subscribers(2 * (number + 1), 30.0)
        publisher.publish(DiagnosticArray(status=random_statuses(random.Random(1), 1)))
        settle(pairs, user.now() + Duration(0.2))
        for link in links:
            link.close()
        for each in latest:
            until(lambda: path not in [status.name for status in each.tree], "they are gone")  # noqa: B023
        settle(pairs, user.now() + Duration(0.2))


def settle(pairs: list[tuple[int, Latest, Latest]], time: Any) -> None:
    """Wait until a time has passed, and both nodes of each pair say the same."""
    for number, stock, ours in pairs:
        until(lambda: stock.stamp > time and ours.stamp > time, "they are published periodically")  # noqa: B023
        try:
            until(lambda: stock.shown == ours.shown, "they are equal", timeout=10.0)  # noqa: B023
        except AssertionError:
            assert (number, ours.state) == (number, stock.state)
            for mine, theirs in zip(ours.tree, stock.tree, strict=True):
                assert (number, mine) == (number, theirs)
