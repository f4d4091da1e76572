"""analyzer_loader: tests whether the analyzers in its private parameters can be used by aggregator_node."""

from __future__ import annotations

from functools import partial

from pyros1.node import Node
from pyros1.robot_nodes.diagnostic_aggregator.configuration import AnalyzerFactory
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.test_nodes.common import FailedError, Test


def tests(node: Node) -> dict[str, Test]:
    """Return the only test case, by name: it passes if there are analyzers, and all of them can be created.

    Args:
        node: the node; its parameter ~analyzers defines the analyzers.
    """
    return {"analyzerLoading": partial(_load, node)}


def _load(node: Node) -> None:
    problems: list[str] = []
    place = f"{node.name}/analyzers"
    analyzers = PrivateParameters.of(node).value("analyzers")
    group = AnalyzerFactory(problems.append).make_group("/", "", analyzers, place, node.now().to_sec())
    if group.problems or not group.analyzers:
        raise FailedError("; ".join(problems))
