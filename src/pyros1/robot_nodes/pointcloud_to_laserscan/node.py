"""pointcloud_to_laserscan_node and laserscan_to_pointcloud_node (https://wiki.ros.org/pointcloud_to_laserscan).

Both subscribe to their input only while their output has subscribers.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pyros1.ground.errors import MessageError, NodeShutdownError
from pyros1.ground.terminal_text import one_line
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2
from pyros1.msgs.std_msgs.msg import Header
from pyros1.node import Node
from pyros1.robot_nodes.pointcloud_to_laserscan.clouds import make_cloud, read_positions
from pyros1.robot_nodes.pointcloud_to_laserscan.projection import project, read_settings, unproject
from pyros1.robot_nodes.shared.lazy import LazyInputs
from pyros1.robot_nodes.shared.parameters import PrivateParameters
from pyros1.robot_nodes.shared.program import run_node
from pyros1.robot_nodes.shared.transforms import lookup_matrix, transform_points
from pyros1.tf import Buffer, TransformException, TransformListener

_MAX_WAIT = 1.0
"""Maximum number of seconds to wait for the transform of a message. Stock waits until newer messages replace it."""
_MAX_QUEUE_SIZE = 100


class Converter:
    """Converts messages of one topic to messages of another, in a target frame if the node has one.

    Args:
        node: the node.
        parameters: the node's parameters.
        input_topic, input_type: the topic to subscribe to.
        output_topic, output_type: the topic to publish.
        queue_size: the number of messages that may wait.
        convert: called with a message, the header of the output, and the matrix that converts points to the target
            frame, or None; it returns the output.
    """

    def __init__(
        self,
        node: Node,
        parameters: PrivateParameters,
        input_topic: str,
        input_type: type[Any],
        output_topic: str,
        output_type: type[Any],
        queue_size: int,
        convert: Callable[[Any, Any, NDArray[np.float64] | None], Any],
    ) -> None:
        self._node = node
        self._input = input_topic, input_type
        self._queue_size = queue_size
        self._convert = convert
        self._target_frame = parameters.text("target_frame", "").lstrip("/")
        self._timeout = max(parameters.number("transform_tolerance", 0.01, 0.0), _MAX_WAIT)
        self._publisher = node.advertise(output_topic, output_type, queue_size=queue_size)
        self._lazy = LazyInputs([self._publisher], self._open)

    def _open(self) -> list[Callable[[], object]]:
        buffer = Buffer()
        listener = TransformListener(self._node, buffer) if self._target_frame else None
        subscriber = self._node.subscribe(
            *self._input, lambda message: self._receive(message, buffer), queue_size=self._queue_size, arrays="numpy"
        )
        return [subscriber.unregister] if listener is None else [subscriber.unregister, listener.close]

    def _receive(self, message: Any, buffer: Buffer) -> None:
        with suppress(NodeShutdownError):
            try:
                header, matrix = message.header, None
                if self._target_frame and self._target_frame != header.frame_id:
                    matrix = lookup_matrix(buffer, self._target_frame, header.frame_id, header.stamp, self._timeout)
                    header = Header(stamp=header.stamp, frame_id=self._target_frame)
                output = self._convert(message, header, matrix)
            except (TransformException, MessageError) as error:
                text = one_line(str(error), 300)
                self._node.log.warn("a message on %s is ignored: %s", self._input[0], text, throttle=10)
            else:
                self._publisher.publish(output)


def start_cloud_to_scan(node: Node) -> Converter:
    """Start pointcloud_to_laserscan_node, which converts ``cloud_in`` to ``scan``."""
    parameters = PrivateParameters.of(node)
    settings = read_settings(parameters)

    def convert(cloud: Any, header: Any, matrix: NDArray[np.float64] | None) -> LaserScan:
        positions = read_positions(cloud)
        return LaserScan(
            header=header,
            angle_min=settings.angle_min,
            angle_max=settings.angle_max,
            angle_increment=settings.angle_increment,
            scan_time=settings.scan_time,
            range_min=settings.range_min,
            range_max=_as_float32(settings.range_max),
            ranges=project(positions if matrix is None else transform_points(matrix, positions), settings),
        )

    queue_size = parameters.integer("concurrency_level", 1, 0, _MAX_QUEUE_SIZE) or 1
    return Converter(node, parameters, "cloud_in", PointCloud2, "scan", LaserScan, queue_size, convert)


def start_scan_to_cloud(node: Node) -> Converter:
    """Start laserscan_to_pointcloud_node, which converts ``scan_in`` to ``cloud``."""
    parameters = PrivateParameters.of(node)

    def convert(scan: Any, header: Any, matrix: NDArray[np.float64] | None) -> PointCloud2:
        columns = unproject(scan)
        if matrix is not None:
            positions = np.stack([columns[name] for name in "xyz"], axis=1).astype(np.float64)
            columns |= zip("xyz", transform_points(matrix, positions).T.astype(np.float32), strict=True)
        return make_cloud(header, columns)

    queue_size = parameters.integer("queue_size", 1, 0, _MAX_QUEUE_SIZE) or 1
    return Converter(node, parameters, "scan_in", LaserScan, "cloud", PointCloud2, queue_size, convert)


def _as_float32(number: float) -> float:
    """Convert a number to float32, as in a message; numbers that are too large become infinite."""
    with np.errstate(over="ignore"):
        return float(np.float32(number))


def cloud_to_scan(argv: list[str]) -> int:
    """Run pointcloud_to_laserscan_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "pointcloud_to_laserscan", start_cloud_to_scan)


def scan_to_cloud(argv: list[str]) -> int:
    """Run laserscan_to_pointcloud_node; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "laserscan_to_pointcloud", start_scan_to_cloud)
