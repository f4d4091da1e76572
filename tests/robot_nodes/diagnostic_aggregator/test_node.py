"""The node through its topics.

Feature: the diagnostics of a robot as a tree (diagnostic_aggregator)
"""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from typing import Any

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from pyros1.node import Node
from pyros1.robot_nodes.diagnostic_aggregator.node import AggregatorNode

PATIENCE = 20.0


def test_diagnostics_become_a_tree(make_node: Callable[..., Node]) -> None:
    user = make_node("user")
    analyzers = {"imu": {"type": "GenericAnalyzer", "path": "IMU", "find_and_remove_prefix": "imu_node"}}
    user.params["/robot/aggregator"] = {"base_path": "robot", "pub_rate": 50.0, "analyzers": analyzers}
    node = make_node("aggregator", argv=["__ns:=/robot"])
    running = AggregatorNode(node)
    trees: Queue[Any] = Queue()
    states: Queue[Any] = Queue()
    user.subscribe("/diagnostics_agg", DiagnosticArray, trees.put)
    user.subscribe("/diagnostics_toplevel_state", DiagnosticStatus, states.put)
    publisher = user.advertise("/diagnostics", DiagnosticArray)
    assert publisher.wait_for_subscribers(1, PATIENCE)
    publisher.publish(DiagnosticArray(status=[DiagnosticStatus(name="imu_node: rate", level=1)]))
    while len((tree := trees.get(timeout=PATIENCE)).status) < 3:
        assert [(each.name, each.level) for each in tree.status] == [("/robot/IMU", 3), ("/robot", 3)]
    assert [(each.name, each.level) for each in tree.status] == [
        ("/robot/IMU", 1),
        ("/robot/IMU/rate", 1),
        ("/robot", 1),
    ]
    assert tree.header.stamp.secs > 0
    while (state := states.get(timeout=PATIENCE)).level == 3:
        pass
    assert (state.name, state.level) == ("toplevel_state", 1)
    del running
