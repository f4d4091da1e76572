"""The program nodelet, as launch files call it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from queue import Queue
from typing import Any

import pytest

import pyros1
from pyros1.cli import nodelet_program
from pyros1.finding.packages import OWN_PACKAGES
from pyros1.graph import Graph
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.node import Node

PATIENCE = 20.0
LAUNCH_FILE = """
<launch>
  <node pkg="nodelet" type="nodelet" name="unknown" args="load no_such_package/Thing camera_manager"/>
  <node pkg="nodelet" type="nodelet" name="camera_manager" args="manager"/>
  <node pkg="nodelet" type="nodelet" name="slow" args="load my_camera/NodeletThrottleImage camera_manager">
    <remap from="topic_in" to="/a"/>
    <remap from="topic_out" to="/slow"/>
  </node>
  <node pkg="nodelet" type="nodelet" name="forward" args="load topic_tools/RelayNodelet camera_manager /a /b --no-bond">
    <remap from="/b" to="/c"/>
  </node>
</launch>
"""


@pytest.mark.slow
def test_nodelets_of_a_launch_are_nodes(
    environ: dict[str, str], make_node: Callable[..., Node], tmp_path: Path
) -> None:
    """Feature: nodelets of launch files run as nodes, where their package has a node for them"""
    values: Queue[Any] = Queue()
    node = make_node("listener")
    node.subscribe("/c", Float64, values.put)
    node.advertise("/a", Float64, latch=True).publish(2.5)
    launch_file = tmp_path / "nodelets.launch"
    launch_file.write_text(LAUNCH_FILE)
    process = subprocess.Popen(
        [sys.executable, "-m", "pyros1", "launch", str(launch_file)],
        env={
            **os.environ,
            **environ,
            "ROS_PACKAGE_PATH": OWN_PACKAGES,
            "PYTHONPATH": str(Path(pyros1.__file__).parents[1]),
        },
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        assert values.get(timeout=PATIENCE).data == 2.5
        assert node.wait_for_message("/slow", Float64, PATIENCE).data == 2.5
        state = Graph(node.master).state()
        assert state.publishers["/c"] == ["/forward"]
        deadline = node.now().to_sec() + PATIENCE
        while "/camera_manager/list" not in state.services and node.now().to_sec() < deadline:
            state = Graph(node.master).state()
        assert state.services["/camera_manager/list"] == ["/camera_manager"]
    finally:
        process.terminate()
        process.wait(PATIENCE)


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (
            "load no_such_package/Thing manager __name:=x",
            "no package no_such_package for the nodelet no_such_package/Th",
        ),
        (
            "standalone topic_tools/Thing",
            "pyros1 has no node that replaces the nodelet topic_tools/Thing: run a node with",
        ),
        ("standalone rectify", "'rectify' is not the class of a nodelet"),
        ("load topic_tools/relay", "ERROR: nodelet: too few arguments: load pkg/Type manager is expected"),
        ("", "ERROR: nodelet: the first argument must be manager, load, standalone or unload, but there is none"),
        ("dance", "ERROR: nodelet: the first argument must be manager, load, standalone or unload, not 'dance'"),
    ],
)
def test_what_cannot_be_run_is_said(words: str, text: str, call_main: Callable[..., tuple[int, str, str]]) -> None:
    code, out, err = call_main(nodelet_program.main, "nodelet", *words.split())
    assert code == 1 and not out and text in err
    assert err.removeprefix(nodelet_program.USAGE).count("\n") == 1
