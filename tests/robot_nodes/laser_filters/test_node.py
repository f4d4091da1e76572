"""The node through its topics.

Feature: laser scans pass through the filters of laser_filters
"""

from __future__ import annotations

import math
from collections.abc import Callable
from queue import Queue
from typing import Any

import numpy as np
import pytest

from pyros1.msgs.geometry_msgs.msg import TransformStamped
from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.msgs.std_msgs.msg import Header
from pyros1.msgs.tf2_msgs.msg import TFMessage
from pyros1.node import Node
from pyros1.robot_nodes.laser_filters.node import FilterChain
from pyros1.robot_nodes.laser_filters.scans import FilterError

from ..logs import wait_for_line

PATIENCE = 20.0
BOX = {"box_frame": "base_link", "min_x": -0.6, "max_x": 0.13, "min_y": -0.2, "max_y": 0.2}


def test_a_scan_waits_for_the_transform_of_a_box(
    make_node: Callable[..., Node], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("pyros1.robot_nodes.laser_filters.node.MAX_WAIT", PATIENCE)
    user = make_node("user")
    user.params["/laser_filter/scan_filter_chain"] = [
        {"name": "box", "type": "laser_filters/LaserScanBoxFilter", "params": BOX}
    ]
    words = ["scan:=/front_laser/scan", "scan_filtered:=/front_laser/filtered_scan"]
    running = FilterChain(make_node("laser_filter", argv=words))
    scans: Queue[Any] = Queue()
    subscriber = user.subscribe("/front_laser/filtered_scan", LaserScan, scans.put)
    publisher = user.advertise("/front_laser/scan", LaserScan)
    assert publisher.wait_for_subscribers(1, PATIENCE) and subscriber.wait_for_publishers(1, PATIENCE)
    transforms = user.advertise("/tf", TFMessage)
    assert transforms.wait_for_subscribers(1, PATIENCE)
    transform: Any = TransformStamped(header=Header(frame_id="base_link", stamp=user.now()), child_frame_id="laser")
    transform.transform.translation.x = -0.3
    transform.transform.rotation.w = 1.0
    header = Header(frame_id="laser", stamp=transform.header.stamp)
    ranges = [0.4, 1.0, 0.25]
    scan = LaserScan(header=header, angle_increment=math.pi / 4, range_min=0.1, range_max=9.0, ranges=ranges)
    publisher.publish(scan)
    transforms.publish(TFMessage([transform]))
    found = scans.get(timeout=PATIENCE)
    np.testing.assert_array_equal(found.ranges, np.array([math.nan, 1.0, 0.25], np.float32))
    assert (found.header.frame_id, found.header.stamp) == ("laser", header.stamp)
    del running


def test_a_scan_without_a_transform_is_dropped(
    make_node: Callable[..., Node], capfd: pytest.CaptureFixture[str]
) -> None:
    user = make_node("user")
    user.params["/chain/scan_filter_chain"] = [{"name": "speckles", "type": "LaserScanSpeckleFilter"}]
    running = FilterChain(make_node("chain"))
    scans: Queue[Any] = Queue()
    subscriber = user.subscribe("/scan_filtered", LaserScan, scans.put)
    publisher = user.advertise("/scan", LaserScan)
    assert publisher.wait_for_subscribers(1, PATIENCE) and subscriber.wait_for_publishers(1, PATIENCE)
    publisher.publish(LaserScan(ranges=[1.0]))
    publisher.publish(LaserScan(ranges=[1.0] * 9))
    assert scans.get(timeout=PATIENCE).ranges == (1.0,) * 9
    wait_for_line(capfd, "a scan is dropped: a scan with 1 rays is too small")
    del running


def test_a_chain_with_a_mistake_does_not_start(make_node: Callable[..., Node]) -> None:
    node = make_node("chain")
    node.params["~filter_chain"] = [{"name": "box", "type": "Unknown"}]
    with pytest.raises(FilterError, match=r"/chain/filter_chain\[0\] \(box\): there is no filter Unknown"):
        FilterChain(node)


def test_a_scan_that_no_message_can_hold_after_the_filter_is_dropped(
    make_node: Callable[..., Node], capfd: pytest.CaptureFixture[str]
) -> None:
    user = make_node("user")
    bounds = {"lower_angle": 0.5, "upper_angle": 3.0}
    user.params["/chain/scan_filter_chain"] = [{"type": "LaserScanAngularBoundsFilter", "params": bounds}]
    running = FilterChain(make_node("chain"))
    scans: Queue[Any] = Queue()
    subscriber = user.subscribe("/scan_filtered", LaserScan, scans.put)
    publisher = user.advertise("/scan", LaserScan)
    assert publisher.wait_for_subscribers(1, PATIENCE) and subscriber.wait_for_publishers(1, PATIENCE)
    publisher.publish(LaserScan(angle_increment=0.6, ranges=[1.0, 2.0]))
    assert len(scans.get(timeout=PATIENCE).ranges) == 1  # somebody receives them
    publisher.publish(LaserScan(angle_increment=1.0, time_increment=1e30, ranges=[1.0, 2.0]))
    wait_for_line(capfd, "a scan is dropped: /scan_filtered: field header.stamp")
    del running


def test_a_node_without_filters_says_so(make_node: Callable[..., Node], capfd: pytest.CaptureFixture[str]) -> None:
    FilterChain(make_node("chain"))
    wait_for_line(capfd, "the parameter /chain/scan_filter_chain is not set: scans are passed on as they are")
