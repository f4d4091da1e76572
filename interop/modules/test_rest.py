"""The rest of the names that stock's modules have: the programs print the same on stock's modules and on ours."""

from __future__ import annotations

from pathlib import Path

import faces
import pytest
from harness import Master

MASTERS = ("ours",)
PROGRAMS = Path(__file__).parent / "programs"


@pytest.mark.parametrize("name", ["node_names", "rospy_end", "rospy_node", "service_requests"])
def test_nodes(launcher: Master, name: str) -> None:
    assert faces.same(launcher, (PROGRAMS / f"{name}.py").read_text())


@pytest.mark.parametrize(
    "name",
    [
        "bag_tool",
        "definition_parts",
        "field_paths",
        "graph_parts",
        "home_names",
        "ros_packages",
        "rospy_pure",
        "roslib_old",
        "small",
    ],
)
def test_the_same_as_stock(master: Master, name: str) -> None:
    assert faces.same(master, (PROGRAMS / f"{name}.py").read_text(), ROS_ROOT="/usr/share/ros")
