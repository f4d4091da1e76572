"""Command-line tools as nodes of launch files."""

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
from pyros1.finding.packages import OWN_PACKAGES
from pyros1.graph import Graph
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.msgs.std_srvs.srv import SetBool

PATIENCE = 20.0
LAUNCH_FILE = """
<launch>
  <group ns="robot">
    <node pkg="rostopic" type="rostopic" name="level" args="pub -r 20 level std_msgs/Float64 -- -1.5">
      <remap from="level" to="/base/level"/>
    </node>
    <node pkg="rosparam" type="rosparam" name="set_speed" args="set speed 0.5"/>
  </group>
  <node pkg="rosservice" type="rosservice" name="enable" args="call --wait /enable '{data: true}'"/>
</launch>
"""


@pytest.mark.slow
def test_tools_are_nodes_of_a_launch(environ: dict[str, str], make_node: Callable[..., Any], tmp_path: Path) -> None:
    """Feature: rostopic, rosservice and rosparam as nodes of launch files, with their names and remappings"""
    values: Queue[Any] = Queue()
    requests: Queue[Any] = Queue()
    node = make_node("listener")
    node.subscribe("/base/level", Float64, values.put)
    node.advertise_service("/enable", SetBool, lambda request: requests.put(request.data) or (True, ""))
    launch_file = tmp_path / "tools.launch"
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
        assert values.get(timeout=PATIENCE).data == -1.5
        assert Graph(node.master).state().publishers["/base/level"] == ["/robot/level"]
        assert requests.get(timeout=PATIENCE) is True
        deadline = node.now().to_sec() + PATIENCE
        while not node.params.get("/robot/speed", 0.0) and node.now().to_sec() < deadline:
            values.get(timeout=PATIENCE)
        assert node.params.get("/robot/speed") == 0.5
    finally:
        process.terminate()
        process.wait(PATIENCE)
