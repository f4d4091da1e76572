"""Filters that are changed while they run.

Feature: the filters of laser_filters are changed by dynamic_reconfigure
"""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import closing
from queue import Queue
from typing import Any

import pytest

from pyros1.msgs.sensor_msgs.msg import LaserScan
from pyros1.node import Node
from pyros1.reconfigure import Client
from pyros1.robot_nodes.laser_filters.chain import FILTERS, make_chain
from pyros1.robot_nodes.laser_filters.node import FilterChain
from pyros1.robot_nodes.laser_filters.reconfiguration import PARAMETERS, serve_filters
from pyros1.robot_nodes.shared.parameters import PrivateParameters

from ..logs import wait_for_line

PATIENCE = 20.0
SQUARE = [[1, 1], [1, -1], [-1, -1], [-1, 1]]


def scan(*ranges: float) -> LaserScan:
    message = LaserScan(ranges=ranges, range_max=100.0, angle_increment=0.1)
    message.header.frame_id = "base"
    return message


def test_a_range_filter_is_changed_for_the_next_scan(make_node: Callable[..., Node]) -> None:
    user = make_node("user")
    params = {"upper_threshold": 5, "upper_replacement_value": math.inf}
    chain = [{"name": "limits", "type": "laser_filters/LaserScanRangeFilter", "params": params}]
    user.params["/chain"] = {"scan_filter_chain": chain, "limits": {"upper_threshold": 70.0, "lower_threshold": 2.0}}
    running = FilterChain(make_node("chain"))
    scans: Queue[Any] = Queue()
    subscriber = user.subscribe("/scan_filtered", LaserScan, lambda scan: scans.put(list(scan.ranges)))
    assert subscriber.wait_for_publishers(1, PATIENCE)
    publisher = user.advertise("/scan", LaserScan)
    assert publisher.wait_for_subscribers(1, PATIENCE)

    def filtered(*ranges: float) -> Any:
        publisher.publish(scan(*ranges))
        return scans.get(timeout=PATIENCE)

    assert filtered(1.0, 7.0) == [1.0, math.inf]
    with closing(Client(user, "chain/limits")) as client:
        assert client.config(PATIENCE)["upper_threshold"] == 5.0, "not what an earlier run has left"
        assert client.config(PATIENCE)["lower_threshold"] == 0.0, "which is what the filter uses"
        client.update({"upper_threshold": 8.0})
        assert filtered(1.0, 7.0, 9.0) == [1.0, 7.0, math.inf]
        client.update({"lower_threshold": 2.0, "lower_replacement_value": 0.5})
        assert filtered(1.0, 7.0) == [0.5, 7.0]
        client.update({"upper_replacement_value": 50.0})
        assert filtered(1.0, 7.0, 9.0) == [0.5, 7.0, 50.0]
    del running


def test_a_polygon_is_changed_unless_it_is_wrong(
    make_node: Callable[..., Node], capfd: pytest.CaptureFixture[str]
) -> None:
    user, node = make_node("user"), make_node("chain")
    params = {"polygon": SQUARE, "polygon_frame": "base"}
    chain = [{"name": "self", "type": "laser_filters/LaserScanPolygonFilter", "params": params}]
    filters: list[Any] = make_chain(chain, "~chain", pytest.fail)
    lines: list[str] = []
    servers = serve_filters(node, filters, chain, "/chain/scan_filter_chain", lines.append)

    def removed(*ranges: float) -> list[bool]:
        return [math.isnan(each) for each in filters[0].apply(scan(*ranges), pytest.fail).ranges]

    assert removed(0.5, 3.0) == [True, False]
    with closing(Client(user, "chain/self")) as client:
        assert client.config(PATIENCE)["polygon"] == str(SQUARE)
        client.update({"polygon": "[[4, 4], [4, -4], [-4, -4], [-4, 4]]"})
        assert removed(0.5, 3.0, 5.0) == [True, True, False] and not lines
        for wrong in ("[[1", "[[1, 2]]", "[]", "{}", "[" + "[1, 2], " * 9000 + "]"):
            client.update({"polygon": wrong})
            assert removed(0.5, 3.0, 5.0) == [True, True, False]
        assert (
            len(lines) == 5
            and "longer than" in lines[-1]
            and all("the filter is not changed" in line for line in lines)
        )
        assert client.config(PATIENCE)["polygon"].startswith("[[4, 4]")
        client.update({"invert": True})
        assert removed(0.5, 3.0, 5.0) == [False, False, True]
        client.update({"polygon": str(SQUARE)})
        assert removed(0.5, 3.0) == [False, True]
    assert len(servers) == 1


def test_all_that_can_be_changed_is_what_the_filters_read(make_node: Callable[..., Node]) -> None:
    """With the shown values, each filter is the one that it would be without them."""
    node = make_node("chain")
    for kind, entries in PARAMETERS.items():
        must = {"polygon": SQUARE, "polygon_frame": "base"} if "Polygon" in kind else {}
        asked: set[str] = set()

        class Recorder(dict):  # type: ignore[type-arg]
            def __contains__(self, key: object) -> bool:
                asked.add(str(key))  # noqa: B023
                return super().__contains__(key)

        FILTERS[kind](PrivateParameters(Recorder(must), pytest.fail, kind))
        assert {name for name, *_ in entries} <= asked, kind
    chain = [{"name": f"f{index}", "type": kind} for index, kind in enumerate(PARAMETERS) if "Polygon" not in kind]
    filters: list[Any] = make_chain(chain, "~chain", pytest.fail)
    assert len(serve_filters(node, filters, chain, "~chain", pytest.fail)) == len(chain) == 6


def test_filters_without_a_usable_name_work_but_cannot_be_changed(
    make_node: Callable[..., Node], capfd: pytest.CaptureFixture[str]
) -> None:
    node = make_node("chain")
    names: list[Any] = ["a b", None, "same", "same", 5]
    kind = "laser_filters/LaserScanRangeFilter"
    node.params["~scan_filter_chain"] = [{"name": name, "type": kind} for name in names if name is not None]
    FilterChain(node)
    wait_for_line(capfd, "scan_filter_chain[2] cannot be changed by dynamic_reconfigure")
