"""Analyzers that come and go.

Feature: analyzers added to a running diagnostic_aggregator -- `pyros1 run diagnostic_aggregator add_analyzers FILE`
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from pathlib import Path
from queue import Queue
from typing import Any
from xmlrpc.client import ServerProxy

import pytest

from pyros1.ground.errors import SettingError, WaitTimeoutError
from pyros1.msgs.bond.msg import Status
from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray
from pyros1.msgs.diagnostic_msgs.srv import AddDiagnostics
from pyros1.node import Node
from pyros1.robot_nodes.diagnostic_aggregator.add_analyzers import add_analyzers
from pyros1.robot_nodes.diagnostic_aggregator.added_analyzers import BOND_TOPIC, SERVICE
from pyros1.robot_nodes.diagnostic_aggregator.node import AggregatorNode

PATIENCE = 20.0
IMU = {"imu": {"type": "GenericAnalyzer", "path": "IMU", "contains": "imu"}}
ARM = "analyzers: {arm: {type: GenericAnalyzer, path: Arm, contains: arm}}"


@pytest.fixture
def aggregator(make_node: Callable[..., Node]) -> Node:
    user = make_node("user")
    user.params["/aggregator"] = {"pub_rate": 50.0, "analyzers": IMU}
    node = make_node("aggregator")
    AggregatorNode(node)
    return node


def test_analyzers_come_with_a_node_and_go_with_it(
    aggregator: Node, make_node: Callable[..., Node], tmp_path: Path
) -> None:
    trees: Queue[set[str]] = Queue()
    user = make_node("viewer")
    user.subscribe("/diagnostics_agg", DiagnosticArray, lambda tree: trees.put({each.name for each in tree.status}))
    file = tmp_path / "arm.yaml"
    file.write_text(ARM)
    arm = make_node("arm")
    adding = threading.Thread(target=add_analyzers, args=(arm, str(file), PATIENCE), name="adding")
    adding.start()
    while "/Arm" not in (names := trees.get(timeout=PATIENCE)):
        assert "/IMU" in names
    answer = user.service(SERVICE, AddDiagnostics)("/arm")
    assert not answer.success and answer.message == "Requested load from namespace /arm which is already in use"
    arm.shutdown()
    adding.join(PATIENCE)
    assert not adding.is_alive()
    while "/Arm" in (names := trees.get(timeout=PATIENCE)):
        pass
    assert "/IMU" in names


def hears(listener: Node, talker: Node, topic: str) -> bool:
    """Return whether a node has received a message of another one on a topic."""
    with ServerProxy(listener.uri) as proxy:
        slave: Any = proxy
        connections, statistics = slave.getBusInfo("/test")[2], slave.getBusStats("/test")[2][1]
    publishers = [uri for _, uri, way, _, name, *_ in connections if (way, name) == ("i", topic)]
    links = dict(statistics).get(topic, [])
    return any(uri == talker.uri and link[2] > 0 for uri, link in zip(publishers, links, strict=False))


@pytest.mark.slow
def test_a_bond_breaks_with_the_aggregator(aggregator: Node, make_node: Callable[..., Node], tmp_path: Path) -> None:
    errors: Queue[str] = Queue()
    arm = make_node("arm")
    (tmp_path / "arm.yaml").write_text(ARM)

    def add() -> None:
        with pytest.raises(SettingError) as found:
            add_analyzers(arm, str(tmp_path / "arm.yaml"), PATIENCE)
        errors.put(str(found.value))

    formed: Queue[str] = Queue()
    make_node("listener").subscribe("/rosout", "rosgraph_msgs/Log", lambda line: formed.put(line.msg))
    adding = threading.Thread(target=add, name="adding")
    adding.start()
    while "added the analyzers of /arm" not in formed.get(timeout=PATIENCE):
        pass
    deadline = time.monotonic() + PATIENCE
    while not hears(arm, aggregator, f"{BOND_TOPIC}/arm"):  # before, it goes on waiting for its aggregator
        assert time.monotonic() < deadline
    aggregator.shutdown()
    assert "the bond with aggregator_node is broken" in errors.get(timeout=PATIENCE)
    adding.join(PATIENCE)


@pytest.mark.slow
def test_the_aggregator_waits_for_all_silent_nodes_at_once(aggregator: Node, make_node: Callable[..., Node]) -> None:
    user, formed = make_node("user2"), threading.Semaphore(0)
    namespaces = [f"/silent{number}" for number in range(9)]

    def listen(line: Any) -> None:
        if "added the analyzers of /silent" in line.msg:
            formed.release()

    user.subscribe("/rosout", "rosgraph_msgs/Log", listen)
    for namespace in namespaces:
        user.params[f"{namespace}/analyzers"] = IMU
        user.advertise(f"{BOND_TOPIC}{namespace}", Status, latch=True).publish(
            id=namespace, instance_id="silent", active=True
        )
        assert user.service(SERVICE, AddDiagnostics)(namespace).success
    assert all(formed.acquire(timeout=PATIENCE) for _ in namespaces)
    begin = time.monotonic()
    aggregator.shutdown()
    assert time.monotonic() - begin < 3.5


@pytest.mark.parametrize(
    ("namespace", "message"),
    [
        ("arm", "Requested load from non-global namespace"),
        ("", "Requested load from non-global namespace"),
        ("/none", "Load the analyzers to the parameter /none/analyzers."),
        ("/bad", "Not all of /bad/analyzers can be used: see the log of /aggregator."),
        ("/a b//~c", "Failed to initialise AnalyzerGroup."),
    ],
)
def test_what_cannot_be_added(
    namespace: str, message: str, aggregator: Node, capfd: pytest.CaptureFixture[str]
) -> None:
    aggregator.params["/bad/analyzers"] = {**IMU, "x": {"type": "GenericAnalyzer"}}
    for _ in range(2):
        answer = aggregator.service(SERVICE, AddDiagnostics)(namespace)
        assert not answer.success and message in answer.message
    aggregator.shutdown()
    assert "Traceback" not in capfd.readouterr().err


def test_files_that_cannot_be_loaded(make_node: Callable[..., Node], tmp_path: Path) -> None:
    node = make_node("arm")
    (tmp_path / "list.yaml").write_text("[1, 2]")
    for path, message in ((tmp_path / "none", "No such file"), (tmp_path / "list.yaml", "must contain parameters")):
        with pytest.raises(SettingError, match=message):
            add_analyzers(node, str(path), 1.0)
    with pytest.raises(WaitTimeoutError):
        add_analyzers(node, None, 0.05)
