"""The node through its topics.

Feature: depth images become laser scans (depthimage_to_laserscan)
"""

from __future__ import annotations

from collections.abc import Callable
from queue import Queue
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.sensor_msgs.msg import CameraInfo, Image, LaserScan
from pyros1.msgs.std_msgs.msg import Header
from pyros1.node import Node
from pyros1.reconfigure import Client
from pyros1.robot_nodes.depthimage_to_laserscan.node import DepthImageToLaserScan

from ..logs import wait_for_line

PATIENCE = 20.0


def test_a_scan_for_each_image_with_its_camera_info(
    make_node: Callable[..., Node], capfd: pytest.CaptureFixture[str]
) -> None:
    words = ["image:=/camera/depth/image_raw", "scan:=/scan", "_scan_height:=5", "_output_frame_id:=camera_frame"]
    running = DepthImageToLaserScan(make_node("depthimage_to_laserscan", argv=words))
    user = make_node("user")
    images = user.advertise("/camera/depth/image_raw", Image)
    infos = user.advertise("/camera/depth/camera_info", CameraInfo)
    assert not images.num_connections and not infos.num_connections, "nobody has subscribed to the scan yet"
    scans: Queue[Any] = Queue()
    user.subscribe("/scan", LaserScan, scans.put)
    assert images.wait_for_subscribers(1, PATIENCE) and infos.wait_for_subscribers(1, PATIENCE)
    depths = np.full((11, 21), 3000, np.uint16)
    depths[7, 10] = 1500
    depths[8, 10] = 1000  # below the five rows that count
    header = Header(frame_id="camera_optical_frame")
    info = CameraInfo(header=header, K=[20.0, 0, 10, 0, 20, 5, 0, 0, 1])
    image = Image(header=header, height=11, width=21, encoding="16UC1", step=42, data=depths.tobytes())

    def publish(encoding: str) -> None:
        header.stamp = user.now()
        image.encoding = encoding
        images.publish(image)
        infos.publish(info)

    publish("rgb8")
    wait_for_line(capfd, "a depth image is ignored: 'rgb8' is not the encoding")
    publish("16UC1")
    scan = scans.get(timeout=PATIENCE)
    assert (scan.header.frame_id, scan.header.stamp) == ("camera_frame", header.stamp)
    assert len(scan.ranges) == 21 and min(scan.ranges) == 1.5
    assert (scan.scan_time, scan.range_min, scan.range_max) == pytest.approx((0.033, 0.45, 10.0))
    Client(user, "/depthimage_to_laserscan", timeout=PATIENCE).update({"range_min": 2.0})
    publish("16UC1")
    scan = scans.get(timeout=PATIENCE)
    assert np.nanmin(scan.ranges) > 2.9
    del running
