"""scan_to_scan_filter_chain: passes laser scans through a chain of filters (https://wiki.ros.org/laser_filters)."""

from __future__ import annotations

from contextlib import suppress
from functools import partial
from typing import Any

from pyros1.ground.errors import MessageError, NodeShutdownError
from pyros1.ground.terminal_text import one_line
from pyros1.ground.timing import Duration
from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.node import Node
from pyros1.robot_nodes.laser_filters.chain import apply_chain, make_chain
from pyros1.robot_nodes.laser_filters.reconfiguration import serve_filters
from pyros1.robot_nodes.laser_filters.scans import FilterError, Matrix
from pyros1.robot_nodes.laser_filters.shape_filters import ShapeFilter
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.robot_nodes.shared.transforms import lookup_matrix
from pyros1.tf import Buffer, TransformException, TransformListener

MAX_WAIT = 1.0
"""Maximum number of seconds to wait for the transform of a scan."""
_INPUT_QUEUE_SIZE = 50
_OUTPUT_QUEUE_SIZE = 1000


class FilterChain:
    """Filters ``scan`` and publishes ``scan_filtered``; other nodes can change the filters (see `FilterServer`).

    Args:
        node: the node.

    Raises:
        FilterError: a filter cannot be created.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        parameters = PrivateParameters.of(node)
        name = "filter_chain" if parameters.value("filter_chain") is not None else "scan_filter_chain"
        if name == "filter_chain":
            node.log.warn("the parameter ~filter_chain is deprecated: use ~scan_filter_chain")
        if parameters.value(name) is None:  # as in stock ROS, but with a warning
            node.log.warn("the parameter %s/%s is not set: scans are passed on as they are", node.name, name)
        report = partial(node.log.error, "%s")
        self._filters = make_chain(parameters.value(name), f"{node.name}/{name}", report)
        self._servers = serve_filters(node, self._filters, parameters.value(name), f"{node.name}/{name}", report)
        self._frame = parameters.text("tf_message_filter_target_frame", "").lstrip("/")
        self._tolerance = Duration(parameters.number("tf_message_filter_tolerance", 0.03, 0.0))
        self._buffer = Buffer()
        if self._frame or any(isinstance(each, ShapeFilter) for each in self._filters):
            self._listener = TransformListener(node, self._buffer)
        self._publisher = node.advertise("scan_filtered", LaserScan, queue_size=_OUTPUT_QUEUE_SIZE)
        node.subscribe("scan", LaserScan, self._receive, queue_size=_INPUT_QUEUE_SIZE, arrays="numpy")

    def _receive(self, scan: Any) -> None:
        header = scan.header

        def matrix_to(frame: str) -> Matrix:
            return lookup_matrix(self._buffer, frame, header.frame_id, header.stamp, MAX_WAIT)

        with suppress(NodeShutdownError):
            try:
                if self._frame:  # the scan waits until it can be transformed
                    end = header.stamp + self._tolerance
                    lookup_matrix(self._buffer, self._frame, header.frame_id, end, MAX_WAIT)
                self._publisher.publish(apply_chain(self._filters, scan, matrix_to))
            except (FilterError, MessageError, TransformException) as error:
                self._node.log.error("a scan is dropped: %s", one_line(str(error), 300), throttle=1)


def main(argv: list[str]) -> int:
    """Run scan_to_scan_filter_chain; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "scan_to_scan_filter_chain", FilterChain)
