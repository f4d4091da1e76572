"""aggregator_node: publishes the diagnostics of a robot as a tree (https://wiki.ros.org/diagnostic_aggregator)."""

from __future__ import annotations

import threading
from functools import partial
from typing import Any

from pyros1.msgs.diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from pyros1.node import Node
from pyros1.robot_nodes.diagnostic_aggregator.added_analyzers import AddedAnalyzers
from pyros1.robot_nodes.diagnostic_aggregator.aggregator import Aggregator
from pyros1.robot_nodes.diagnostic_aggregator.configuration import AnalyzerFactory
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node

_INPUT_QUEUE_SIZE = 1000
_MIN_RATE, _MAX_RATE = 0.01, 1000.0


class AggregatorNode:
    """Receives /diagnostics, and publishes /diagnostics_agg and /diagnostics_toplevel_state.

    Other nodes can add analyzers with the service /diagnostics_agg/add_diagnostics; see `AddedAnalyzers`.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._lock = threading.Lock()  # guards the aggregator
        parameters = PrivateParameters.of(node)
        base_path = parameters.text("base_path", "")
        if base_path and not base_path.startswith("/"):
            base_path = f"/{base_path}"
        factory = AnalyzerFactory(partial(node.log.error, "%s"))
        now = node.now().to_sec()
        group = factory.make_group(base_path or "/", "", parameters.value("analyzers"), f"{node.name}/analyzers", now)
        self._aggregator = Aggregator(group, base_path, parameters.flag("other_as_errors", False), now)
        self._added_analyzers = AddedAnalyzers(node, self._lock, self._aggregator, factory, base_path or "/")
        self._tree_publisher = node.advertise("/diagnostics_agg", DiagnosticArray, queue_size=1)
        self._state_publisher = node.advertise("/diagnostics_toplevel_state", DiagnosticStatus, queue_size=1)
        node.subscribe("/diagnostics", DiagnosticArray, self._receive, queue_size=_INPUT_QUEUE_SIZE)
        self._timer = node.timer(1.0 / parameters.number("pub_rate", 1.0, _MIN_RATE, _MAX_RATE), self._publish)

    def _receive(self, message: Any) -> None:
        with self._lock:  # held while reading the time, so that no status appears to be from the future
            self._aggregator.receive(message.status, self._node.now().to_sec())

    def _publish(self, _: Any) -> None:
        with self._lock:
            now = self._node.now()
            statuses, state = self._aggregator.report(now.to_sec())
        message = DiagnosticArray(status=statuses)
        message.header.stamp = now
        self._tree_publisher.publish(message)
        self._state_publisher.publish(state)


def main(argv: list[str]) -> int:
    """Run aggregator_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "diagnostic_aggregator", AggregatorNode)
