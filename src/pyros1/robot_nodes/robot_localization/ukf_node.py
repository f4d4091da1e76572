"""ukf_localization_node: ekf_localization_node with an unscented filter.

See https://docs.ros.org/en/noetic/api/robot_localization/html/state_estimation_nodes.html.
"""

from __future__ import annotations

import sys
from functools import partial

from pyros1.node import Node
from pyros1.robot_nodes.robot_localization.ekf_node import EkfNode
from pyros1.robot_nodes.robot_localization.ukf import Spread, Ukf
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node


def make_ukf_node(node: Node) -> EkfNode:
    """Start the topics, services and timer of ukf_localization_node on a node."""
    return EkfNode(node, partial(Ukf, spread=read_spread(PrivateParameters.of(node))))


def read_spread(parameters: PrivateParameters) -> Spread:
    """Read the parameters that ekf_localization_node does not have."""
    return Spread(
        alpha=parameters.number("alpha", Spread.alpha, 1e-6, 1000.0),
        kappa=parameters.number("kappa", Spread.kappa, -14.0, 1e6),
        beta=parameters.number("beta", Spread.beta, -1e6, 1e6),
    )


def main(argv: list[str]) -> int:
    """Run ukf_localization_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "ukf_localization_node", make_ukf_node)


if __name__ == "__main__":
    sys.exit(main(sys.argv))
