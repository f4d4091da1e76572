"""complementary_filter_node: adds the orientation from a complementary filter to an IMU's messages.

See https://wiki.ros.org/imu_complementary_filter.
"""

from __future__ import annotations

from typing import Any

from pyros1.msgs.std_msgs.msg import Bool
from pyros1.node import Node
from pyros1.robot_nodes.imu_complementary_filter.complementary import ComplementaryFilter, Settings
from pyros1.robot_nodes.shared.imu_node import ImuFilterNode
from pyros1.robot_nodes.shared.imu_readings import Estimate, Reading
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node


class Complementary:
    """The node complementary_filter_node.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        parameters = PrivateParameters.of(node)
        settings = read_settings(parameters)
        debug = parameters.flag("publish_debug_topics", False)
        self._steady = None
        if debug and settings.do_bias_estimation:
            self._steady = node.advertise(f"{node.resolve('imu')}/steady_state", Bool, queue_size=5)
        self._running = ImuFilterNode(
            node,
            parameters,
            ComplementaryFilter(settings),
            use_mag=parameters.flag("use_mag", False),
            publish_tf=False,
            watch=self._publish_steady if debug else None,
        )

    def _publish_steady(self, header: Any, reading: Reading, estimate: Estimate) -> None:
        if self._steady is not None:
            self._steady.publish(Bool(estimate.steady))


def read_settings(parameters: PrivateParameters) -> Settings:
    """Read the filter's parameters."""
    return Settings(
        gain_acc=parameters.number("gain_acc", 0.01, 0.0, 1.0),
        gain_mag=parameters.number("gain_mag", 0.01, 0.0, 1.0),
        do_bias_estimation=parameters.flag("do_bias_estimation", True),
        bias_alpha=parameters.number("bias_alpha", 0.01, 0.0, 1.0),
        do_adaptive_gain=parameters.flag("do_adaptive_gain", True),
    )


def main(argv: list[str]) -> int:
    """Run complementary_filter_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "ComplementaryFilterROS", Complementary)
