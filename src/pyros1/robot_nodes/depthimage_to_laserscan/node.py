"""depthimage_to_laserscan: publishes the middle rows of depth images as laser scans.

See https://wiki.ros.org/depthimage_to_laserscan. It subscribes to images only while the scan has subscribers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from pyros1.filters import Filter, Synchronizer
from pyros1.ground.errors import MessageError
from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image, LaserScan
from pyros1.msgs.std_msgs.msg import Header
from pyros1.node import Node
from pyros1.node.subscribing.subscriber import Subscriber
from pyros1.reconfigure import Parameters, Server
from pyros1.robot_nodes.depthimage_to_laserscan.conversion import Camera, convert, read_depths
from pyros1.robot_nodes.shared.lazy import LazyInputs
from pyros1.robot_nodes.shared.program import run_node

_QUEUE_SIZE = 10


class DepthImageToLaserScan:
    """Converts ``image`` and its ``camera_info`` to ``scan``.

    The parameters can be changed with dynamic_reconfigure.

    Args:
        node: the node.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._config: Any = None
        self._server = Server(node, _make_parameters(), self._on_configured)
        self._publisher = node.advertise("scan", LaserScan, queue_size=_QUEUE_SIZE)
        self._lazy = LazyInputs([self._publisher], self._open)

    def _on_configured(self, config: Any, level: int) -> Any:
        self._config = config
        return config

    def _open(self) -> list[Callable[[], object]]:
        info_topic = self._node.resolve("image").rpartition("/")[0] + "/camera_info"
        inputs = [Filter(self._node), Filter(self._node)]
        Synchronizer(inputs, queue_size=_QUEUE_SIZE).connect(self._receive)
        subscribers: list[Subscriber[Any]] = [
            self._node.subscribe("image", Image, inputs[0].emit, queue_size=_QUEUE_SIZE, arrays="numpy"),
            self._node.subscribe(info_topic, CameraInfo, inputs[1].emit, queue_size=_QUEUE_SIZE),
        ]

        return [subscriber.unregister for subscriber in subscribers]

    def _receive(self, image: Any, info: Any) -> None:
        config = self._config
        try:
            depths, unit = read_depths(image)
            camera = Camera.of(info, image.width, image.height)
            ranges = convert(depths, unit, camera, config.scan_height, config.range_min, config.range_max)
        except MessageError as error:
            self._node.log.error("a depth image is ignored: %s", error, throttle=10)
            return
        first, last, step = camera.angles
        self._publisher.publish(
            LaserScan(
                header=Header(stamp=image.header.stamp, frame_id=config.output_frame_id or image.header.frame_id),
                angle_min=first,
                angle_max=last,
                angle_increment=step,
                scan_time=config.scan_time,
                range_min=config.range_min,
                range_max=config.range_max,
                ranges=ranges,
            )
        )


def _make_parameters() -> Parameters:
    parameters = Parameters()
    parameters.add("scan_height", 1, "number of rows that count", minimum=1, maximum=500)
    parameters.add("scan_time", 0.033, "time between scans in seconds", minimum=0.0, maximum=1.0)
    parameters.add("range_min", 0.45, "shortest range in metres", minimum=0.0, maximum=10.0)
    parameters.add("range_max", 10.0, "longest range in metres", minimum=0.0, maximum=10.0)
    parameters.add("output_frame_id", "camera_depth_frame", "frame of the scan; empty for that of the image")
    return parameters


def main(argv: list[str]) -> int:
    """Run depthimage_to_laserscan; return its exit code.

    Args:
        argv: the command line, with the program's name.
    """
    return run_node(argv, "depthimage_to_laserscan", DepthImageToLaserScan)
