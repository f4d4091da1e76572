"""Both nodes through their topics.

Feature: point clouds become laser scans, and laser scans point clouds (pointcloud_to_laserscan)
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from contextlib import suppress
from queue import Empty, Queue
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.sensor_msgs.msg import LaserScan, PointCloud2
from pyros1.msgs.std_msgs.msg import Header
from pyros1.node import Node
from pyros1.robot_nodes.pointcloud_to_laserscan.clouds import make_cloud, read_positions
from pyros1.robot_nodes.pointcloud_to_laserscan.node import start_cloud_to_scan, start_scan_to_cloud
from pyros1.tf import StaticTransformBroadcaster

from ..logs import wait_for_line

PATIENCE = 20.0


@pytest.fixture
def user(make_node: Callable[..., Node]) -> Node:
    """A node with a scanner one metre ahead of base_link, turned to the left."""
    node = make_node("user")
    transform: Any = TransformStamped(header=Header(frame_id="base_link"), child_frame_id="scanner")
    transform.transform.translation.x = 1.0
    transform.transform.rotation.z = transform.transform.rotation.w = math.sqrt(0.5)
    StaticTransformBroadcaster(node).send_transform(transform)
    return node


def first_output(user: Node, source: tuple[str, type[Any], Any], output: tuple[str, type[Any]]) -> Any:
    """Publish a message until there is an output, since a node that has just subscribed may not know frames yet."""
    outputs: Queue[Any] = Queue()
    publisher = user.advertise(source[0], source[1])
    assert not publisher.num_connections, "nobody has subscribed to the output yet"
    subscriber = user.subscribe(*output, outputs.put)
    assert publisher.wait_for_subscribers(1, PATIENCE)
    until = time.monotonic() + PATIENCE
    while time.monotonic() < until:
        publisher.publish(source[2])
        with suppress(Empty):
            found = outputs.get(timeout=2.0)
            subscriber.unregister()
            assert wait_until(lambda: not publisher.num_connections), "it goes on receiving"
            return found
    raise AssertionError("no output")


def wait_until(condition: Callable[[], bool]) -> bool:
    until = time.monotonic() + PATIENCE
    while not condition() and time.monotonic() < until:
        time.sleep(0.01)
    return condition()


def test_a_cloud_becomes_a_scan_in_the_target_frame(make_node: Callable[..., Node], user: Node) -> None:
    node = make_node(
        "pointcloud_to_laserscan",
        argv=[
            "cloud_in:=/velodyne_points",
            "scan:=/front/scan",
            "_target_frame:=/base_link",
            "_angle_max:=1.5",
            "_scan_time:=0.5",
        ],
    )
    running = start_cloud_to_scan(node)
    columns = {"x": [1.0, math.nan], "y": [0.0, 0.0], "z": [0.5, 0.5]}
    stamp = user.now()
    cloud = make_cloud(
        Header(frame_id="scanner", stamp=stamp),
        {name: np.array(values, np.float32) for name, values in columns.items()},
    )
    scan = first_output(user, ("/velodyne_points", PointCloud2, cloud), ("/front/scan", LaserScan))
    assert (scan.header.frame_id, scan.header.stamp) == ("base_link", stamp)
    assert (scan.angle_min, scan.angle_max) == pytest.approx((-math.pi, 1.5)) and scan.range_max == math.inf
    assert scan.scan_time == 0.5
    rays = np.flatnonzero(np.isfinite(scan.ranges))
    assert rays.tolist() == [int((math.pi + math.pi / 4) / scan.angle_increment)]
    assert scan.ranges[rays[0]] == pytest.approx(math.sqrt(2))
    del running


def test_a_scan_becomes_a_cloud(make_node: Callable[..., Node], user: Node) -> None:
    node = make_node("converter", argv=["_target_frame:=base_link"])
    running = start_scan_to_cloud(node)
    scan = LaserScan(
        header=Header(frame_id="scanner"), angle_increment=math.pi / 2, range_max=5.0, ranges=[2.0, 9.0, 1.0]
    )
    cloud = first_output(user, ("/scan_in", LaserScan, scan), ("/cloud", PointCloud2))
    assert cloud.header.frame_id == "base_link"
    np.testing.assert_allclose(read_positions(cloud), [[1, 2, 0], [1, -1, 0]], atol=1e-6)
    del running


def test_damaged_messages_are_ignored(
    make_node: Callable[..., Node], user: Node, capfd: pytest.CaptureFixture[str]
) -> None:
    node = make_node("converter")
    running = start_cloud_to_scan(node)
    scans: Queue[Any] = Queue()
    user.subscribe("/scan", LaserScan, scans.put)
    publisher = user.advertise("/cloud_in", PointCloud2)
    assert publisher.wait_for_subscribers(1, PATIENCE)
    publisher.publish(PointCloud2(width=7, height=1, point_step=4, row_step=28))
    wait_for_line(capfd, "cloud_in is ignored: 0 bytes are too few for 7 x 1 points")
    good = make_cloud(Header(frame_id="scanner"), {name: np.ones(1, np.float32) for name in "xyz"})
    publisher.publish(good)
    scan = scans.get(timeout=PATIENCE)
    assert scan.header.frame_id == "scanner" and np.nanmin(scan.ranges) == pytest.approx(math.sqrt(2))
    del running
