"""Command lines and environments of nodes (X83, X84)."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from pyros1.finding.packages import OWN_PACKAGES, PackageIndex
from pyros1.ground.errors import LaunchError
from pyros1.launch.plan import NodePlan
from pyros1.launch.running.command_line import locate, node_environment, node_words

OWN = Path(OWN_PACKAGES) / "minimal_nodes" / "scripts" / "minimal_publisher"


def test_a_foreign_node_is_run_as_it_is() -> None:
    node = NodePlan("p", "t", "n", "/a/b/", ["x y", "z"], [("c", "d")], {"E": "1"}, ["nice", "-n", "5"])
    tool = Path("/usr/lib/p/t")
    assert node_words(node, tool) == ["nice", "-n", "5", "/usr/lib/p/t", "x y", "z", "c:=d", "__name:=n"]
    env = node_environment(node, tool, {"HOME": "/h", "ROS_NAMESPACE": "/other"}, "http://m:1/")
    assert env == {"HOME": "/h", "ROS_MASTER_URI": "http://m:1/", "ROS_NAMESPACE": "/a/b", "E": "1"}
    assert "ROS_NAMESPACE" not in node_environment(
        NodePlan("p", "t", "n"), tool, {"ROS_NAMESPACE": "/x"}, "http://m:1/"
    )


def test_our_own_python_node_runs_in_this_interpreter_and_finds_pyros1() -> None:
    packages = PackageIndex({})
    assert locate("minimal_nodes", "minimal_publisher", packages) == OWN
    node = NodePlan("minimal_nodes", "minimal_publisher", "n")
    assert node_words(node, OWN) == [sys.executable, str(OWN), "__name:=n"]
    env = node_environment(node, OWN, {"PYTHONPATH": "/mine"}, "http://m:1/")
    assert env["PYTHONPATH"].split(":")[-1] == "/mine"
    assert env["PYTHONUNBUFFERED"] == "1"


def test_what_cannot_be_located_x84() -> None:
    packages = PackageIndex({})
    with pytest.raises(LaunchError, match=r"Cannot locate node of type \[nope\] in package \[minimal_nodes\]"):
        locate("minimal_nodes", "nope", packages)
    with pytest.raises(LaunchError, match="no_such_package"):
        locate("no_such_package", "nope", packages)
